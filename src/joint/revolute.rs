//! Revolute and continuous joint: rotation about the local z axis.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};
use rand::Rng;

use super::symmetric_unit;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{from_columns, fused, lift_vector};
use crate::spatial::{Force, Motion, Transform};

pub(super) const NQ: usize = 1;
/// Angular z.
pub(super) const AXES: &[usize] = &[5];

/// The rotation matrix about z.
pub(super) fn rotation_z<T: Scalar>(angle: T) -> Matrix3<T> {
    let ((s, c), zero) = (angle.sin_cos(), T::zero());
    Matrix3::new(c, -s, zero, s, c, zero, zero, zero, T::one())
}

pub(super) fn transform<T: Scalar>(q: &[T]) -> Transform<T> {
    Transform::new(rotation_z(q[0]), Vector3::zeros())
}

/// R Rz(q) from sine and cosine of q: the first two columns of R are mixed, the third stays.
#[inline(always)]
pub(super) fn compose<P: Scalar, T: Over<P>>(X_PJ: &Transform<P>, (s, c): (T, T)) -> Transform<T> {
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
pub(super) fn motion_inverse<P: Scalar, T: Over<P>>(q: &[T], V: &Motion<P>) -> Motion<T> {
    let (s, c) = q[0].sin_cos();
    let turned = |a: &Vector3<P>| turned((-s, c), a);
    Motion::new(turned(&V.linear), turned(&V.angular))
}

/// R F: both parts are turned.
#[inline(always)]
pub(super) fn force<P: Scalar, T: Over<P>>(q: &[T], F: &Force<P>) -> Force<T> {
    let sin_cos = q[0].sin_cos();
    Force::new(turned(sin_cos, &F.linear), turned(sin_cos, &F.angular))
}

#[inline(always)]
fn turned<P: Scalar, T: Over<P>>((s, c): (T, T), a: &Vector3<P>) -> Vector3<T> {
    Vector3::new(fused(c, a.x, -s * a.y), fused(s, a.x, c * a.y), a.z.into())
}

pub(super) fn integrate<T: Scalar>(q: &[T], dv: &[T], out: &mut [T]) {
    out[0] = q[0] + dv[0];
}

pub(super) fn difference<T: Scalar>(q0: &[T], q1: &[T], out: &mut [T]) {
    out[0] = q1[0] - q0[0];
}

pub(super) fn neutral<T: Scalar>(out: &mut [T]) {
    out[0] = T::zero();
}

pub(super) fn random<R: Rng + ?Sized>(rng: &mut R, out: &mut [f64]) {
    out[0] = PI * symmetric_unit(rng);
}
