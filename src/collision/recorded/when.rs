//! Conditions on numbers without values, and the choice that they make.

use nalgebra::Vector3;

use super::FAR;
use crate::collision::feature::Witness;
use crate::scalar::{MapEach, Scalar};

/// A condition, without derivatives: it holds where the number is positive, not where it is NaN.
#[derive(Clone, Copy, Debug)]
pub(super) struct When<T>(T);

impl<T: Scalar> When<T> {
    pub(super) fn always() -> Self {
        Self(T::one())
    }

    pub(super) fn less(a: T, b: T) -> Self {
        Self((b - a).detached())
    }

    pub(super) fn positive(x: T) -> Self {
        Self(x.detached())
    }

    pub(super) fn and(self, other: Self) -> Self {
        Self(self.pick(other.0, -T::one()))
    }

    pub(super) fn or(self, other: Self) -> Self {
        Self(self.pick(T::one(), other.0))
    }

    pub(super) fn not(self) -> Self {
        Self(self.pick(-T::one(), T::one()))
    }

    /// The first number where the condition holds, else the second.
    pub(super) fn pick(self, a: T, b: T) -> T {
        T::zero().select_lt(self.0, a, b)
    }

    /// The first condition where this one holds, else the second.
    pub(super) fn pick_condition(self, a: Self, b: Self) -> Self {
        Self(self.pick(a.0, b.0))
    }

    pub(super) fn pick_vector(self, a: &Vector3<T>, b: &Vector3<T>) -> Vector3<T> {
        a.zip_map(b, |a, b| self.pick(a, b))
    }

    pub(super) fn pick_point(self, a: &Witness<T>, b: &Witness<T>) -> Witness<T> {
        Witness {
            distance: self.pick(a.distance, b.distance),
            points: [0, 1].map_each(|k| self.pick_vector(&a.points[k], &b.points[k])),
            normal: self.pick_vector(&a.normal, &b.normal),
        }
    }

    /// The point where the condition holds, else one that is out of reach.
    pub(super) fn only(self, own: &Witness<T>) -> Witness<T> {
        Witness {
            distance: self.pick(own.distance, T::constant(FAR)),
            ..*own
        }
    }

    /// The vector where the condition holds, else its opposite.
    pub(super) fn signed(self, v: &Vector3<T>) -> Vector3<T> {
        self.pick_vector(v, &-v)
    }
}

/// The nearest of points, of which each has a condition.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest<T>(pub(super) Witness<T>);

impl<T: Scalar> Nearest<T> {
    /// Takes a point where the condition holds and it is nearer than all before.
    pub(super) fn offer(&mut self, when: When<T>, own: &Witness<T>) {
        let nearer = when.and(When::less(own.distance, self.0.distance));
        self.0 = nearer.pick_point(own, &self.0);
    }
}
