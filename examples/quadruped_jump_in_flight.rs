//! A quadruped in the air rotates its trunk by moving its legs. It touches nothing, so its angular momentum stays zero, but it lands with a rotated
//! trunk.
//!
//! `cargo run --release --example quadruped_jump_in_flight` – writes a table and a page to
//! `out/quadruped_jump_in_flight/`.

mod common;

use std::error::Error;

use dualbody::dynamics::{centroidal_momentum, frame_pose};
use dualbody::spatial::Quaternion;
use dualbody::trajopt::{
    Activation, Cost, Ddp, DdpOptions, FrameOrientation, InputError, Problem, Robot, StateError,
    Trajectory, position_barrier,
};
use dualbody::{Integrator, Model, Simulator, State};
use nalgebra::Vector3;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/quadruped.urdf");
const NAME: &str = "quadruped_jump_in_flight";
const DT: f64 = 0.01;
/// 0.5 s in the air.
const HORIZON: usize = 50;
/// Steps in which the flight is computed for each of the plan's.
const FINE: usize = 20;
/// Pitch that the trunk is to reach.
const PITCH: f64 = 0.3;
const ITERATIONS: usize = 200;

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let names: Vec<String> = model
        .joint_names()
        .iter()
        .map(|&name| name.into())
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let simulator = Simulator::new(model).with_time_step(DT);
    let simulator = simulator.with_actuated_joints(&names)?;
    let start = take_off(simulator.model());
    let problem = flight(&simulator, &start)?;
    let options = DdpOptions {
        max_iterations: ITERATIONS,
        ..DdpOptions::default()
    };
    let mut ddp = Ddp::with_options(&problem, options);
    let bar = common::progress_bar(ITERATIONS);
    let plan = ddp.solve_with(&problem, &Trajectory::zero_input(&problem), bar);
    println!("{} after {} iterations", plan.status, plan.iterations);
    assert!(plan.is_converged());
    let motion = common::save_plan(NAME, &simulator, &plan.trajectory, "trunk")?;
    common::save_page(NAME, &motion)?;

    // The plan flown in steps small enough to conserve momentum.
    let model = simulator.model();
    let fine = simulator.clone().with_time_step(DT / FINE as f64);
    let fine = fine.with_integrator(Integrator::RungeKutta4);
    let flown = fine.rollout(&start, HORIZON * FINE, |time, _, u| {
        let k = (time / DT + 1e-9) as usize;
        u.copy_from_slice(plan.trajectory.inputs[k].as_slice());
    });
    let angular = |state: &State| {
        let h = centroidal_momentum(model, state.q.as_slice(), state.v.as_slice());
        h.angular.norm()
    };
    let momentum = flown.states.iter().map(angular).fold(0.0, f64::max);
    let trunk = model.find_frame("trunk")?;
    let axis = frame_pose(model, flown.last().q.as_slice(), trunk).rotation;
    let pitch = (-axis[(2, 0)]).asin();
    println!("pitched by {pitch:.4} rad at an angular momentum of {momentum:.1e} kg m²/s at most");
    assert!((pitch - PITCH).abs() < 0.02);
    assert!(momentum < 1e-9);
    Ok(())
}

/// Legs bent, at rest except for the leap.
fn take_off(model: &Model) -> State {
    let mut state = State::neutral(model);
    state.q[2] = 0.4;
    for leg in 0..4 {
        state.q[7 + 3 * leg + 1] = 0.8;
        state.q[7 + 3 * leg + 2] = -1.6;
    }
    state.v[2] = 2.5;
    state
}

fn flight(simulator: &Simulator, start: &State) -> Result<Problem, Box<dyn Error>> {
    let x = simulator.pack(start);
    let nv = simulator.model().nv();
    // The motors do not change the flight of the whole; the cost only keeps the legs near their positions.
    let mut legs = vec![0.0; 2 * nv];
    legs[6..nv].fill(0.1);
    legs[nv + 6..].fill(1e-2);
    let (limits, position) = position_barrier(simulator);
    let running = Cost::new()
        .with(
            1.0,
            Activation::Weighted(legs.clone()),
            StateError::to(x.as_slice()),
        )
        .with(1e2, limits, position)
        .with(1e-3, Activation::Quadratic, InputError::to_zero(simulator));
    let turned = FrameOrientation {
        frame: simulator.model().find_frame("trunk")?,
        target: Quaternion::exp(&Vector3::new(0.0, PITCH, 0.0)).to_matrix(),
    };
    let last = Cost::new().with(1e3, Activation::Quadratic, turned).with(
        1.0,
        Activation::Weighted(legs),
        StateError::to(x.as_slice()),
    );
    let (lower, upper) = simulator.effort_bounds();
    Ok(Problem::new(simulator.clone(), HORIZON, x.as_slice())
        .with_stage_cost(running)
        .with_final_cost(last)
        .with_input_bounds(&lower, &upper))
}
