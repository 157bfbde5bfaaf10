//! Prismatic joint: translation along the local z axis.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;
use rand::Rng;

use super::revolute::cross_z;
use super::{Joint, sizes, symmetric_unit};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{fused, lift_matrix, lift_vector, zero};
use crate::spatial::{ArticulatedInertia, Force, Motion, Transform};

/// S = (ẑ; 0).
#[derive(Clone, Copy)]
pub(crate) struct Prismatic;

impl Joint for Prismatic {
    sizes!(nq = 1, nv = 1: 0, axes = [2]);

    fn transform<T: Scalar>(self, q: &[T]) -> Transform<T> {
        Transform::from_translation(Vector3::new(T::zero(), T::zero(), q[0]))
    }

    /// p + R ẑ q: the rotation stays.
    #[inline(always)]
    fn compose<P: Scalar, T: Over<P>>(
        self,
        X_PJ: &Transform<P>,
        q: &[T],
        _sin_cos: impl FnOnce() -> (T, T),
    ) -> Transform<T> {
        let (r, p) = (&X_PJ.rotation, &X_PJ.translation);
        let along = |axis: P, origin: P| q[0] * axis + origin;
        let translation = Vector3::new(along(r.m13, p.x), along(r.m23, p.y), along(r.m33, p.z));
        Transform::new(lift_matrix(r), translation)
    }

    /// (v + ω × ẑ q; ω)
    #[inline(always)]
    fn motion_inverse<P: Scalar, T: Over<P>>(self, q: &[T], V: &Motion<P>) -> Motion<T> {
        let (v, w) = (lift_vector::<P, T>(&V.linear), &V.angular);
        let linear = Vector3::new(fused(q[0], w.y, v.x), fused(-q[0], w.x, v.y), v.z);
        Motion::new(linear, lift_vector(w))
    }

    /// (f; n + ẑ q × f)
    #[inline(always)]
    fn force<P: Scalar, T: Over<P>>(self, q: &[T], F: &Force<P>) -> Force<T> {
        let (f, n) = (&F.linear, lift_vector::<P, T>(&F.angular));
        let angular = Vector3::new(fused(-q[0], f.y, n.x), fused(q[0], f.x, n.y), n.z);
        Force::new(lift_vector(f), angular)
    }

    /// (v; ω) × (ẑ v₀; 0)
    #[inline(always)]
    fn velocity_product<T: Scalar>(self, V: &Motion<T>, v: &[T]) -> Motion<T> {
        Motion::new(cross_z(&V.angular, v[0]), zero())
    }

    #[inline(always)]
    fn times_velocity_product<T: Scalar>(
        self,
        I: &ArticulatedInertia<T>,
        C: &Motion<T>,
    ) -> Force<T> {
        I.times_in_plane(C)
    }

    fn random<R: Rng + ?Sized>(self, rng: &mut R, out: &mut [f64]) {
        out[0] = symmetric_unit(rng);
    }
}
