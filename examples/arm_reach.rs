//! An arm of seven joints brings its hand to a pose, within its effort limits, around a sphere that is in the way.
//!
//! `cargo run --release --example arm_reach` – writes a table and a page to `out/arm_reach/`.

mod common;

use std::error::Error;

use dualbody::dynamics::{frame_pose, gravity_forces};
use dualbody::model::FrameId;
use dualbody::trajopt::{
    Activation, Constraint, Cost, Ddp, DdpOptions, DdpSolution, FrameDistance, FramePose,
    InputError, Obstacle, Problem, StateError, Trajectory,
};
use dualbody::{ModelOptions, Simulator};
use nalgebra::{DVector, Vector3};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/panda.urdf");
const DT: f64 = 0.02;
const HORIZON: usize = 75;
const READY: [f64; 7] = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];
/// A configuration of which only the pose of the hand is asked for.
const GOAL: [f64; 7] = [1.2, 0.3, 0.2, -1.6, 0.1, 2.0, 1.2];
/// The hand's centre stays this far from the middle of the obstacle, m.
const CLEARANCE: f64 = 0.2;
const ITERATIONS: usize = 300;

fn main() -> Result<(), Box<dyn Error>> {
    let options = ModelOptions::default()
        .with_independent_mimic_joints()
        .with_locked_joint("panda_finger_joint1", &[0.04])
        .with_locked_joint("panda_finger_joint2", &[0.04]);
    let (model, _) = options.load_urdf_file(FILE)?;
    let hand = model.find_frame("panda_hand")?;
    let target = frame_pose(&model, &GOAL, hand);
    let simulator = Simulator::new(model).with_time_step(DT);

    let direct = solve(&reach(&simulator, hand, None));
    let middle = hand_at(&simulator, hand, &direct.trajectory.states[HORIZON / 3]);
    println!(
        "direct: {}, {} iterations",
        direct.status, direct.iterations
    );
    let problem = reach(&simulator, hand, Some(middle));
    let around = solve(&problem);
    println!(
        "around the sphere: {}, {} iterations, cost {:.4} instead of {:.4}, violation {:.1e}",
        around.status, around.iterations, around.cost, direct.cost, around.violation
    );
    assert!(direct.is_converged() && around.is_converged());

    let states = &around.trajectory.states;
    let distance = |x: &DVector<f64>| (hand_at(&simulator, hand, x) - middle).norm();
    let nearest = states.iter().map(distance).fold(f64::INFINITY, f64::min);
    let reached = frame_pose(simulator.model(), &states[HORIZON].as_slice()[..7], hand);
    let off = (reached.translation - target.translation).norm();
    let turned = (reached.rotation - target.rotation).norm();
    println!("{nearest:.4} m from its middle at the nearest; in the end {off:.1e} m off");
    assert!(nearest > CLEARANCE - 1e-5 && off < 1e-5 && turned < 1e-5);
    let (lower, upper) = simulator.effort_bounds();
    for u in &around.trajectory.inputs {
        assert!((0..7).all(|i| (lower[i]..=upper[i]).contains(&u[i])));
    }
    common::save("arm_reach", &simulator, &around.trajectory, "panda_hand")
}

fn reach(simulator: &Simulator, hand: FrameId, sphere: Option<Vector3<f64>>) -> Problem<Simulator> {
    let target = frame_pose(simulator.model(), &GOAL, hand);
    let start = [&READY[..], &[0.0; 7]].concat();
    let holding = gravity_forces(simulator.model(), &READY);
    let slow = Activation::Weighted([vec![0.1; 7], vec![1.0; 7]].concat());
    let running = Cost::new()
        .with(1.0, slow.clone(), StateError::to(&start))
        .with(
            1e-3,
            Activation::Quadratic,
            InputError::to(holding.as_slice()),
        );
    let pose = FramePose {
        frame: hand,
        target,
    };
    let (lower, upper) = simulator.effort_bounds();
    let problem = Problem::new(simulator.clone(), HORIZON, &start)
        .with_stage_cost(running)
        .with_final_cost(Cost::new().with(1.0, slow, StateError::to(&start)))
        .with_final_constraint(Constraint::equal_to_zero(simulator, pose))
        .with_input_bounds(&lower, &upper);
    let Some(middle) = sphere else {
        return problem;
    };
    let distance = FrameDistance {
        frame: hand,
        from: Obstacle::Point(middle),
    };
    problem.with_constraint(Constraint::within(distance, &[CLEARANCE], &[f64::INFINITY]))
}

fn solve(problem: &Problem<Simulator>) -> DdpSolution {
    let options = DdpOptions {
        max_iterations: ITERATIONS,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(problem, options);
    let bar = common::progress_bar(ITERATIONS);
    ddp.solve_with(problem, &Trajectory::resting(problem), bar)
        .clone()
}

fn hand_at(simulator: &Simulator, hand: FrameId, x: &DVector<f64>) -> Vector3<f64> {
    frame_pose(simulator.model(), &x.as_slice()[..7], hand).translation
}
