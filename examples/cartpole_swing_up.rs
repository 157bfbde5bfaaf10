//! A cart-pole swings up with at most 20 N on the cart, within its rail; then LQR stabilises it. The motion is planned by differential dynamic
//! programming and by single shooting with argmin. The closed loop runs for 10 s with a pole that is 5 % heavier than planned.
//!
//! `cargo run --release --example cartpole_swing_up` – writes tables and a page to `out/cartpole_swing_up/`.

mod common;

use std::{error::Error, f64::consts::PI};

use dualbody::control::{FiniteHorizonLqr, Lqr, LqrStage};
use dualbody::sim::{Rollout, RolloutStatus};
use dualbody::trajopt::{
    Activation, Constraint, Cost, Ddp, DdpOptions, DdpSolution, InputError, Minimizer, Problem,
    Robot, ShootingOptions, SingleShooting, StateError, Status, Trajectory, position_bounds,
};
use dualbody::{Model, Simulator, State, UnknownName};
use nalgebra::{DMatrix, dmatrix};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cartpole.urdf");
const NAME: &str = "cartpole_swing_up";
const DT: f64 = 0.02;
/// Steps of the plan: 3 s.
const HORIZON: usize = 150;
/// Steps of the closed loop: 10 s.
const STEPS: usize = 500;
const FORCE: f64 = 20.0;
const ITERATIONS: usize = 1000;

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let simulator = Simulator::new(model).with_time_step(DT);
    let simulator = simulator.with_actuated_joints(&["linear"])?;
    let problem = swing_up(&simulator);
    let plan = plan_by_ddp(&problem);
    let shot = plan_by_shooting(&problem, &plan);

    let real = with_heavier_pole(&simulator)?;
    follow(&simulator, &shot, &real)?;
    let rollout = follow(&simulator, &plan.trajectory, &real)?;
    common::save_plan(NAME, &simulator, &plan.trajectory, "pole")?;
    rollout.write_csv(simulator.model(), common::create(NAME, "closed_loop.csv")?)?;
    // The page shows the actual motion instead of the plan.
    let recording = common::record(NAME, simulator.model(), &rollout, "pole")?;
    common::save_page(NAME, &recording)
}

fn plan_by_ddp(problem: &Problem) -> DdpSolution {
    let options = DdpOptions {
        max_iterations: ITERATIONS,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(problem, options);
    let bar = common::progress_bar(ITERATIONS);
    let plan = ddp.solve_with(problem, &Trajectory::zero_input(problem), bar);
    report("Ddp", plan.status, plan.iterations, plan.cost);
    assert!(plan.is_converged());
    plan.clone()
}

/// From the same guess to another swing, a dearer one; from the plan of `Ddp` to the same cost.
fn plan_by_shooting(problem: &Problem, plan: &DdpSolution) -> Trajectory {
    let options = ShootingOptions {
        max_iterations: ITERATIONS,
        tolerance: 1e-3,
        ..ShootingOptions::default()
    };
    let mut shooting = SingleShooting::with_options(problem, options);
    let bar = common::progress_bar(ITERATIONS);
    let shot = shooting.solve_with(&Trajectory::zero_input(problem), Minimizer::NewtonCg, bar);
    report("argmin", shot.status, shot.iterations, shot.cost);
    let bar = common::progress_bar(ITERATIONS);
    let same = shooting.solve_with(&plan.trajectory, Minimizer::Lbfgs, bar);
    report("argmin from there", same.status, same.iterations, same.cost);
    assert!(shot.is_converged() && same.is_converged());
    assert!((same.cost / plan.cost - 1.0).abs() < 1e-3 && plan.cost <= shot.cost);
    shot.trajectory
}

fn report(name: &str, status: Status, iterations: usize, cost: f64) {
    println!("{name}: {status}, {iterations} iterations, cost {cost:.4}");
}

/// From hanging to upright, the cart on its rail.
fn swing_up(simulator: &Simulator) -> Problem {
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

/// Returns the robot with a pole that is 5 % heavier.
fn with_heavier_pole(planned: &Simulator) -> Result<Simulator, Box<dyn Error>> {
    let model = planned.model();
    let pole = model.joint_body(model.find_joint("pivot")?);
    let heavier = model.body(pole).inertia.scaled(1.05);
    let real = Simulator::new(model.clone().with_inertia(pole, heavier)).with_time_step(DT);
    Ok(real.with_actuated_joints(&["linear"])?)
}

/// Follows the plan by the LQR along it, then balances by the LQR at its end.
fn follow(
    planned: &Simulator,
    plan: &Trajectory,
    real: &Simulator,
) -> Result<Rollout, Box<dyn Error>> {
    assert!(plan.inputs.iter().all(|u| u[0].abs() <= FORCE));
    let (model, upright) = (planned.model(), State::neutral(planned.model()));
    let states = plan.states.iter().map(|x| planned.unpack(x.as_slice()));
    let states: Vec<State> = states.collect();
    let (along, lqr) = feedback(planned, &states, plan);
    let rollout = real.rollout(&states[0], STEPS, |time, state, u| {
        let k = (time / DT).round() as usize;
        let off = |from: &State| state.deviation(model, from);
        let force = match k < HORIZON {
            true => &plan.inputs[k] + along.control(k, &off(&states[k])),
            false => lqr.control(&off(&upright)),
        };
        u[0] = force[0].clamp(-FORCE, FORCE);
    });
    check(model, &rollout)?;
    Ok(rollout)
}

/// The gains along the plan, and those that balance at its end.
fn feedback(planned: &Simulator, states: &[State], plan: &Trajectory) -> (FiniteHorizonLqr, Lqr) {
    let (q, r) = (DMatrix::identity(4, 4), dmatrix![0.1]);
    let step = planned.linearize(&State::neutral(planned.model()), &[0.0]);
    let lqr = Lqr::discrete(&step.a, &step.b, &q, &r);
    assert!(lqr.is_stabilized());
    let stage = |k: usize| {
        let step = planned.linearize(&states[k], plan.inputs[k].as_slice());
        let (a, b, q, r) = (step.a, step.b, q.clone(), r.clone());
        LqrStage { a, b, q, r }
    };
    let stages: Vec<LqrStage> = (0..HORIZON).map(stage).collect();
    let along = FiniteHorizonLqr::discrete(&stages, &lqr.cost_to_go);
    (along, lqr)
}

/// The cart stays on its rail, and the pole stands from the end of the plan on.
fn check(model: &Model, rollout: &Rollout) -> Result<(), UnknownName> {
    assert_eq!(rollout.status, RolloutStatus::Completed);
    let rail = model.limits(model.find_joint("linear")?).upper;
    let reach = rollout.states.iter().map(|s| s.q[0].abs());
    let reach = reach.fold(0.0, f64::max);
    let caught = rollout.states[HORIZON].q[1];
    let last = rollout.last().deviation(model, &State::neutral(model));
    let last = last.norm();
    println!("run: {reach:.3} m along the rail, caught at {caught:.4} rad, in the end {last:.1e}");
    assert!(rail.is_some_and(|limit| reach < limit));
    let standing = rollout.states[HORIZON..].iter().all(|s| s.q[1].abs() < 0.3);
    assert!(standing && last < 1e-3, "the pole stands");
    Ok(())
}
