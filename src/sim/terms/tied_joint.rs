//! A joint that a row ties, at a state: what the row sees of it.

use super::local::{OfCoordinate, POSITION, RATE};
use crate::constraint::{JointMotion, TiedJoint};
use crate::model::Body;
use crate::scalar::{Dual, Scalar};

/// A tied joint at a state: where its coordinate is, its motion, and g with its derivatives there.
pub(super) struct Tied<'a, T> {
    pub(super) own: TiedJoint<'a, f64>,
    pub(super) body: &'a Body<f64>,
    pub(super) motion: JointMotion<T>,
    pub(super) g: [T; 4],
}

impl<T: Scalar> Tied<'_, T> {
    /// ∂φ/∂q of its coordinate: its entry of J.
    pub(super) fn entry(&self) -> T {
        self.body.scaled(self.g[1])
    }

    /// b, its part of J̇ v, over its position and rate.
    pub(super) fn bias(&self) -> OfCoordinate<T> {
        let [_, _, second, third] = self.g;
        let rate = OfCoordinate::variable(self.motion.rate, RATE);
        let mut second = Dual::constant_of(second);
        second.eps[POSITION] = third;
        second * rate * rate
    }

    /// The force of a row on its coordinate, where the entry of J changes with its position.
    pub(super) fn force(&self, force: T) -> OfCoordinate<T> {
        let mut out = OfCoordinate::from(0.0);
        out.eps[POSITION] = self.g[2] * force;
        out
    }

    /// The derivatives of y of a row, or of a force, given in error and rate.
    pub(super) fn through(&self, y: &OfCoordinate<T>) -> OfCoordinate<T> {
        let mut out = y.each(|x| x * self.entry());
        if !self.own.is_linear() {
            out.eps[POSITION] += y.eps[RATE] * self.g[2] * self.motion.rate;
        }
        out
    }
}

/// Slopes of a weighted sum in error, rate and bias of a row, and in the accelerations and the weights μ along it.
#[derive(Clone, Copy)]
pub(super) struct RowSlopes<T> {
    pub(super) error: T,
    pub(super) rate: T,
    pub(super) bias: T,
    pub(super) seen: T,
    pub(super) mu: T,
}

impl<T: Scalar> RowSlopes<T> {
    /// In the coefficient of qⁿ of the function of a joint.
    pub(super) fn of_power(&self, n: i32, tied: &Tied<'_, T>, seen: T, mu: T) -> T {
        let JointMotion { position, rate } = tied.motion;
        let power = |k: i32| {
            let falling = (0..k).map(|i| f64::from(n - i)).product::<f64>();
            if n < k {
                T::zero()
            } else {
                position.powi(n - k) * falling
            }
        };
        let (own, slope, bend) = (power(0), power(1), power(2));
        let scaled = |x: T| tied.body.scaled(x);
        self.error * own
            + self.rate * slope * rate
            + self.bias * bend * rate * rate
            + (self.seen * scaled(seen) + self.mu * scaled(mu)) * slope
    }
}
