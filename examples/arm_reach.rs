//! An arm of seven joints moves its hand to a pose around a sphere, within its effort limits.
//!
//! `cargo run --release --example arm_reach` – writes a table and a page to `out/arm_reach/`.

mod common;

use std::error::Error;

use dualbody::dynamics::{frame_pose, gravity_forces};
use dualbody::model::{FrameId, Geometry};
use dualbody::spatial::Transform;
use dualbody::trajopt::{
    Activation, Constraint, Cost, Ddp, DdpOptions, DdpSolution, FrameDistance, FramePose,
    InputError, Obstacle, Problem, StateError, Trajectory,
};
use dualbody::{ModelOptions, Simulator};
use nalgebra::{DVector, Vector3};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/panda.urdf");
const NAME: &str = "arm_reach";
const DT: f64 = 0.02;
const HORIZON: usize = 75;
const READY: [f64; 7] = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];
/// A configuration that defines the target pose of the hand.
const GOAL: [f64; 7] = [1.2, 0.3, 0.2, -1.6, 0.1, 2.0, 1.2];
/// Obstacle in the way: a sphere, m.
const RADIUS: f64 = 0.1;
const COLOR: [f64; 4] = [0.9, 0.45, 0.2, 1.0];
/// Hand and wrist stay this far from its middle, m: they are thick.
const CLEARANCE: f64 = 0.2;
const KEPT_CLEAR: [&str; 3] = ["panda_hand", "panda_link7", "panda_link5"];
const ITERATIONS: usize = 300;

fn main() -> Result<(), Box<dyn Error>> {
    let arm = Arm::load()?;
    let direct = solve(&arm.reach());
    println!(
        "direct: {}, {} iterations",
        direct.status, direct.iterations
    );
    // Where the hand would pass.
    let middle = arm.place(arm.hand, &direct.trajectory.states[HORIZON / 3]);
    let around = solve(&arm.reach_around(middle));
    println!(
        "around the sphere: {}, {} iterations, cost {:.4} instead of {:.4}, violation {:.1e}",
        around.status, around.iterations, around.cost, direct.cost, around.violation
    );
    assert!(direct.is_converged() && around.is_converged());
    arm.check(&around.trajectory, middle);

    let mut recording = common::save_plan(NAME, &arm.simulator, &around.trajectory, "panda_hand")?;
    let sphere = Geometry::Sphere { radius: RADIUS };
    let place = Transform::from_translation(middle);
    recording.add_shape("obstacle", sphere, place, COLOR);
    recording.add_axes("goal of the hand", arm.target);
    common::save_page(NAME, &recording)
}

struct Arm {
    simulator: Simulator,
    hand: FrameId,
    kept_clear: Vec<FrameId>,
    target: Transform<f64>,
}

impl Arm {
    fn load() -> Result<Self, Box<dyn Error>> {
        let options = ModelOptions::default()
            .with_independent_mimic_joints()
            .with_locked_joint("panda_finger_joint1", &[0.04])
            .with_locked_joint("panda_finger_joint2", &[0.04]);
        let (model, _) = options.load_urdf_file(FILE)?;
        let hand = model.find_frame("panda_hand")?;
        let kept_clear = KEPT_CLEAR.iter().map(|name| model.find_frame(name));
        Ok(Self {
            hand,
            kept_clear: kept_clear.collect::<Result<_, _>>()?,
            target: frame_pose(&model, &GOAL, hand),
            simulator: Simulator::new(model).with_time_step(DT),
        })
    }

    fn reach(&self) -> Problem {
        let (simulator, frame, target) = (&self.simulator, self.hand, self.target);
        let start = [&READY[..], &[0.0; 7]].concat();
        let holding = InputError::to(gravity_forces(simulator.model(), &READY).as_slice());
        let slow = Activation::Weighted([vec![0.1; 7], vec![1.0; 7]].concat());
        let running = Cost::new()
            .with(1.0, slow.clone(), StateError::to(&start))
            .with(1e-3, Activation::Quadratic, holding);
        let (lower, upper) = simulator.effort_bounds();
        let arrive = Constraint::equal_to_zero(simulator, FramePose { frame, target });
        Problem::new(simulator.clone(), HORIZON, &start)
            .with_stage_cost(running)
            .with_final_cost(Cost::new().with(1.0, slow, StateError::to(&start)))
            .with_final_constraint(arrive)
            .with_input_bounds(&lower, &upper)
    }

    fn reach_around(&self, middle: Vector3<f64>) -> Problem {
        let from = Obstacle::Point(middle);
        self.kept_clear
            .iter()
            .fold(self.reach(), |problem, &frame| {
                let distance = FrameDistance { frame, from };
                problem.with_constraint(Constraint::within(
                    distance,
                    &[CLEARANCE],
                    &[f64::INFINITY],
                ))
            })
    }

    /// Clear of the sphere, within the effort limits, and in the end where it should be.
    fn check(&self, plan: &Trajectory, middle: Vector3<f64>) {
        let distances = plan.states.iter().flat_map(|x| {
            let frames = self.kept_clear.iter();
            frames.map(move |&frame| (self.place(frame, x) - middle).norm())
        });
        let nearest = distances.fold(f64::INFINITY, f64::min);
        let last = &plan.states[HORIZON].as_slice()[..7];
        let reached = frame_pose(self.simulator.model(), last, self.hand);
        let off = (reached.translation - self.target.translation).norm();
        let turned = (reached.rotation - self.target.rotation).norm();
        println!("at least {nearest:.4} m from its middle; at the end {off:.1e} m from the target");
        assert!(nearest > CLEARANCE - 1e-5 && off < 1e-5 && turned < 1e-5);
        let (lower, upper) = self.simulator.effort_bounds();
        for u in &plan.inputs {
            assert!((0..7).all(|i| (lower[i]..=upper[i]).contains(&u[i])));
        }
    }

    fn place(&self, frame: FrameId, x: &DVector<f64>) -> Vector3<f64> {
        frame_pose(self.simulator.model(), &x.as_slice()[..7], frame).translation
    }
}

fn solve(problem: &Problem) -> DdpSolution {
    let options = DdpOptions {
        max_iterations: ITERATIONS,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(problem, options);
    let bar = common::progress_bar(ITERATIONS);
    ddp.solve_with(problem, &Trajectory::zero_input(problem), bar)
        .clone()
}
