//! A quadrotor stabilises itself and hovers by LQR, flies a loop within the limits of its rotors, and hovers again.
//! Its rotors are actuators on frames of a floating base; `Ddp` plans the loop around a circle.
//!
//! `cargo run --release --example quadrotor` – writes a page to `out/quadrotor/`.

use dualbody::constraint::Anchor;
use dualbody::control::Lqr;
use dualbody::sim::{FrameActuator, Rollout};
use dualbody::trajopt::{
    Activation, Cost, Ddp, InputError, Problem, Robot, StateError, Trajectory,
};
use dualbody::view::Recording;
use dualbody::{Model, Simulator, State, UnknownName};
use nalgebra::{Complex, DMatrix, DVector};
use std::{error::Error, f64::consts::PI};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/quadrotor.urdf");
const DT: f64 = 0.01;
/// Links of the rotors. Neighbours run in opposite senses, and turn the hull by so much per thrust, N·m/N.
const ROTORS: [&str; 4] = ["front", "left", "rear", "right"];
const TORQUE_RATIO: f64 = 0.016;
/// Largest thrust of a rotor, and the weight that each carries, N.
const MOST: f64 = 7.0;
const HELD: f64 = 9.81 / 4.0;
/// Steps of hovering, before and after the loop, and of the loop, which is 2 m high.
const HOVER: usize = 400;
const LOOP: usize = 240;

fn main() -> Result<(), Box<dyn Error>> {
    let drone = drone(Model::from_urdf_file(FILE)?)?;
    let (model, rest) = (drone.model(), drone.neutral_state());
    let gain = hover(&drone, &rest);
    let (problem, guess) = around(&drone, &rest);
    let plan = Ddp::new(&problem).solve(&problem, &guess).clone();
    assert!(plan.is_converged(), "{}", plan.status);
    // Thrown: aside, tilted, turned away, and spinning.
    let start = State::new(&[0.8, -0.5, -0.3, 0.8, 0.4, -0.2, 0.4], &[1.0; 6]);
    let flight = drone.rollout(&start, 2 * HOVER + LOOP, |time, state, u| {
        let thrust = match ((time / DT).round() as usize).checked_sub(HOVER) {
            Some(k) if k < LOOP => plan.control(&problem, k, drone.pack(state).as_slice()),
            _ => (-&gain * state.deviation(model, &rest)).add_scalar(HELD),
        };
        u.copy_from_slice(thrust.as_slice());
    });
    check(&flight, model, &rest);
    let mut recording = Recording::from_rollout(model, &flight);
    let track = recording.robot_mut(0);
    track.add_applied_forces(&drone).trace("hull")?;
    Ok(recording.save_html("out/quadrotor/index.html")?)
}

fn drone(model: Model) -> Result<Simulator, UnknownName> {
    let senses = [TORQUE_RATIO, -TORQUE_RATIO].into_iter().cycle();
    let rotor = |(name, torque_ratio): (&&str, f64)| {
        let place = Anchor::frame(&model, name)?;
        let rotor = FrameActuator::thruster(*name, place, [0.0, 0.0, 1.0], torque_ratio);
        Ok(rotor.with_limits(0.0, MOST))
    };
    let rotors: Result<_, UnknownName> = ROTORS.iter().zip(senses).map(rotor).collect();
    let simulator = Simulator::new(model).with_time_step(DT);
    Ok(simulator.with_frame_actuators(rotors?))
}

/// The gain that holds it at rest.
fn hover(drone: &Simulator, rest: &State) -> DMatrix<f64> {
    let step = drone.linearize(rest, &[HELD; 4]);
    let weights = DVector::from_fn(12, |k, _| [10.0, 10.0, 1.0, 0.1][k / 3]);
    let (q, r) = (DMatrix::from_diagonal(&weights), DMatrix::identity(4, 4));
    let lqr = Lqr::discrete(&step.a, &step.b, &q, &r);
    println!("hover: spectral radius {:.3}", lqr.spectral_radius());
    assert!(lqr.is_stabilized());
    lqr.gain
}

/// Once around the circle, to rest where it began, and the circle itself to start from.
fn around(drone: &Simulator, rest: &State) -> (Problem, Trajectory) {
    let (states, thrusts): (Vec<_>, Vec<_>) = (0..=LOOP).map(|k| circle(k as f64)).unzip();
    let running = Cost::new()
        .with(1.0, Activation::Quadratic, StateError::along(&states))
        .with(1.0, Activation::Quadratic, InputError::along(&thrusts));
    let rest = drone.pack(rest);
    let goal = StateError::to(rest.as_slice());
    let (lower, upper) = drone.effort_bounds();
    let problem = Problem::new(drone.clone(), LOOP, rest.as_slice())
        .with_stage_cost(running)
        .with_final_cost(Cost::new().with(100.0, Activation::Quadratic, goal))
        .with_input_bounds(&lower, &upper);
    let mut guess = Trajectory::zero_input(&problem);
    guess.states = states.iter().map(|x| DVector::from_row_slice(x)).collect();
    (problem, guess)
}

/// State and thrusts on a circle that is left and come to with least jerk, tilted as the thrust must point. Complex
/// numbers are z + i x.
fn circle(k: f64) -> ([f64; 13], [f64; 4]) {
    let place = |k: f64| {
        let s = (k / LOOP as f64).clamp(0.0, 1.0);
        1.0 - Complex::cis(-2.0 * PI * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s))
    };
    let velocity = |k: f64| (place(k) - place(k - 1.0)) / DT;
    let thrust = |k: f64| (velocity(k + 1.0) - velocity(k)) / DT + 9.81;
    let (p, f) = (place(k), thrust(k));
    let half = Complex::cis(0.5 * f.arg());
    let v = velocity(k) * f.conj() / f.norm();
    let spin = (f / thrust(k - 1.0)).arg() / DT;
    let state = [
        p.im, 0.0, p.re, half.re, 0.0, half.im, 0.0, v.im, 0.0, v.re, 0.0, spin, 0.0,
    ];
    (state, [0.25 * f.norm(); 4])
}

fn check(flight: &Rollout, model: &Model, rest: &State) {
    let off = |k: usize| flight.states[k].deviation(model, rest).amax();
    let (caught, end) = (off(HOVER), off(2 * HOVER + LOOP));
    let top = &flight.states[HOVER + LOOP / 2].q;
    let (height, up) = (top[2], 1.0 - 2.0 * (top[4] * top[4] + top[5] * top[5]));
    let planned = flight.inputs[HOVER..HOVER + LOOP].iter();
    let most = planned.map(|u| u.max()).fold(0.0, f64::max);
    println!("distance from rest: hovering {caught:.0e}, after the loop {end:.0e}");
    println!(
        "{height:.2} m high, vertical part of its axis {up:.2}; at most {most:.2} N per rotor"
    );
    assert!(caught < 1e-2 && end < 1e-2 && most <= MOST && height > 1.8 && up < -0.9);
}
