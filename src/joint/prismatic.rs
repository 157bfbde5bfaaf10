//! Prismatic joint: translation along the local z axis.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;
use rand::Rng;

use super::symmetric_unit;
use crate::scalar::{Over, Scalar};
use crate::spatial::Transform;
use crate::spatial::linear::lift_matrix;

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
