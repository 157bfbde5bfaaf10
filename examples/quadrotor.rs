//! A quadrotor catches itself and hovers by LQR, flies a loop within the limits of its rotors, and hovers again.
//!
//! Its rotors are actuators on frames of a floating base. `Ddp` plans the loop, around a circle on which the hull tilts as the thrust must point.
//!
//! `cargo run --release --example quadrotor` – writes a page to `out/quadrotor/`.

use std::{error::Error, f64::consts::PI};

use dualbody::constraint::Anchor;
use dualbody::control::Lqr;
use dualbody::sim::{FrameActuator, Rollout};
use dualbody::trajopt::{
    Activation, Cost, Ddp, InputError, Problem, Robot, StateError, Trajectory,
};
use dualbody::view::Recording;
use dualbody::{Model, Simulator, State, UnknownName};
use nalgebra::{DMatrix, DVector};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/quadrotor.urdf");
const DT: f64 = 0.01;
/// Links of the rotors. Neighbours run in opposite senses, and turn the hull by so much per thrust, N·m/N.
const ROTORS: [&str; 4] = ["front", "left", "rear", "right"];
const TORQUE_RATIO: f64 = 0.016;
/// The most thrust of a rotor, and what each carries, N.
const MOST: f64 = 7.0;
const HELD: f64 = 9.81 / 4.0;
/// Steps of hovering, before and after the loop, and of the loop, which is 2 m high.
const HOVER: usize = 300;
const LOOP: usize = 240;

fn main() -> Result<(), Box<dyn Error>> {
    let drone = drone(Model::from_urdf_file(FILE)?)?;
    let (model, rest) = (drone.model(), drone.neutral_state());
    let gain = hover(&drone, &rest);
    let problem = around(&drone, &rest);
    let mut guess = Trajectory::resting(&problem);
    let sketch = guess.states.iter_mut().enumerate();
    sketch.for_each(|(k, x)| x.copy_from_slice(&circle(k)));
    let mut ddp = Ddp::new(&problem);
    let plan = ddp.solve(&problem, &guess);
    println!("loop: {} after {} iterations", plan.status, plan.iterations);
    assert!(plan.is_converged());

    // Thrown: aside, tilted, turned away, and spinning.
    let start = State::new(
        &[0.8, -0.5, -0.3, 0.8, 0.3, -0.2, 0.477_493_455_452_533],
        &[1.0; 6],
    );
    let flight = drone.rollout(&start, 2 * HOVER + LOOP, |time, state, u| {
        let step = (time / DT).round() as usize;
        let thrust = match step.checked_sub(HOVER) {
            Some(k) if k < LOOP => plan.control(&problem, k, drone.pack(state).as_slice()),
            _ => (-&gain * state.deviation(model, &rest)).add_scalar(HELD),
        };
        u.copy_from_slice(thrust.as_slice());
    });
    check(&flight, model, &rest);
    let mut recording = Recording::from_rollout(model, &flight);
    let track = recording.robot_mut(0).trace("hull")?;
    track.add_applied_forces(&drone);
    Ok(recording.save_html("out/quadrotor/index.html")?)
}

fn drone(model: Model) -> Result<Simulator, UnknownName> {
    let senses = [TORQUE_RATIO, -TORQUE_RATIO].into_iter().cycle();
    let rotors = ROTORS.iter().zip(senses).map(|(name, torque_ratio)| {
        let place = Anchor::frame(&model, name)?;
        let rotor = FrameActuator::thruster(*name, place, [0.0, 0.0, 1.0], torque_ratio);
        Ok(rotor.with_limits(0.0, MOST))
    });
    let rotors = rotors.collect::<Result<_, _>>()?;
    Ok(Simulator::new(model)
        .with_frame_actuators(rotors)
        .with_time_step(DT))
}

/// The gain that holds it at rest.
fn hover(drone: &Simulator, rest: &State) -> DMatrix<f64> {
    let step = drone.linearize(rest, &[HELD; 4]);
    let (weights, effort) = (DVector::from_element(12, 1.0), DMatrix::identity(4, 4));
    let weights = DMatrix::from_diagonal(&weights);
    let lqr = Lqr::discrete(&step.a, &step.b, &weights, &effort);
    println!(
        "hover: {:?}, spectral radius {:.3}",
        lqr.status,
        lqr.spectral_radius()
    );
    assert!(lqr.is_stabilized());
    lqr.gain
}

/// Once around the circle, to rest where it began.
fn around(drone: &Simulator, rest: &State) -> Problem<Simulator> {
    let pose = Activation::Weighted([[10.0; 6], [0.0; 6]].concat());
    let circle: Vec<_> = (0..LOOP).map(circle).collect();
    let running = Cost::new()
        .with(1.0, pose, StateError::along(&circle))
        .with(1e-2, Activation::Quadratic, InputError::to(&[HELD; 4]));
    let rest = drone.pack(rest);
    let goal = StateError::to(rest.as_slice());
    let (lower, upper) = drone.effort_bounds();
    Problem::new(drone.clone(), LOOP, rest.as_slice())
        .with_stage_cost(running)
        .with_final_cost(Cost::new().with(100.0, Activation::Quadratic, goal))
        .with_input_bounds(&lower, &upper)
}

/// The place at a step, on a circle that is left and come to with least jerk, and the attitude whose thrust gives the acceleration there.
fn circle(step: usize) -> [f64; 13] {
    let place = |step: f64| {
        let s = (step / LOOP as f64).clamp(0.0, 1.0);
        let (sin, cos) = (2.0 * PI * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)).sin_cos();
        [sin, 1.0 - cos]
    };
    let [before, [x, z], after] = [-1.0, 0.0, 1.0].map(|by| place(step as f64 + by));
    let a = [0, 1].map(|i| (after[i] - 2.0 * [x, z][i] + before[i]) / (DT * DT));
    let (sin, cos) = (0.5 * a[0].atan2(a[1] + 9.81)).sin_cos();
    [x, 0.0, z, cos, 0.0, sin, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
}

fn check(flight: &Rollout, model: &Model, rest: &State) {
    let [caught, end] =
        [HOVER, 2 * HOVER + LOOP].map(|k| flight.states[k].deviation(model, rest).amax());
    let highest = flight
        .states
        .iter()
        .max_by(|a, b| a.q[2].total_cmp(&b.q[2]));
    let top = &highest.expect("a flight has states").q;
    let up = 1.0 - 2.0 * (top[4] * top[4] + top[5] * top[5]);
    let most = flight.inputs[HOVER..HOVER + LOOP]
        .iter()
        .map(|u| u.max())
        .fold(0.0, f64::max);
    println!(
        "hovers {caught:.0e} from rest, after the loop {end:.0e}; {:.2} m up its axis points {up:.2} upwards; {most:.2} N at most",
        top[2]
    );
    assert!(caught < 1e-2 && end < 1e-2 && top[2] > 1.8 && up < -0.9 && most <= MOST);
}
