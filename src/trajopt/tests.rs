//! A problem with a closed form, for the tests of solvers.

use crate::scalar::Scalar;
use crate::trajopt::{Activation, Cost, InputError, Problem, Scratch, StateError, System};

/// A number that decays and is pushed: x⁺ = a x + b u.
pub(super) struct Decay;

pub(super) const A: f64 = 0.9;
pub(super) const B: f64 = 0.5;

impl System for Decay {
    fn nx(&self) -> usize {
        1
    }
    fn nu(&self) -> usize {
        1
    }
    fn step<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, next: &mut [T]) {
        next[0] = x[0] * A + u[0] * B;
    }
    fn rate<T: Scalar>(&self, _: &[T], u: &[T], _: &mut Scratch, rate: &mut [T]) {
        rate[0] = u[0];
    }
    fn is_vector_space(&self) -> bool {
        true
    }
}

/// Weights of the states, of the inputs and of the last state.
pub(super) const Q: f64 = 2.0;
pub(super) const R: f64 = 0.3;
pub(super) const LAST: f64 = 5.0;

/// Start of the problem.
pub(super) const START: f64 = 1.5;

/// min ½ Σ (Q x² + R u²) + ½ LAST `x_N`².
pub(super) fn linear_quadratic(horizon: usize) -> Problem {
    let running = Cost::new()
        .with(Q, Activation::Quadratic, StateError::to(&[0.0]))
        .with(R, Activation::Quadratic, InputError::to_zero(&Decay));
    let last = Cost::new().with(LAST, Activation::Quadratic, StateError::to(&[0.0]));
    Problem::new(Decay, horizon, &[START])
        .with_stage_cost(running)
        .with_final_cost(last)
}

/// Gains of all stages and the cost to go from the start, by Riccati's recursion:
/// K = a b P / (R + b² P),  P ← Q + a² P − a b P K.
pub(super) fn riccati(horizon: usize) -> (Vec<f64>, f64) {
    let (mut p, mut gains) = (LAST, vec![0.0; horizon]);
    for gain in gains.iter_mut().rev() {
        *gain = A * B * p / (R + B * B * p);
        p = Q + A * A * p - A * B * p * *gain;
    }
    (gains, p)
}
