//! A cart-pole swings up with at most 20 N on the cart, within its rail, and is caught by LQR: planned by differential dynamic
//! programming, then run for 10 s in closed loop on a pole that is 5 % heavier than the plan knows.
//!
//! `cargo run --release --example cartpole_swing_up` – writes tables and a page to `out/cartpole_swing_up/`.

mod common;

use std::{error::Error, f64::consts::PI, fs::File, io::BufWriter};

use dualbody::control::Lqr;
use dualbody::sim::{Rollout, RolloutStatus};
use dualbody::trajopt::{
    Activation, Constraint, Cost, Ddp, DdpOptions, DdpSolution, InputError, Problem, Robot,
    StateError, Trajectory, position_bounds,
};
use dualbody::{Model, Simulator, State};
use nalgebra::{DMatrix, dmatrix};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cartpole.urdf");
const NAME: &str = "cartpole_swing_up";
const DT: f64 = 0.02;
/// Steps of the plan: 3 s.
const HORIZON: usize = 150;
/// Steps of the closed loop: 10 s.
const STEPS: usize = 500;
const FORCE: f64 = 20.0;

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let simulator = Simulator::new(model).with_time_step(DT);
    let simulator = simulator.with_actuated_joints(&["linear"])?;
    let problem = swing_up(&simulator);
    let options = DdpOptions {
        max_iterations: 500,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(&problem, options);
    let bar = common::progress_bar(500);
    let plan = ddp.solve_with(&problem, &Trajectory::resting(&problem), bar);
    println!(
        "plan: {} after {} iterations, cost {:.4}, violation {:.1e}",
        plan.status, plan.iterations, plan.cost, plan.violation
    );
    assert!(plan.is_converged());
    let largest = plan.trajectory.inputs.iter().map(|u| u[0].abs());
    assert!(largest.fold(0.0, f64::max) <= FORCE);
    common::save(NAME, &simulator, &plan.trajectory, "pole")?;

    let rollout = run(&simulator, &problem, plan)?;
    let file = File::create(format!("out/{NAME}/closed_loop.csv"))?;
    rollout.write_csv(simulator.model(), BufWriter::new(file))?;
    // The page shows what happened instead of what was planned.
    common::save_page(NAME, simulator.model(), &rollout, "pole")
}

/// From hanging to upright, the cart on its rail.
fn swing_up(simulator: &Simulator) -> Problem<Simulator> {
    let upright = || StateError::to_neutral(simulator);
    let running = Cost::new()
        .with(0.1, Activation::Quadratic, upright())
        .with(1e-2, Activation::Quadratic, InputError::to_zero(simulator));
    let (lower, upper) = position_bounds(simulator);
    let rail = Constraint::within(upright(), &lower, &upper);
    Problem::new(simulator.clone(), HORIZON, &[0.0, PI, 0.0, 0.0])
        .with_stage_cost(running)
        .with_final_cost(Cost::new().with(10.0, Activation::Quadratic, upright()))
        .with_final_constraint(Constraint::equal_to_zero(simulator, upright()))
        .with_constraint(rail)
        .with_input_bounds(&[-FORCE], &[FORCE])
}

/// Follows the plan with its gains, then balances.
fn run(
    planned: &Simulator,
    problem: &Problem<Simulator>,
    plan: &DdpSolution,
) -> Result<Rollout, Box<dyn Error>> {
    let (model, upright) = (planned.model(), State::neutral(planned.model()));
    let pole = model.joint_body(model.find_joint("pivot")?);
    let heavier = model.body(pole).inertia.scaled(1.05);
    let real = Simulator::new(model.clone().with_inertia(pole, heavier)).with_time_step(DT);
    let real = real.with_actuated_joints(&["linear"])?;

    let step = planned.linearize(&upright, &[0.0]);
    let lqr = Lqr::discrete(&step.a, &step.b, &DMatrix::identity(4, 4), &dmatrix![0.1]);
    assert!(lqr.is_stabilized());
    let hanging = State::new(&[0.0, PI], &[0.0, 0.0]);
    let rollout = real.rollout(&hanging, STEPS, |time, state, u| {
        let k = (time / DT).round() as usize;
        let force = match k < HORIZON {
            true => plan.control(problem, k, planned.pack(state).as_slice()),
            false => lqr.control(&state.deviation(model, &upright)),
        };
        u[0] = force[0].clamp(-FORCE, FORCE);
    });
    assert_eq!(rollout.status, RolloutStatus::Completed);
    let rail = model.limits(model.find_joint("linear")?);
    let reach = rollout
        .states
        .iter()
        .map(|s| s.q[0].abs())
        .fold(0.0, f64::max);
    let caught = rollout.states[HORIZON].q[1];
    let last = rollout.last().deviation(model, &upright).norm();
    println!("run: {reach:.3} m along the rail, caught at {caught:.4} rad, in the end {last:.1e}");
    assert!(rail.upper.is_some_and(|limit| reach < limit));
    let standing = rollout.states[HORIZON..].iter().all(|s| s.q[1].abs() < 0.3);
    assert!(standing && last < 1e-3, "the pole stands");
    Ok(rollout)
}
