//! A crane carries its load over a ball, with clearance at all times and not only at the nodes. The motion is planned by direct transcription with fifty
//! intervals of 50 ms.
//!
//! `cargo run --release --features transcription --example obstacle_course` – writes a table and a page to
//! `out/obstacle_course/`.

mod common;

use std::{error::Error, f64::consts::PI};

use dualbody::dynamics::frame_pose;
use dualbody::model::{FrameId, Geometry};
use dualbody::spatial::Transform;
use dualbody::trajopt::{
    Activation, Constraint, Cost, Curve, FrameDistance, InputError, Obstacle, Problem, StateError,
    Trajectory, Transcription, TranscriptionSolution,
};
use dualbody::{Model, Simulator};
use nalgebra::{DVector, Vector3};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cartpole.urdf");
const NAME: &str = "obstacle_course";
const DT: f64 = 0.05;
const HORIZON: usize = 50;
/// Largest force on the trolley, N.
const FORCE: f64 = 20.0;
/// From one side to the other, the load hanging still.
const START: [f64; 4] = [-1.0, PI, 0.0, 0.0];
const GOAL: [f64; 4] = [1.0, PI, 0.0, 0.0];
/// The ball, half in the ground: its middle and its radius, m. The load is at a height of 0.2 m.
const BALL: [f64; 3] = [0.0, 0.0, 0.0];
const RADIUS: f64 = 0.36;
const COLOR: [f64; 4] = [0.5, 0.55, 0.6, 1.0];
/// Distance of the load from its middle that is to be kept at nodes and middles; between them the way may bend inwards
/// by a little.
const CLEARANCE: f64 = 0.4;
/// Number of looks between two nodes.
const FINE: usize = 10;

fn main() -> Result<(), Box<dyn Error>> {
    let model = crane()?;
    let load = model.find_frame("load")?;
    let simulator = Simulator::new(model).with_time_step(DT);
    let simulator = simulator.with_actuated_joints(&["linear"])?;

    let [direct, over] = [0.0, CLEARANCE].map(|clearance| {
        let plan = solve(&carry(&simulator, load, clearance));
        println!(
            "{} after {} iterations, cost {:.4}, at least {:.4} m from the middle of the ball",
            plan.status,
            plan.iterations,
            plan.cost,
            nearest(&simulator, load, &plan.curve)
        );
        assert!(plan.is_converged() && plan.violation < 1e-6);
        plan
    });
    // The ball is in the way.
    assert!(nearest(&simulator, load, &direct.curve) < RADIUS);
    assert!(nearest(&simulator, load, &over.curve) > RADIUS);
    assert!(over.cost > direct.cost);
    assert!(over.curve.inputs.iter().all(|u| u[0].abs() <= FORCE));
    let last = &over.curve.states[HORIZON];
    assert!((last - DVector::from_row_slice(&GOAL)).amax() < 1e-6);
    let fine = simulator.clone().with_time_step(DT / FINE as f64);
    let motion = sampled(&simulator, &over.curve);
    let mut recording = common::save_plan(NAME, &fine, &motion, "load")?;
    let (ball, place) = (Geometry::Sphere { radius: RADIUS }, at(BALL));
    recording.add_shape("ball", ball, place, COLOR);
    common::save_page(NAME, &recording)
}

/// A cart with its pole downwards and a load at the end.
fn crane() -> Result<Model, Box<dyn Error>> {
    Ok(Model::from_urdf_file(FILE)?.with_frame("load", "pole", &at([0.0, 0.0, 1.0]))?)
}

fn at(place: [f64; 3]) -> Transform<f64> {
    Transform::from_translation(place.into())
}

/// With the least effort, the load `clearance` away from the middle of the ball at least.
fn carry(simulator: &Simulator, load: FrameId, clearance: f64) -> Problem {
    let effort = Cost::new().with(1e-2, Activation::Quadratic, InputError::to_zero(simulator));
    let distance = FrameDistance {
        frame: load,
        from: Obstacle::Point(Vector3::from(BALL)),
    };
    let arrive = Constraint::equal_to_zero(simulator, StateError::to(&GOAL));
    Problem::new(simulator.clone(), HORIZON, &START)
        .with_stage_cost(effort)
        .with_constraint(Constraint::within(distance, &[clearance], &[f64::INFINITY]))
        .with_final_constraint(arrive)
        .with_input_bounds(&[-FORCE], &[FORCE])
}

/// From a guess that goes straight from start to goal, which the dynamics do not.
fn solve(problem: &Problem) -> TranscriptionSolution {
    let solver = Transcription::new();
    let mut guess = Trajectory::zero_input(problem);
    for (k, x) in guess.states.iter_mut().enumerate() {
        x[0] += (GOAL[0] - START[0]) * k as f64 / HORIZON as f64;
    }
    let bar = common::progress_bar(solver.options().max_iterations);
    solver.solve_with(problem, &guess, bar)
}

/// The plan at times so near one another that it can be watched.
fn sampled(simulator: &Simulator, curve: &Curve) -> Trajectory {
    let times = |n: usize| (0..n).map(|k| k as f64 * DT / FINE as f64);
    let states = times(HORIZON * FINE + 1).map(|t| curve.state(simulator, t));
    Trajectory {
        states: states.collect(),
        inputs: times(HORIZON * FINE).map(|t| curve.input(t)).collect(),
    }
}

fn nearest(simulator: &Simulator, load: FrameId, curve: &Curve) -> f64 {
    let distance = |x: &DVector<f64>| {
        let at = frame_pose(simulator.model(), &x.as_slice()[..2], load);
        (at.translation - Vector3::from(BALL)).norm()
    };
    let plan = sampled(simulator, curve);
    let distances = plan.states.iter().map(distance);
    distances.fold(f64::INFINITY, f64::min)
}
