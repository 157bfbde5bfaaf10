//! Problems of trajectory optimisation that several tests solve.

use dualbody::model::{FrameId, samples};
use dualbody::trajopt::{
    Activation, Cost, Dynamics, FramePosition, InputError, Problem, Robot, StateError,
};
use dualbody::{Scalar, Simulator, State};

/// Two masses in a row, coupled by a spring, each pushed: x⁺ = A x + B u.
pub(crate) struct Masses;

const DT: f64 = 0.1;

impl Dynamics for Masses {
    fn nx(&self) -> usize {
        4
    }
    fn nu(&self) -> usize {
        2
    }
    fn step<T: Scalar>(&self, x: &[T], u: &[T], next: &mut [T]) {
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

pub(crate) fn masses(horizon: usize) -> Problem<Masses> {
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

pub(crate) fn swing(horizon: usize) -> Problem<Simulator> {
    let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.05);
    let running = Cost::new()
        .with(0.1, Activation::Quadratic, StateError::to(&[3.1, 0.0]))
        .with(1e-2, Activation::Quadratic, InputError::to_zero(&pendulum));
    let last = Cost::new().with(1e2, Activation::Quadratic, StateError::to(&[3.1, 0.0]));
    Problem::new(pendulum, horizon, &[0.0, 0.0])
        .with_stage_cost(running)
        .with_final_cost(last)
}

pub(crate) fn reach(horizon: usize) -> Problem<Simulator> {
    reach_by_steps(horizon, 0.02)
}

/// A reach in steps of so many seconds.
pub(crate) fn reach_by_steps(horizon: usize, time_step: f64) -> Problem<Simulator> {
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

/// A tree with a floating body and ball joints, whose states are no vectors.
pub(crate) fn tree(horizon: usize) -> Problem<Simulator> {
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
impl Dynamics for Counter {
    fn nx(&self) -> usize {
        1
    }
    fn nu(&self) -> usize {
        1
    }
    fn step<T: Scalar>(&self, x: &[T], u: &[T], next: &mut [T]) {
        next[0] = x[0] + u[0];
    }
}

pub(crate) fn counter(horizon: usize, weight: f64) -> Problem<Counter> {
    let cost = Cost::new().with(weight, Activation::Quadratic, InputError::to_zero(&Counter));
    Problem::new(Counter, horizon, &[0.0]).with_stage_cost(cost)
}
