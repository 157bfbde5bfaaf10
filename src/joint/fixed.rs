//! Fixed joint: no motion at all.

use rand::Rng;

use crate::scalar::Scalar;
use crate::spatial::Transform;

pub(super) const NQ: usize = 0;
pub(super) const AXES: &[usize] = &[];

pub(super) fn transform<T: Scalar>(_q: &[T]) -> Transform<T> {
    Transform::identity()
}

pub(super) fn integrate<T: Scalar>(_q: &[T], _dv: &[T], _out: &mut [T]) {}

pub(super) fn difference<T: Scalar>(_q0: &[T], _q1: &[T], _out: &mut [T]) {}

pub(super) fn neutral<T: Scalar>(_out: &mut [T]) {}

pub(super) fn random<R: Rng + ?Sized>(_rng: &mut R, _out: &mut [f64]) {}
