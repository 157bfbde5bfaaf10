//! A closed loop: a four-bar linkage. It is assembled from an open start. Computed torque at its crank makes the rocker follow a sine; the torque is
//! compared with the balance of power.
//!
//! `cargo run --release --example four_bar` – writes `out/four_bar/rollout.csv` and a page beside it.

use std::error::Error;
use std::fs::File;

use dualbody::constraint::{Anchor, Constraint};
use dualbody::dynamics::{kinetic_energy, potential_energy};
use dualbody::sim::{Rollout, StepScratch};
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

    let torn = State::new(&[0.2, -0.9, 0.4], &[0.0; 3]);
    let gap = norm(&simulator.constraint_errors(&torn));
    let closed = simulator.assemble(&torn)?;
    println!(
        "the loop was open by {gap:.3} m, by {:.0e} after {} steps",
        closed.error, closed.iterations
    );
    let rollout = follow(&simulator, &closed.state);
    let opening = rollout.states.iter();
    let opening = opening.map(|s| norm(&simulator.constraint_errors(s)));
    check(&simulator, &rollout, opening.clone().fold(0.0, f64::max));

    std::fs::create_dir_all("out/four_bar")?;
    let model = simulator.model();
    rollout.write_csv(model, File::create("out/four_bar/rollout.csv")?)?;
    let mut recording = Recording::of_simulation(&simulator, &rollout).with_title("four-bar");
    recording.add_series("opening of the loop / m", opening);
    Ok(recording.save_html("out/four_bar/index.html")?)
}

/// Position, velocity and acceleration of the rocker at a time.
fn wanted(start: f64, t: f64) -> (f64, f64, f64) {
    let (sin, cos) = (FREQUENCY * t).sin_cos();
    let rate = SWING * FREQUENCY;
    (
        start + SWING * (1.0 - cos),
        rate * sin,
        rate * FREQUENCY * cos,
    )
}

/// Computed torque at the crank: the acceleration of the rocker is affine in it, so two accelerations determine it.
fn follow(simulator: &Simulator, start: &State) -> Rollout {
    let mut scratch = StepScratch::new(simulator);
    let mut rocker = |state: &State, torque: f64| {
        simulator.acceleration_into(state, &[torque], &mut scratch)[ROCKER]
    };
    simulator.rollout(start, STEPS, |t, state, u| {
        let (q, v, a) = wanted(start.q[ROCKER], t);
        let aim = a + 2.0 * GAIN * (v - state.v[ROCKER]) + GAIN * GAIN * (q - state.q[ROCKER]);
        let without = rocker(state, 0.0);
        u[0] = (aim - without) / (rocker(state, 1.0) - without);
    })
}

/// The rocker follows, the loop stays closed, and the work of the motor is the energy that the linkage gains.
fn check(simulator: &Simulator, rollout: &Rollout, opening: f64) {
    let start = &rollout.states[0];
    let moments = rollout.times().zip(&rollout.states);
    let off = moments.map(|(t, s)| (s.q[ROCKER] - wanted(start.q[ROCKER], t).0).abs());
    let off = off.fold(0.0, f64::max);
    let turns = rollout
        .states
        .windows(2)
        .map(|s| s[1].q[CRANK] - s[0].q[CRANK]);
    let work: f64 = turns
        .zip(&rollout.inputs)
        .map(|(turn, u)| u[0] * turn)
        .sum();
    let energy = |s: &State| {
        let (model, q, v) = (simulator.model(), s.q.as_slice(), s.v.as_slice());
        kinetic_energy(model, q, v) + potential_energy(model, q)
    };
    let gained = energy(rollout.last()) - energy(start);
    println!(
        "the rocker follows within {off:.1e} rad, the loop stays closed within {opening:.1e} m"
    );
    println!("work of the motor {work:.6} J, energy gained {gained:.6} J");
    assert!(off < 1e-3 && opening < 1e-6);
    assert!((work - gained).abs() < 1e-4);
}

fn norm(errors: &[f64]) -> f64 {
    errors.iter().map(|e| e * e).sum::<f64>().sqrt()
}
