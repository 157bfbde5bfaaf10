//! Spherical joint: rotation about a point, q = unit quaternion (w, x, y, z), v = angular velocity in the body frame.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::{Rng, RngExt};

use super::{Coordinate, Joint, sizes};
use crate::scalar::Scalar;
use crate::spatial::{Quaternion, Transform};

/// All angular coordinates.
#[derive(Clone, Copy)]
pub(crate) struct Spherical;

impl Joint for Spherical {
    sizes!(nq = 4, nv = 3: 0 1 2, axes = [3, 4, 5]);

    fn measures(self, _k: usize) -> Coordinate {
        Coordinate::Quaternion
    }

    fn transform<T: Scalar>(self, q: &[T]) -> Transform<T> {
        Transform::new(Quaternion::from_slice(q).to_matrix(), Vector3::zeros())
    }

    fn integrate<T: Scalar>(self, q: &[T], dv: &[T], out: &mut [T]) {
        let turn = Quaternion::exp(&Vector3::new(dv[0], dv[1], dv[2]));
        turned(q, turn).write_to(out);
    }

    fn difference<T: Scalar>(self, q0: &[T], q1: &[T], out: &mut [T]) {
        out[..3].copy_from_slice(turn_between(q0, q1).as_slice());
    }

    fn neutral<T: Scalar>(self, out: &mut [T]) {
        Quaternion::identity().write_to(out);
    }

    /// Uniform on SO(3) [Shoemake 1992].
    fn random<R: Rng + ?Sized>(self, rng: &mut R, out: &mut [f64]) {
        let u: f64 = rng.random();
        let (s1, c1) = (TAU * rng.random::<f64>()).sin_cos();
        let (s2, c2) = (TAU * rng.random::<f64>()).sin_cos();
        let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
        out[..4].copy_from_slice(&[b * c2, a * s1, a * c1, b * s2]);
    }
}

/// q and then a turn, with one Newton step towards unit norm: rounding does not add up over many steps.
#[inline(always)]
pub(super) fn turned<T: Scalar>(q: &[T], turn: Quaternion<T>) -> Quaternion<T> {
    let turned = Quaternion::from_slice(q) * turn;
    // 1/√n ≈ (3 − n)/2 next to n = 1
    let correction = -(turned.norm_squared() * 0.5) + 1.5;
    Quaternion {
        w: turned.w * correction,
        xyz: turned.xyz * correction,
    }
}

/// The rotation vector from one orientation to another, in the frame of the first.
pub(super) fn turn_between<T: Scalar>(q0: &[T], q1: &[T]) -> Vector3<T> {
    (Quaternion::from_slice(q0).conjugate() * Quaternion::from_slice(q1)).log()
}
