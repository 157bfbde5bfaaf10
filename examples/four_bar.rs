//! A four-bar linkage: a closed loop. Assembled from a start that is torn apart, it is driven at its crank by computed torque so
//! that the rocker follows a sine, and the torque is checked against the balance of power.
//!
//! `cargo run --release --example four_bar` – writes `out/four_bar/rollout.csv` and a page beside it.

use std::error::Error;
use std::fs::File;

use dualbody::constraint::{Anchor, Constraint};
use dualbody::dynamics::{kinetic_energy, potential_energy};
use dualbody::sim::StepScratch;
use dualbody::view::Recording;
use dualbody::{Integrator, Model, Simulator, State};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/four_bar.urdf");
/// The rocker swings by so much about its place, rad, at so many rad/s.
const SWING: f64 = -0.1;
const FREQUENCY: f64 = 4.0;
/// The error of the rocker obeys ë + 2 ω ė + ω² e = 0 with this ω, 1/s.
const GAIN: f64 = 20.0;
const DT: f64 = 1e-3;
const STEPS: usize = 6000;
/// The tree's joints.
const CRANK: usize = 0;
const ROCKER: usize = 2;

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let ends = [
        Anchor::frame(&model, "loop_a")?,
        Anchor::frame(&model, "loop_b")?,
    ];
    let simulator = Simulator::new(model)
        .with_constraints(vec![Constraint::ball(ends)])
        .with_integrator(Integrator::RungeKutta4)
        .with_time_step(DT)
        .with_actuated_joints(&["crank_joint"])?;
    let model = simulator.model();

    let torn = State::new(&[0.2, -0.9, 0.4], &[0.0; 3]);
    let gap = norm(&simulator.constraint_errors(&torn));
    let closed = simulator.assemble(&torn)?;
    println!(
        "the loop was {gap:.3} m open, {:.0e} after {} steps",
        closed.error, closed.iterations
    );
    let start = closed.state;

    // q̈ of the rocker is affine in the torque of the crank: two accelerations tell how.
    let mut scratch = StepScratch::new(&simulator);
    let mut rocker = |state: &State, torque: f64| {
        simulator.acceleration_into(state, &[torque], &mut scratch)[ROCKER]
    };
    let wanted = |t: f64| {
        let (sin, cos) = (FREQUENCY * t).sin_cos();
        let rate = SWING * FREQUENCY;
        (
            start.q[ROCKER] + SWING * (1.0 - cos),
            rate * sin,
            rate * FREQUENCY * cos,
        )
    };
    let rollout = simulator.rollout(&start, STEPS, |t, state, u| {
        let (q, v, a) = wanted(t);
        let aim = a + 2.0 * GAIN * (v - state.v[ROCKER]) + GAIN * GAIN * (q - state.q[ROCKER]);
        let at_rest = rocker(state, 0.0);
        u[0] = (aim - at_rest) / (rocker(state, 1.0) - at_rest);
    });

    let (mut off, mut open, mut work) = (0.0_f64, 0.0_f64, 0.0);
    for (k, state) in rollout.states.iter().enumerate() {
        off = off.max((state.q[ROCKER] - wanted(DT * k as f64).0).abs());
        open = open.max(norm(&simulator.constraint_errors(state)));
        if let Some(u) = rollout.inputs.get(k) {
            let turned = rollout.states[k + 1].q[CRANK] - state.q[CRANK];
            work += u[0] * turned;
        }
    }
    let energy = |s: &State| {
        let (q, v) = (s.q.as_slice(), s.v.as_slice());
        kinetic_energy(model, q, v) + potential_energy(model, q)
    };
    let gained = energy(rollout.last()) - energy(&start);
    println!("the rocker follows within {off:.1e} rad, the loop stays closed within {open:.1e} m");
    println!("work of the motor {work:.6} J, energy gained {gained:.6} J");
    assert!(off < 1e-3 && open < 1e-6);
    assert!((work - gained).abs() < 1e-4);

    std::fs::create_dir_all("out/four_bar")?;
    rollout.write_csv(model, File::create("out/four_bar/rollout.csv")?)?;
    let mut recording = Recording::from_rollout(model, &rollout).with_title("four-bar");
    let errors = rollout
        .states
        .iter()
        .map(|s| norm(&simulator.constraint_errors(s)));
    recording.add_series("opening of the loop / m", errors);
    Ok(recording.save_html("out/four_bar/index.html")?)
}

fn norm(errors: &[f64]) -> f64 {
    errors.iter().map(|e| e * e).sum::<f64>().sqrt()
}
