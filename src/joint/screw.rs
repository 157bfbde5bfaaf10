//! Screw joint: rotation about the local z axis with an advance along it in proportion; q = angle.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::f64::consts::PI;

use nalgebra::Vector3;
use rand::Rng;

use super::revolute::rotation_z;
use super::{Joint, Pitch, Prismatic, Revolute, sizes, symmetric_unit};
use crate::scalar::{Over, Scalar};
use crate::spatial::Transform;

/// S = (h ẑ; ẑ) with the pitch h.
#[derive(Clone, Copy)]
pub(crate) struct Screw {
    pub(crate) pitch: Pitch,
}

impl Joint for Screw {
    sizes!(nq = 1, nv = 1: 0, axes = [5]);

    #[inline(always)]
    fn pitch(self) -> f64 {
        self.pitch.metres_per_radian()
    }

    fn transform<T: Scalar>(self, q: &[T]) -> Transform<T> {
        let advance = q[0] * self.pitch.metres_per_radian();
        Transform::new(
            rotation_z(q[0]),
            Vector3::new(T::zero(), T::zero(), advance),
        )
    }

    /// The axis stays where a revolute joint turns about it.
    #[inline(always)]
    fn compose<P: Scalar, T: Over<P>>(
        self,
        X_PJ: &Transform<P>,
        q: &[T],
        sin_cos: impl FnOnce() -> (T, T),
    ) -> Transform<T> {
        let advance = [q[0] * self.pitch.metres_per_radian()];
        let moved = Prismatic.compose(X_PJ, &advance, || (T::zero(), T::one()));
        let turned = Revolute.compose(X_PJ, q, sin_cos);
        Transform::new(turned.rotation, moved.translation)
    }

    fn random<R: Rng + ?Sized>(self, rng: &mut R, out: &mut [f64]) {
        out[0] = PI * symmetric_unit(rng);
    }
}
