//! Planar joint: SE(2) in the local x–y plane, q = (x, y, angle), v = (vx, vy, ω) in the body frame.
//!
//! The angle is not wrapped by motion; the difference of two poses turns the shorter way.

use std::f64::consts::PI;

use nalgebra::Vector3;
use rand::Rng;

use super::revolute::rotation_z;
use super::{Flight, Joint, sizes, symmetric_unit};
use crate::scalar::{Over, Scalar};
use crate::spatial::Transform;
use crate::spatial::exponential::{exp_translation, log_translation};
use crate::spatial::linear::{rotate, rotate_back};

/// Linear x, linear y, angular z.
#[derive(Clone, Copy)]
pub(crate) struct Planar;

impl Joint for Planar {
    sizes!(nq = 3, nv = 3: 0 1 2, axes = [0, 1, 5]);

    #[inline(always)]
    fn turns_with_body(self) -> bool {
        true
    }

    fn transform<T: Scalar>(self, q: &[T]) -> Transform<T> {
        Transform::new(rotation_z(q[2]), in_plane(q[0], q[1]))
    }

    fn integrate<T: Scalar>(self, q: &[T], dv: &[T], out: &mut [T]) {
        let step = exp_translation(&in_plane(dv[0], dv[1]), &about_z(dv[2]));
        let p = in_plane(q[0], q[1]) + rotate(&rotation_z(q[2]), &step);
        out[..3].copy_from_slice(&[p.x, p.y, q[2] + dv[2]]);
    }

    #[inline(always)]
    fn advance<D: Scalar, T: Over<D>>(
        self,
        center: &Vector3<T>,
        q: &[T],
        dt: D,
        next_q: &mut [T],
        next_v: &mut [T],
    ) {
        let (w, turn) = (in_plane(next_v[0], next_v[1]), next_v[2] * dt);
        let flight = Flight::new(center, w, about_z(next_v[2]), rotation_z(turn));
        let shift = flight.shift(T::from(dt));
        let p = in_plane(q[0], q[1]) + rotate(&rotation_z(q[2]), &shift);
        let linear = flight.velocity();
        next_q[..3].copy_from_slice(&[p.x, p.y, q[2] + turn]);
        next_v[..2].copy_from_slice(&[linear.x, linear.y]);
    }

    fn difference<T: Scalar>(self, q0: &[T], q1: &[T], out: &mut [T]) {
        let (sin, cos) = (q1[2] - q0[2]).sin_cos();
        let angle = sin.atan2(cos);
        let step = rotate_back(&rotation_z(q0[2]), &in_plane(q1[0] - q0[0], q1[1] - q0[1]));
        let rho = log_translation(&step, &about_z(angle));
        out[..3].copy_from_slice(&[rho.x, rho.y, angle]);
    }

    fn neutral<T: Scalar>(self, out: &mut [T]) {
        out[..3].fill(T::zero());
    }

    fn random<R: Rng + ?Sized>(self, rng: &mut R, out: &mut [f64]) {
        out[..3].copy_from_slice(&[
            symmetric_unit(rng),
            symmetric_unit(rng),
            PI * symmetric_unit(rng),
        ]);
    }
}

#[inline]
fn in_plane<T: Scalar>(x: T, y: T) -> Vector3<T> {
    Vector3::new(x, y, T::zero())
}

#[inline]
fn about_z<T: Scalar>(angle: T) -> Vector3<T> {
    Vector3::new(T::zero(), T::zero(), angle)
}
