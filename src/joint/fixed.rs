//! Fixed joint: no motion at all.

use rand::Rng;

use super::{Joint, sizes};
use crate::scalar::Scalar;
use crate::spatial::Transform;

/// No degree of freedom.
#[derive(Clone, Copy)]
pub(crate) struct Fixed;

impl Joint for Fixed {
    sizes!(nq = 0, nv = 0: , axes = []);

    fn transform<T: Scalar>(self, _q: &[T]) -> Transform<T> {
        Transform::identity()
    }

    fn random<R: Rng + ?Sized>(self, _rng: &mut R, _out: &mut [f64]) {}
}
