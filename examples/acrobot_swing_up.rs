//! The acrobot, two bars with a motor at the elbow only, swings up from hanging.
//!
//! `cargo run --release --example acrobot_swing_up` – writes a table and a page to `out/acrobot_swing_up/`.

mod common;

use std::{error::Error, f64::consts::PI};

use dualbody::trajopt::{
    Activation, Constraint, Cost, Ddp, DdpOptions, InputError, Problem, StateError, Trajectory,
};
use dualbody::{Model, Simulator};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/acrobot.urdf");
const NAME: &str = "acrobot_swing_up";
const DT: f64 = 0.02;
/// 5 s.
const HORIZON: usize = 250;
/// Upright: the first bar half a turn from hanging, the second in line with it.
const UPRIGHT: [f64; 4] = [PI, 0.0, 0.0, 0.0];
const ITERATIONS: usize = 1000;

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let simulator = Simulator::new(model).with_time_step(DT);
    let simulator = simulator.with_actuated_joints(&["elbow"])?;
    let (lower, upper) = simulator.effort_bounds();

    let upright = || StateError::to(&UPRIGHT);
    let weights = || Activation::Weighted(vec![1.0, 1.0, 0.1, 0.1]);
    let running = Cost::new().with(0.1, weights(), upright()).with(
        1e-2,
        Activation::Quadratic,
        InputError::to_zero(&simulator),
    );
    let problem = Problem::new(simulator.clone(), HORIZON, &[0.0; 4])
        .with_stage_cost(running)
        .with_final_cost(Cost::new().with(100.0, weights(), upright()))
        .with_final_constraint(Constraint::equal_to_zero(&simulator, upright()))
        .with_input_bounds(&lower, &upper);

    let options = DdpOptions {
        max_iterations: ITERATIONS,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(&problem, options);
    let bar = common::progress_bar(ITERATIONS);
    let plan = ddp.solve_with(&problem, &Trajectory::zero_input(&problem), bar);
    let last = &plan.trajectory.states[HORIZON];
    let torques = plan.trajectory.inputs.iter().map(|u| u[0].abs());
    let largest = torques.fold(0.0, f64::max);
    println!(
        "{} after {} iterations, cost {:.3}, at most {largest:.2} N m, in the end {:.6?}",
        plan.status,
        plan.iterations,
        plan.cost,
        last.as_slice()
    );
    assert!(plan.is_converged() && plan.gap == 0.0);
    assert!(largest <= upper[0]);
    for (x, goal) in last.iter().zip(UPRIGHT) {
        assert!((x - goal).abs() < 1e-5, "{x} instead of {goal}");
    }
    let motion = common::save_plan(NAME, &simulator, &plan.trajectory, "tip")?;
    common::save_page(NAME, &motion)
}
