//! Straight flight of one point of a body that turns: the second half of an Euler step, of kinds whose linear velocity turns with the body.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use crate::scalar::Scalar;
use crate::spatial::linear::{cross, rotate, rotate_back};

/// A step in which a point of the body keeps its velocity while the body turns about it. Vectors are along the axes of before the step.
///
/// With the point c, the velocity w of the origin and ω of the body, and the turn E of the step, the point moves with `w_c` = w + ω × c: the origin
/// shifts by c + Δt `w_c` − E c, and its velocity along the axes of after the step is Eᵀ `w_c` − ω × c, as E does not turn ω.
pub(super) struct Flight<'a, T> {
    /// c.
    center: &'a Vector3<T>,
    /// E.
    E: Matrix3<T>,
    /// `w_c`.
    velocity: Vector3<T>,
    /// ω × c.
    around: Vector3<T>,
}

impl<'a, T: Scalar> Flight<'a, T> {
    /// * `center` – c, in the body
    /// * `w`, `omega` – velocities after the step
    /// * `E` – turn of the step
    #[inline(always)]
    pub(super) fn new(
        center: &'a Vector3<T>,
        w: Vector3<T>,
        omega: Vector3<T>,
        E: Matrix3<T>,
    ) -> Self {
        let around = cross(&omega, center);
        let velocity = w + around;
        Self {
            center,
            E,
            velocity,
            around,
        }
    }

    /// Shift of the origin in the time `dt`.
    #[inline(always)]
    pub(super) fn shift(&self, dt: T) -> Vector3<T> {
        self.center + self.velocity * dt - rotate(&self.E, self.center)
    }

    /// Velocity of the origin after the step, along the axes of after it.
    #[inline(always)]
    pub(super) fn velocity(&self) -> Vector3<T> {
        rotate_back(&self.E, &self.velocity) - self.around
    }
}
