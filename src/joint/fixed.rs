//! Fixed joint: no motion at all.

use rand::Rng;

use super::Joint;
use crate::scalar::Scalar;
use crate::spatial::Transform;

/// No degree of freedom.
#[derive(Clone, Copy)]
pub(crate) struct Fixed;

impl Joint for Fixed {
    const NQ: usize = 0;
    const NV: usize = 0;
    const AXES: &'static [usize] = &[];

    type PerDof<X: Copy> = [X; 0];

    fn per_dof<X: Copy>(_: impl FnMut(usize) -> X) -> [X; 0] {
        []
    }

    fn transform<T: Scalar>(self, _q: &[T]) -> Transform<T> {
        Transform::identity()
    }

    fn random<R: Rng + ?Sized>(self, _rng: &mut R, _out: &mut [f64]) {}
}
