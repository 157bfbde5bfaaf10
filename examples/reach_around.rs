//! An arm reaches from below a shelf to above it, around the edge of the board and around itself. Distances of its links from the board and from each other
//! are constraints, at the nodes and between them.
//!
//! `cargo run --release --example reach_around` – writes a table and a page to `out/reach_around/`.

mod common;

use std::error::Error;

use dualbody::contact::LinkShapes;
use dualbody::dynamics::gravity_forces;
use dualbody::model::{Object, World};
use dualbody::spatial::Transform;
use dualbody::trajopt::{
    Activation, Constraint, ConstraintOptions, Cost, Ddp, DdpOptions, DdpSolution, InputError,
    LinkDistances, Problem, StateError, Trajectory,
};
use dualbody::{Base, ModelOptions, Simulator};
use nalgebra::DVector;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/ur5.urdf");
const NAME: &str = "reach_around";
const DT: f64 = 0.03;
const HORIZON: usize = 60;
/// Below the board, folded beside it, above it; the hand points down.
const START: [f64; 6] = [0.0, -1.0, 1.656, -2.227, -1.571, 0.0];
const FOLDED: [f64; 6] = [0.0, -2.0, 2.4, -1.971, -1.571, 0.0];
const GOAL: [f64; 6] = [0.0, -1.06, 0.553, -1.064, -1.571, 0.0];
/// Distance to keep, m, and how much less is allowed between two samples.
const CLEARANCE: f64 = 0.02;
const BETWEEN: f64 = 0.01;
/// Violation of constraints that is allowed, m and rad.
const TOLERANCE: f64 = 1e-3;
const ITERATIONS: usize = 300;
/// Pairs of links that stay clear of each other.
const PAIRS: [[&str; 2]; 4] = [
    ["arm/forearm_link", "board"],
    ["arm/wrist_1_link", "board"],
    ["arm/wrist_3_link", "board"],
    ["arm/wrist_3_link", "arm/upper_arm_link"],
];

fn main() -> Result<(), Box<dyn Error>> {
    let simulator = arm_at_a_shelf()?;
    let shapes = LinkShapes::new(simulator.model());
    let direct = solve(&reach(&simulator), straight(&simulator, &[START, GOAL]));
    let through = nearest(&simulator, &shapes, &direct.trajectory)?;
    let clear = LinkDistances::new(simulator.model(), shapes.clone(), &PAIRS)?;
    let clear = clear.with_samples_between(2).at_least(CLEARANCE);
    let problem = reach(&simulator).with_constraint(clear);
    let around = solve(&problem, straight(&simulator, &[START, FOLDED, GOAL]));
    let past = nearest(&simulator, &shapes, &around.trajectory)?;
    for (what, plan, distance) in [("direct", &direct, through), ("around", &around, past)] {
        println!(
            "{what}: {} after {} iterations, cost {:.3}, nearest {distance:.4} m",
            plan.status, plan.iterations, plan.cost
        );
    }
    let end = &around.trajectory.states[HORIZON].as_slice()[..6];
    let off = end.iter().zip(GOAL).map(|(q, goal)| (q - goal).abs());
    assert!(around.is_converged() && off.fold(0.0, f64::max) < 2.0 * TOLERANCE);
    assert!(through < 0.0 && past > CLEARANCE - BETWEEN);
    assert!(around.cost > direct.cost);

    let recording = common::save_plan(NAME, &simulator, &around.trajectory, "arm/tool0")?;
    common::save_page(NAME, &recording)
}

/// The board is a fixed object of the world, and so a link with a shape.
fn arm_at_a_shelf() -> Result<Simulator, Box<dyn Error>> {
    let options = ModelOptions::default().with_base(Base::Fixed);
    let (arm, _) = options.load_urdf_file(FILE)?;
    let mut world = World::new(NAME);
    world.add(&arm, "arm/", &Transform::identity())?;
    let at = Transform::from_translation([0.75, 0.0, 0.42].into());
    let oak = Object::fixed().with_color([0.6, 0.45, 0.3, 1.0]);
    world.add_box("board", [0.7, 1.0, 0.04], &oak.at(at))?;
    Ok(Simulator::new(world.build()?).with_time_step(DT))
}

fn state(q: &[f64]) -> Vec<f64> {
    [q, &[0.0; 6]].concat()
}

/// With the least speed and effort from start to goal.
fn reach(simulator: &Simulator) -> Problem {
    let slow = Activation::Weighted([[0.1; 6], [1.0; 6]].concat());
    let holding = InputError::to(gravity_forces(simulator.model(), &GOAL).as_slice());
    let running = Cost::new()
        .with(1.0, slow, StateError::to(&state(&GOAL)))
        .with(1e-3, Activation::Quadratic, holding);
    let arrive = Constraint::equal_to_zero(simulator, StateError::to(&state(&GOAL)));
    let (lower, upper) = simulator.effort_bounds();
    Problem::new(simulator.clone(), HORIZON, &state(&START))
        .with_stage_cost(running)
        .with_final_constraint(arrive)
        .with_input_bounds(&lower, &upper)
}

/// A guess: straight from place to place at an even speed, the torques those that hold still.
fn straight(simulator: &Simulator, places: &[[f64; 6]]) -> Trajectory {
    let legs = (places.len() - 1) as f64;
    let at = |k: usize| {
        let s = legs * k as f64 / HORIZON as f64;
        let leg = (s as usize).min(places.len() - 2);
        let (from, to, part) = (places[leg], places[leg + 1], s - leg as f64);
        DVector::from_fn(6, |j, _| from[j] * (1.0 - part) + to[j] * part)
    };
    let state = |k: usize| {
        let speed = (at(k) - at(k.saturating_sub(1))) / DT;
        DVector::from_iterator(12, at(k).iter().chain(&speed).copied())
    };
    let holding = |k: usize| gravity_forces(simulator.model(), at(k).as_slice());
    Trajectory {
        states: (0..=HORIZON).map(state).collect(),
        inputs: (0..HORIZON).map(holding).collect(),
    }
}

fn solve(problem: &Problem, guess: Trajectory) -> DdpSolution {
    let options = DdpOptions {
        max_iterations: ITERATIONS,
        // Distances are nonsmooth where the nearest edge changes.
        tolerance: 1e-5,
        constraints: ConstraintOptions {
            tolerance: TOLERANCE,
            ..ConstraintOptions::default()
        },
        ..DdpOptions::default()
    };
    let bar = common::progress_bar(ITERATIONS);
    let mut ddp = Ddp::with_options(problem, options);
    ddp.solve_with(problem, &guess, bar).clone()
}

/// The least distance of all pairs, at the nodes and at nineteen moments between two of them.
fn nearest(
    simulator: &Simulator,
    shapes: &LinkShapes,
    plan: &Trajectory,
) -> Result<f64, Box<dyn Error>> {
    let mut least = f64::INFINITY;
    for nodes in plan.states.windows(2) {
        let way: DVector<f64> = &nodes[1] - &nodes[0];
        for k in 0..20 {
            let x = &nodes[0] + &way * (f64::from(k) / 20.0);
            for [first, second] in PAIRS {
                let near = shapes.nearest(simulator.model(), &x.as_slice()[..6], first, second)?;
                least = least.min(near.distance);
            }
        }
    }
    Ok(least)
}
