//! Revolute and continuous joint: rotation about the local z axis.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};
use rand::Rng;

use super::{Joint, sizes, symmetric_unit};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{from_columns, fused, lift_vector};
use crate::spatial::{ArticulatedInertia, Force, Motion, Transform};

/// The rotation matrix about z.
pub(super) fn rotation_z<T: Scalar>(angle: T) -> Matrix3<T> {
    let ((s, c), zero) = (angle.sin_cos(), T::zero());
    Matrix3::new(c, -s, zero, s, c, zero, zero, zero, T::one())
}

/// S = (0; ẑ).
#[derive(Clone, Copy)]
pub(crate) struct Revolute;

impl Joint for Revolute {
    sizes!(nq = 1, nv = 1: 0, axes = [5]);

    fn transform<T: Scalar>(self, q: &[T]) -> Transform<T> {
        Transform::new(rotation_z(q[0]), Vector3::zeros())
    }

    /// R Rz(q): the first two columns of R are mixed, the third stays.
    #[inline(always)]
    fn compose<P: Scalar, T: Over<P>>(
        self,
        X_PJ: &Transform<P>,
        _q: &[T],
        sin_cos: impl FnOnce() -> (T, T),
    ) -> Transform<T> {
        let (s, c) = sin_cos();
        let r = &X_PJ.rotation;
        let (x, y) = (
            Vector3::new(r.m11, r.m21, r.m31),
            Vector3::new(r.m12, r.m22, r.m32),
        );
        let mix = |a: T, b: T| {
            let of = |x: P, y: P| fused(a, x, b * y);
            Vector3::new(of(x.x, y.x), of(x.y, y.y), of(x.z, y.z))
        };
        let z = lift_vector::<P, T>(&Vector3::new(r.m13, r.m23, r.m33));
        Transform::new(
            from_columns(&mix(c, s), &mix(-s, c), &z),
            lift_vector(&X_PJ.translation),
        )
    }

    /// Rᵀ V: both parts are turned back.
    #[inline(always)]
    fn motion_inverse<P: Scalar, T: Over<P>>(self, q: &[T], V: &Motion<P>) -> Motion<T> {
        let (s, c) = q[0].sin_cos();
        let turned = |a: &Vector3<P>| turned(-s, c, a);
        Motion::new(turned(&V.linear), turned(&V.angular))
    }

    /// R F: both parts are turned.
    #[inline(always)]
    fn force<P: Scalar, T: Over<P>>(self, q: &[T], F: &Force<P>) -> Force<T> {
        let (s, c) = q[0].sin_cos();
        Force::new(turned(s, c, &F.linear), turned(s, c, &F.angular))
    }

    /// (v; ω) × (0; ẑ v₀)
    #[inline(always)]
    fn velocity_product<T: Scalar>(self, V: &Motion<T>, v: &[T]) -> Motion<T> {
        Motion::new(cross_z(&V.linear, v[0]), cross_z(&V.angular, v[0]))
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
        out[0] = PI * symmetric_unit(rng);
    }
}

/// a × ẑ s
#[inline(always)]
pub(super) fn cross_z<T: Scalar>(a: &Vector3<T>, s: T) -> Vector3<T> {
    Vector3::new(a.y * s, -(a.x * s), T::zero())
}

#[inline(always)]
fn turned<P: Scalar, T: Over<P>>(s: T, c: T, a: &Vector3<P>) -> Vector3<T> {
    Vector3::new(fused(c, a.x, -s * a.y), fused(s, a.x, c * a.y), a.z.into())
}
