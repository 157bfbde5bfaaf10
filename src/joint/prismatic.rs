//! Prismatic joint: translation along the local z axis.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;
use rand::Rng;

use super::symmetric_unit;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{fused, lift_matrix, lift_vector};
use crate::spatial::{Force, Motion, Transform};

pub(super) const NQ: usize = 1;
/// Linear z.
pub(super) const AXES: &[usize] = &[2];

pub(super) fn transform<T: Scalar>(q: &[T]) -> Transform<T> {
    Transform::from_translation(Vector3::new(T::zero(), T::zero(), q[0]))
}

/// p + R ẑ q: the rotation stays.
#[inline]
pub(super) fn compose<P: Scalar, T: Over<P>>(X_PJ: &Transform<P>, q: &[T]) -> Transform<T> {
    let (r, p) = (&X_PJ.rotation, &X_PJ.translation);
    let along = |axis: P, origin: P| q[0] * axis + origin;
    let translation = Vector3::new(along(r.m13, p.x), along(r.m23, p.y), along(r.m33, p.z));
    Transform::new(lift_matrix(r), translation)
}

/// (v + ω × ẑ q; ω)
#[inline(always)]
pub(super) fn motion_inverse<P: Scalar, T: Over<P>>(q: &[T], V: &Motion<P>) -> Motion<T> {
    let (v, w) = (lift_vector::<P, T>(&V.linear), &V.angular);
    let linear = Vector3::new(fused(q[0], w.y, v.x), fused(-q[0], w.x, v.y), v.z);
    Motion::new(linear, lift_vector(w))
}

/// (f; n + ẑ q × f)
#[inline(always)]
pub(super) fn force<P: Scalar, T: Over<P>>(q: &[T], F: &Force<P>) -> Force<T> {
    let (f, n) = (&F.linear, lift_vector::<P, T>(&F.angular));
    let angular = Vector3::new(fused(-q[0], f.y, n.x), fused(q[0], f.x, n.y), n.z);
    Force::new(lift_vector(f), angular)
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
    out[0] = symmetric_unit(rng);
}
