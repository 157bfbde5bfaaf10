//! Problems of trajectory optimisation that several tests solve.

use dualbody::model::{FrameId, samples};
use dualbody::spatial::Quaternion;
use dualbody::trajopt::{
    Activation, Cost, FramePosition, InputError, Problem, Robot, Scratch, StateError, System,
    Trajectory,
};
use dualbody::{Scalar, Simulator, State};
use nalgebra::{DVector, Vector3};

/// Two masses in a row, coupled by a spring, each pushed: x⁺ = A x + B u.
pub(crate) struct Masses;

const DT: f64 = 0.1;

impl System for Masses {
    fn nx(&self) -> usize {
        4
    }
    fn nu(&self) -> usize {
        2
    }
    fn step<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, next: &mut [T]) {
        let spring = (x[1] - x[0]) * 2.0;
        next[2] = x[2] + (u[0] + spring) * DT;
        next[3] = x[3] + (u[1] - spring) * DT;
        next[0] = x[0] + next[2] * DT;
        next[1] = x[1] + next[3] * DT;
    }
    fn is_vector_space(&self) -> bool {
        true
    }
}

pub(crate) fn masses(horizon: usize) -> Problem {
    let running = Cost::new()
        .with(
            1.0,
            Activation::Weighted(vec![1.0, 2.0, 0.1, 0.2]),
            StateError::to(&[0.0; 4]),
        )
        .with(0.5, Activation::Quadratic, InputError::to_zero(&Masses));
    let last = Cost::new().with(10.0, Activation::Quadratic, StateError::to(&[0.0; 4]));
    Problem::new(Masses, horizon, &[1.0, -0.5, 0.3, 0.0])
        .with_stage_cost(running)
        .with_final_cost(last)
}

pub(crate) fn swing(horizon: usize) -> Problem {
    let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.05);
    let running = Cost::new()
        .with(0.1, Activation::Quadratic, StateError::to(&[3.1, 0.0]))
        .with(1e-2, Activation::Quadratic, InputError::to_zero(&pendulum));
    let last = Cost::new().with(1e2, Activation::Quadratic, StateError::to(&[3.1, 0.0]));
    Problem::new(pendulum, horizon, &[0.0, 0.0])
        .with_stage_cost(running)
        .with_final_cost(last)
}

pub(crate) fn reach(horizon: usize) -> Problem {
    reach_by_steps(horizon, 0.02)
}

/// A reach in steps of so many seconds.
pub(crate) fn reach_by_steps(horizon: usize, time_step: f64) -> Problem {
    let arm = Simulator::new(samples::arm()).with_time_step(time_step);
    let frame = arm.model().frame("tool").unwrap();
    let target = FramePosition::new(frame, [0.5, 0.3, 0.6]);
    let running = Cost::new()
        .with(1.0, Activation::Quadratic, target.clone())
        .with(1e-3, Activation::Quadratic, StateError::to_neutral(&arm))
        .with(1e-4, Activation::Quadratic, InputError::to_zero(&arm));
    let last = Cost::new().with(1e3, Activation::Quadratic, target);
    let start = [
        0.1, 0.2, -0.1, 0.3, 0.1, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ];
    Problem::new(arm, horizon, &start)
        .with_stage_cost(running)
        .with_final_cost(last)
}

/// A tree with a floating body and ball joints, whose states are not vectors.
pub(crate) fn tree(horizon: usize) -> Problem {
    let simulator = Simulator::new(samples::random_tree(7, 5)).with_time_step(0.02);
    let frame = FrameId(simulator.model().frames().len() - 1);
    let target = FramePosition::new(frame, [0.2, 0.1, -0.3]);
    let running = Cost::new()
        .with(
            0.1,
            Activation::Quadratic,
            StateError::to_neutral(&simulator),
        )
        .with(1e-2, Activation::Quadratic, InputError::to_zero(&simulator));
    let last = Cost::new().with(1e2, Activation::Quadratic, target);
    let neutral = simulator.pack(&State::neutral(simulator.model()));
    Problem::new(simulator, horizon, neutral.as_slice())
        .with_stage_cost(running)
        .with_final_cost(last)
}

/// A single number that the input adds to: x⁺ = x + u.
pub(crate) struct Counter;
impl System for Counter {
    fn nx(&self) -> usize {
        1
    }
    fn nu(&self) -> usize {
        1
    }
    fn step<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, next: &mut [T]) {
        next[0] = x[0] + u[0];
    }
}

