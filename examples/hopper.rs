//! A one-legged robot on a boom hops over a hurdle and lands standing: trajectory optimisation through contact.
//!
//! `Ddp` optimises the steps of the simulator, with the ground, its friction, and the bristle under the foot as a part of the state. The guess does not
//! obey the dynamics: it is a parabola between two stances. The solver finds the push of the leg, the time of lift-off, the place of landing, and the
//! motion after it.
//!
//! `cargo run --release --example hopper` – writes a table and a page to `out/hopper/`.

mod common;

use std::error::Error;
use std::f64::consts::PI;

use dualbody::contact::{ContactLaw, Contacts, SoftContact, Terrain};
use dualbody::dynamics::{frame_pose, gravity_forces};
use dualbody::model::Geometry;
use dualbody::spatial::Transform;
use dualbody::trajopt::{
    Activation, Cost, Ddp, DdpOptions, FramePosition, InputError, Problem, Robot, StateError,
    Trajectory, position_barrier,
};
use dualbody::{Integrator, Model, Simulator, State};
use nalgebra::{DVector, Vector3};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/hopper.urdf");
const DT: f64 = 0.005;
/// 1.2 s; over the hurdle at half time, standing again in the last 0.18 s.
const HORIZON: usize = 240;
const LANDED: usize = 204;
const ITERATIONS: usize = 300;
/// Length of the hop, the hurdle, and the height of the foot there, m.
const DISTANCE: f64 = 0.4;
const HURDLE: f64 = 0.15;
const OVER: f64 = 0.2;
/// Half the thickness of the hurdle, m, and its colour.
const HALF: f64 = 0.005;
const COLOR: [f64; 4] = [0.8, 0.2, 0.2, 1.0];
/// When the sketch flies, s.
const FLIGHT: [f64; 2] = [0.4, 0.8];
/// Hip and knee, rad: while it stands, the foot under the hip, and drawn up in the sketch.
const STANCE: [f64; 2] = [-0.6, 1.2];
const TUCKED: [f64; 2] = [-0.9, 1.8];
/// Length of thigh and shank together, and the radius of the foot, m.
const LEG: f64 = 0.4;
const FOOT: f64 = 0.02;
/// A mat, into which it sinks by so much where it stands, m.
const DEPTH: f64 = 0.01;
const GRAVITY: f64 = 9.81;

fn main() -> Result<(), Box<dyn Error>> {
    let simulator = hopper()?;
    let (start, held) = standing(&simulator);
    let problem = hop(&simulator, &start, &held)?;
    let options = DdpOptions {
        max_iterations: ITERATIONS,
        tolerance: 1e-6,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(&problem, options);
    let bar = common::progress_bar(ITERATIONS);
    let plan = ddp.solve_with(&problem, &sketch(&problem, &start, &held), bar);
    println!(
        "{} after {} iterations, cost {:.4}",
        plan.status, plan.iterations, plan.cost
    );
    assert!(plan.is_converged());
    check(&simulator, &start, &plan.trajectory);

    let mut motion = common::save_plan("hopper", &simulator, &plan.trajectory, "foot")?;
    let size = [2.0 * HALF, 0.3, HURDLE];
    let place = Transform::from_translation(Vector3::new(0.5 * DISTANCE, 0.0, 0.5 * HURDLE));
    motion.add_shape("hurdle", Geometry::Box { size }, place, COLOR);
    common::save_page("hopper", &motion)
}

/// The robot on a mat.
fn hopper() -> Result<Simulator, Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let law = SoftContact {
        friction: 0.8,
        ..SoftContact::estimate(model.total_mass(), 1, DEPTH)
    };
    let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Soft(law));
    Ok(Simulator::new(model)
        .with_contacts(contacts)
        .with_integrator(Integrator::ImplicitVelocity)
        .with_time_step(DT)
        .with_actuated_joints(&["hip", "knee"])?)
}

/// Standing still at the depth that the law is made for, and the torques that it takes.
fn standing(simulator: &Simulator) -> (State, DVector<f64>) {
    let (model, mut state) = (simulator.model(), simulator.neutral_state::<f64>());
    state.q[1] = FOOT - DEPTH + LEG * STANCE[0].cos();
    state.q.rows_mut(2, 2).copy_from_slice(&STANCE);
    let contacts = simulator.contacts().expect("a foot on the ground");
    let jacobian = contacts.jacobian(model, state.q.as_slice(), 0);
    let carried = jacobian.row(2).transpose() * (model.total_mass() * GRAVITY);
    let held = gravity_forces(model, state.q.as_slice()) - carried;
    (state, held.rows(2, 2).into())
}

