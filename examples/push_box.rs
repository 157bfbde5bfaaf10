//! A finger pushes a box to a pose on the ground. Differential dynamic programming plans the motion through two contacts: between finger and box, and
//! between box and ground.
//!
//! `cargo run --release --example push_box` – writes a table and a page to `out/push_box/`.

mod common;

use std::error::Error;

use dualbody::contact::{CollisionOptions, ContactLaw, RelaxedRigid, Terrain};
use dualbody::joint::JointKind::Prismatic;
use dualbody::model::{JointSpec, LinkSpec, Mass, ModelBuilder, Object, World};
use dualbody::spatial::Transform;
use dualbody::trajopt::{
    Activation, Cost, Ddp, DdpOptions, InputError, Problem, Robot, StateError, Trajectory,
};
use dualbody::{Contacts, Simulator};
use nalgebra::DVector;

const NAME: &str = "push_box";
const DT: f64 = 0.01;
const HORIZON: usize = 100;
/// Width and height of the box, radius of the finger, m.
const WIDTH: f64 = 0.1;
const HEIGHT: f64 = 0.06;
const RADIUS: f64 = 0.02;
/// The pose to which the box is pushed: x, y, m, and its turn about z, rad.
const GOAL: [f64; 3] = [0.2, 0.03, 0.3];
const ITERATIONS: usize = 150;

fn main() -> Result<(), Box<dyn Error>> {
    let simulator = simulator()?;
    let start = simulator.pack(&simulator.neutral_state());
    let problem = problem(&simulator, &start);
    // A guess: the finger pushes straight on.
    let push = DVector::from_vec(vec![1.45, 0.0]);
    let guess = Trajectory::rollout(&problem, &vec![push; HORIZON]);
    let options = DdpOptions {
        max_iterations: ITERATIONS,
        tolerance: 1e-6,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(&problem, options);
    let bar = common::progress_bar(ITERATIONS);
    let plan = ddp.solve_with(&problem, &guess, bar).clone();

    let found = |x: &DVector<f64>| {
        let turn = 2.0 * x[6].atan2(x[3]);
        [x[0], x[1], turn]
    };
    let [guessed, end] = [&guess, &plan.trajectory].map(|of| found(&of.states[HORIZON]));
    println!(
        "after {} iterations, cost {:.4}: the guess pushes to {guessed:.4?}, the plan to {end:.4?}, the goal is {GOAL:?}",
        plan.iterations, plan.cost
    );
    // The plan is a motion of the simulator: played again it gets to the same place.
    let again = Trajectory::rollout(&problem, &plan.trajectory.inputs);
    let apart = (&again.states[HORIZON] - &plan.trajectory.states[HORIZON]).amax();
    assert!(apart < 1e-6, "{apart}");
    for k in 0..3 {
        assert!((end[k] - GOAL[k]).abs() < 0.01, "{k}: {}", end[k]);
    }
    let recording = common::save_plan(NAME, &simulator, &plan.trajectory, "box")?;
    common::save_page(NAME, &recording)
}

/// The box is the first member of the world by its name: q is its pose, then where the finger is along x and y.
fn simulator() -> Result<Simulator, Box<dyn Error>> {
    let mut builder = ModelBuilder::new("finger");
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("rail").with_mass(0.1, [0.0; 3], [1e-4; 3]));
    builder.add_link(LinkSpec::solid_sphere("tip", RADIUS, Mass::Kilograms(0.2)));
    let x = JointSpec::new("x", Prismatic, "world", "rail").with_damping(1.0);
    let at = [-WIDTH / 2.0 - RADIUS, 0.0, HEIGHT / 2.0];
    builder.add_joint(x.with_translation(at));
    let y = JointSpec::new("y", Prismatic, "rail", "tip").with_axis([0.0, 1.0, 0.0]);
    builder.add_joint(y.with_damping(1.0));
    let mut world = World::new(NAME);
    world.add(&builder.build()?, "finger/", &Transform::identity())?;
    let at = Transform::from_translation([0.0, 0.0, HEIGHT / 2.0].into());
    let object = Object::free(Mass::Kilograms(0.3)).with_color([0.85, 0.6, 0.3, 1.0]);
    world.add_box("box", [WIDTH, WIDTH, HEIGHT], &object.at(at))?;
    let model = world.build()?;
    let law = ContactLaw::RelaxedRigid(RelaxedRigid {
        friction: 0.4,
        ..RelaxedRigid::default()
    });
    let options = CollisionOptions::default();
    let contacts =
        Contacts::new(&model, Terrain::flat(0.0), law).with_collisions(&model, law, &options)?;
    Ok(Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(DT)
        .with_actuated_joints(&["finger/x", "finger/y"])?)
}

/// The box at its goal in the end and at rest, with little force.
fn problem(simulator: &Simulator, start: &DVector<f64>) -> Problem {
    let mut goal = start.clone();
    goal.rows_mut(0, 2).copy_from_slice(&GOAL[..2]);
    (goal[3], goal[6]) = ((GOAL[2] / 2.0).cos(), (GOAL[2] / 2.0).sin());
    // x, y, z and rotation of the box, the finger, then their velocities.
    let pose = [1e4, 1e4, 0.0, 0.0, 0.0, 1e3, 0.0, 0.0];
    let speed = [10.0, 10.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let arrive = Activation::Weighted([pose, speed].concat());
    let effort = Cost::new().with(0.1, Activation::Quadratic, InputError::to_zero(simulator));
    Problem::new(simulator.clone(), HORIZON, start.as_slice())
        .with_stage_cost(effort)
        .with_final_cost(Cost::new().with(1.0, arrive, StateError::to(goal.as_slice())))
}