pub(crate) fn counter(horizon: usize, weight: f64) -> Problem {
    let cost = Cost::new().with(weight, Activation::Quadratic, InputError::to_zero(&Counter));
    Problem::new(Counter, horizon, &[0.0]).with_stage_cost(cost)
}

/// A quadrotor of 1 kg with its rotors 0.2 m from the middle: position, quaternion, velocity in the world, angular
/// velocity in the body; the inputs are the thrusts of its rotors, N.
pub(crate) struct Quadrotor;

const ARM: f64 = 0.2;
const TORQUE_RATIO: f64 = 0.02;
const INERTIA: [f64; 3] = [0.01, 0.01, 0.02];
const GRAVITY: f64 = 9.81;

impl System for Quadrotor {
    fn nx(&self) -> usize {
        13
    }
    fn ndx(&self) -> usize {
        12
    }
    fn nu(&self) -> usize {
        4
    }
    fn time_step(&self) -> f64 {
        0.02
    }
    fn step<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, next: &mut [T]) {
        let dt = self.time_step();
        let up = Quaternion::from_slice(&x[3..7])
            .to_matrix()
            .column(2)
            .into_owned();
        let thrust = u[0] + u[1] + u[2] + u[3];
        let torque = [
            (u[1] - u[3]) * ARM,
            (u[2] - u[0]) * ARM,
            (u[0] - u[1] + u[2] - u[3]) * TORQUE_RATIO,
        ];
        let mut dx = [T::zero(); 12];
        for i in 0..3 {
            let fall = if i == 2 { GRAVITY } else { 0.0 };
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let gyroscopic = x[10 + j] * x[10 + k] * (INERTIA[k] - INERTIA[j]);
            dx[6 + i] = (up[i] * thrust - fall) * dt;
            dx[9 + i] = (torque[i] - gyroscopic) * (dt / INERTIA[i]);
            dx[i] = (x[7 + i] + dx[6 + i]) * dt;
            dx[3 + i] = (x[10 + i] + dx[9 + i]) * dt;
        }
        self.integrate(x, &dx, next);
    }
    fn integrate<T: Scalar>(&self, x: &[T], dx: &[T], out: &mut [T]) {
        let turn = Quaternion::exp(&Vector3::new(dx[3], dx[4], dx[5]));
        let turned = Quaternion::from_slice(&x[3..7]) * turn;
        for i in 0..3 {
            out[i] = x[i] + dx[i];
        }
        turned.write_to(&mut out[3..7]);
        for i in 0..6 {
            out[7 + i] = x[7 + i] + dx[6 + i];
        }
    }
    fn difference<T: Scalar>(&self, x0: &[T], x1: &[T], dx: &mut [T]) {
        let from = Quaternion::from_slice(&x0[3..7]).conjugate();
        let turn = (from * Quaternion::from_slice(&x1[3..7])).log();
        for i in 0..3 {
            (dx[i], dx[3 + i]) = (x1[i] - x0[i], turn[i]);
        }
        for i in 0..6 {
            dx[6 + i] = x1[7 + i] - x0[7 + i];
        }
    }
}

/// A quadrotor that hovers, 2 s from another place, turned by a radian; each rotor gives up to `most` N. Also its
/// guess: to hover on.
pub(crate) fn flight(most: f64) -> (Problem, Trajectory) {
    let hover = [GRAVITY / 4.0; 4];
    let mut start = [0.0; 13];
    start[3] = 1.0;
    let mut goal = start;
    goal[..3].copy_from_slice(&[2.0, -1.0, 1.5]);
    (goal[6], goal[3]) = 0.5_f64.sin_cos();
    let running = Cost::new()
        .with(0.1, Activation::Quadratic, InputError::to(&hover))
        .with(1e-2, Activation::Quadratic, StateError::to(&goal));
    let last = Cost::new().with(1e2, Activation::Quadratic, StateError::to(&goal));
    let problem = Problem::new(Quadrotor, 100, &start)
        .with_stage_cost(running)
        .with_final_cost(last)
        .with_input_bounds(&[0.0; 4], &[most; 4]);
    let inputs = vec![DVector::from_column_slice(&hover); 100];
    let guess = Trajectory::rollout(&problem, &inputs);
    (problem, guess)
}
