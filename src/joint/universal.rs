//! Universal joint: two revolute joints in series about axes through one point, q = the two angles.
//!
//! Its motion subspace turns with q, so no frame makes it constant. A model has two bodies for it instead, each with a revolute joint,
//! the inner one without inertia: the cross. One name and two coordinates stay together, and no algorithm knows the kind.

use std::f64::consts::PI;

use rand::Rng;

use super::{Axis, Coordinate, Joint, sizes, symmetric_unit};
use crate::scalar::Scalar;
use crate::spatial::Transform;

/// Two angles.
#[derive(Clone, Copy)]
pub(crate) struct Universal;

impl Joint for Universal {
    sizes!(nq = 2, nv = 2: 0 1, axes = []);

    fn measures(self, _k: usize) -> Coordinate {
        Coordinate::Angle
    }

    #[cold]
    fn axis(self, _k: usize) -> Axis {
        panic!("a universal joint moves two bodies, whose revolute joints have the axes");
    }

    #[cold]
    fn transform<T: Scalar>(self, _q: &[T]) -> Transform<T> {
        panic!("a universal joint moves two bodies, whose revolute joints have the poses");
    }

    fn random<R: Rng + ?Sized>(self, rng: &mut R, out: &mut [f64]) {
        out[..2].fill_with(|| PI * symmetric_unit(rng));
    }
}
