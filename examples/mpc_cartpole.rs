//! Model-predictive control of a cart-pole: the cart follows a target that changes sides, while the pole is pushed.
//!
//! `cargo run --release --example mpc_cartpole` – writes a table and a page to `out/mpc_cartpole/`.

mod common;

use std::error::Error;
use std::time::Instant;

use dualbody::sim::Rollout;
use dualbody::trajopt::{
    Activation, Cost, DdpOptions, InputError, Problem, RecedingHorizon, Robot, StateError,
    Trajectory,
};
use dualbody::view::Recording;
use dualbody::{Model, Simulator, State};
use nalgebra::DVector;

const NAME: &str = "mpc_cartpole";
const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cartpole.urdf");
const DT: f64 = 0.02;
/// 1 s ahead.
const HORIZON: usize = 50;
/// Iterations at every step.
const BUDGET: usize = 3;
const STEPS: usize = 1000;
/// The target jumps after so many steps.
const STAY: usize = 250;
/// Push on the pole half way between two jumps, rad/s.
const PUSH: f64 = 0.8;
const FORCE: f64 = 20.0;

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let simulator = Simulator::new(model).with_time_step(DT);
    let simulator = simulator.with_actuated_joints(&["linear"])?;
    let mut state = State::neutral(simulator.model());
    let problem =
        Problem::new(simulator.clone(), HORIZON, &[0.0; 4]).with_input_bounds(&[-FORCE], &[FORCE]);
    let options = DdpOptions {
        max_iterations: BUDGET,
        ..DdpOptions::default()
    };
    let guess = Trajectory::zero_input(&problem);
    let mut controller = RecedingHorizon::from_guess(problem, options, guess);

    let mut record = Rollout::new(simulator.model(), DT, vec![state.clone()], Vec::new());
    let (mut longest, mut tilt) = (0.0_f64, 0.0_f64);
    let mut bar = common::progress_bar(BUDGET);
    for k in 0..STEPS {
        if k % STAY == 0 {
            aim(&mut controller, target(k));
        }
        let clock = Instant::now();
        let u = controller.control_with(simulator.pack(&state).as_slice(), &mut bar)[0];
        longest = longest.max(clock.elapsed().as_secs_f64());
        assert!(u.abs() <= FORCE);
        state = simulator.step(&state, &[u]);
        if k % STAY == STAY / 2 {
            state.v[1] += PUSH;
        }
        tilt = tilt.max(state.q[1].abs());
        record.states.push(state.clone());
        record.inputs.push(DVector::from_element(1, u));
        if k % STAY == STAY - 1 {
            let miss = state.q[0] - target(k);
            println!(
                "at {:.1} s the cart is {miss:.4} m from its target",
                k as f64 * DT
            );
            assert!(miss.abs() < 0.1);
        }
    }
    println!(
        "largest tilt {tilt:.3} rad; {:.0} µs for the longest step",
        longest * 1e6
    );
    assert!(tilt < 0.5, "the pole stays up");
    let model = simulator.model();
    record.write_csv(model, common::create(NAME, "closed_loop.csv")?)?;
    let mut recording = Recording::from_rollout(model, &record);
    let targets = (0..=STEPS).map(|k| target(k.min(STEPS - 1)));
    recording.add_series("target of the cart", targets);
    common::save_page(NAME, &recording)
}

/// Target of the cart at a step, m.
fn target(k: usize) -> f64 {
    if (k / STAY).is_multiple_of(2) {
        0.5
    } else {
        -0.5
    }
}

/// Moves the target of the costs.
fn aim(controller: &mut RecedingHorizon, y: f64) {
    let at = || StateError::to(&[y, 0.0, 0.0, 0.0]);
    let weights = || Activation::Weighted(vec![1.0, 5.0, 0.1, 0.1]);
    let effort = InputError::to(&[0.0]);
    let running = Cost::new()
        .with(1.0, weights(), at())
        .with(1e-3, Activation::Quadratic, effort);
    let problem = controller.problem_mut();
    problem.set_stage_cost(running);
    problem.set_final_cost(Cost::new().with(10.0, weights(), at()));
}