fn hop(
    simulator: &Simulator,
    start: &State,
    held: &DVector<f64>,
) -> Result<Problem, Box<dyn Error>> {
    let mut goal = start.clone();
    goal.q[0] += DISTANCE;
    let goal = || StateError::to(simulator.pack(&goal).as_slice());
    // Where the body is, its height, the joints, the speeds; bristles have no goal.
    let weights = |x: f64, z: f64, joint: f64, v: f64| {
        Activation::Weighted(vec![x, z, joint, joint, v, v, v, v, 0.0, 0.0, 0.0])
    };
    let foot = simulator.model().find_frame("foot")?;
    let over = FramePosition::new(foot, [0.5 * DISTANCE, 0.0, OVER]);
    let sagittal = Activation::Weighted(vec![1.0, 0.0, 1.0]);
    let (limits, position) = position_barrier(simulator);
    let half = HORIZON / 2;
    let running = Cost::new()
        .with(1.0, weights(0.1, 1.0, 1.0, 0.1), goal())
        .with(1e5, limits, position)
        .with(1e-3, Activation::Quadratic, InputError::to(held.as_slice()))
        .with_during(half..half + 1, 2e5, sagittal, over)
        .with_during(LANDED..HORIZON, 100.0, weights(1.0, 1.0, 1.0, 0.1), goal());
    let last = Cost::new().with(2e3, weights(1.0, 1.0, 1.0, 0.1), goal());
    let (lower, upper) = simulator.effort_bounds();
    let start = simulator.pack(start);
    Ok(Problem::new(simulator.clone(), HORIZON, start.as_slice())
        .with_stage_cost(running)
        .with_final_cost(last)
        .with_input_bounds(&lower, &upper))
}

/// Guess of the solver: it stands, is on a parabola with the leg drawn up, and stands.
fn sketch(problem: &Problem, start: &State, held: &DVector<f64>) -> Trajectory {
    let mut out = Trajectory::zero_input(problem);
    let [from, to] = FLIGHT;
    for (k, x) in out.states.iter_mut().enumerate() {
        let t = (k as f64 * DT).clamp(from, to);
        let (share, mut state) = ((t - from) / (to - from), start.clone());
        state.q[0] += share * DISTANCE;
        state.q[1] += 0.5 * GRAVITY * (t - from) * (to - t);
        for i in 0..2 {
            state.q[2 + i] += (PI * share).sin() * (TUCKED[i] - STANCE[i]);
        }
        let flies = t > from && t < to;
        if flies {
            state.v[0] = DISTANCE / (to - from);
            state.v[1] = 0.5 * GRAVITY * (from + to - 2.0 * t);
        }
        state.copy_to_slice(x.as_mut_slice());
        if let Some(u) = out.inputs.get_mut(k) {
            *u = if flies {
                DVector::zeros(2)
            } else {
                held.clone()
            };
        }
    }
    out
}

/// Checks that the simulator reproduces the plan by its torques, and that the plan keeps their limits, flies over the hurdle and ends standing
/// where it should.
fn check(simulator: &Simulator, start: &State, plan: &Trajectory) {
    let played = simulator.rollout(start, HORIZON, |t, _, u| {
        u.copy_from_slice(plan.inputs[(t / DT).round() as usize].as_slice());
    });
    let pairs = played.states.iter().zip(&plan.states);
    let off = pairs.map(|(state, x)| (simulator.pack(state) - x).amax());
    let off = off.fold(0.0, f64::max);
    let torque = plan.inputs.iter().map(|u| u.amax()).fold(0.0, f64::max);
    println!("the simulated motion is within {off:.1e} of the plan, with at most {torque:.2} N·m");
    assert!(off < 1e-9 && torque <= simulator.effort_bounds().1[0] + 1e-9);

    let states = played.states.iter();
    let cleared = states.clone().map(|state| above_hurdle(simulator, state));
    let cleared = cleared.fold(f64::INFINITY, f64::min);
    let touches = |state: &&State| points(simulator, state)[0].z < FOOT;
    let flight = states.filter(|state| !touches(state)).count() as f64 * DT;
    let end = played.last();
    let (miss, speed) = (end.q[0] - DISTANCE, end.v.amax());
    println!(
        "{flight:.3} s in the air, {cleared:.3} m above the hurdle of {HURDLE} m; lands {miss:.1e} m from its target, with a speed of {speed:.1e}"
    );
    assert!(flight > 0.2 && cleared > 0.01);
    assert!(miss.abs() < 5e-3 && speed < 5e-3 && touches(&end));
}

/// Points along the shank from the middle of the foot to the knee.
fn points(simulator: &Simulator, state: &State) -> [Vector3<f64>; 11] {
    let model = simulator.model();
    let [foot, knee] = ["foot", "shank"].map(|name| {
        let frame = model.find_frame(name).expect("a frame of the hopper");
        frame_pose(model, state.q.as_slice(), frame).translation
    });
    std::array::from_fn(|i| foot + (knee - foot) * (0.1 * i as f64))
}

/// Clearance of the shank, as thick as the foot, above the hurdle, m; infinite where it is not over it.
fn above_hurdle(simulator: &Simulator, state: &State) -> f64 {
    let points = points(simulator, state).into_iter();
    let over = points.filter(|p| (p.x - 0.5 * DISTANCE).abs() < FOOT + HALF);
    over.map(|p| p.z - FOOT - HURDLE)
        .fold(f64::INFINITY, f64::min)
}
