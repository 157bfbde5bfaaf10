//! Floating joint: SE(3), q = (position, unit quaternion w, x, y, z), v = `[linear; angular]` velocity in the body frame.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;
use rand::Rng;

use super::spherical::{self, Spherical};
use super::{Coordinate, Flight, Joint, sizes, symmetric_unit};
use crate::scalar::{Over, Scalar};
use crate::spatial::exponential::{exp_translation, log_translation};
use crate::spatial::linear::{rotate, rotate_back};
use crate::spatial::{Quaternion, Transform};

/// All coordinates.
#[derive(Clone, Copy)]
pub(crate) struct Floating;

impl Joint for Floating {
    sizes!(nq = 7, nv = 6: 0 1 2 3 4 5, axes = [0, 1, 2, 3, 4, 5]);

    fn measures(self, k: usize) -> Coordinate {
        match k {
            0..3 => Coordinate::Length,
            _ => Coordinate::Quaternion,
        }
    }

    #[inline(always)]
    fn turns_with_body(self) -> bool {
        true
    }

    #[inline(always)]
    fn transform<T: Scalar>(self, q: &[T]) -> Transform<T> {
        Transform::new(Quaternion::from_slice(&q[3..]).to_matrix(), vector(q))
    }

    fn integrate<T: Scalar>(self, q: &[T], dv: &[T], out: &mut [T]) {
        let (rho, phi) = (vector(dv), vector(&dv[3..]));
        let R = Quaternion::from_slice(&q[3..]).to_matrix();
        let p = vector(q) + rotate(&R, &exp_translation(&rho, &phi));
        out[..3].copy_from_slice(p.as_slice());
        spherical::turned(&q[3..], Quaternion::exp(&phi)).write_to(&mut out[3..]);
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
        let (dt, omega) = (T::from(dt), vector(&next_v[3..]));
        let R = Quaternion::from_slice(&q[3..]).to_matrix();
        let turn = Quaternion::exp(&(omega * dt));
        let flight = Flight::new(center, vector(next_v), omega, turn.to_matrix());
        let p = vector(q) + rotate(&R, &flight.shift(dt));
        next_q[..3].copy_from_slice(p.as_slice());
        next_v[..3].copy_from_slice(flight.velocity().as_slice());
        spherical::turned(&q[3..], turn).write_to(&mut next_q[3..]);
    }

    fn difference<T: Scalar>(self, q0: &[T], q1: &[T], out: &mut [T]) {
        let phi = spherical::turn_between(&q0[3..], &q1[3..]);
        let R = Quaternion::from_slice(&q0[3..]).to_matrix();
        let rho = log_translation(&rotate_back(&R, &(vector(q1) - vector(q0))), &phi);
        out[..3].copy_from_slice(rho.as_slice());
        out[3..6].copy_from_slice(phi.as_slice());
    }

    fn neutral<T: Scalar>(self, out: &mut [T]) {
        out[..3].fill(T::zero());
        Spherical.neutral(&mut out[3..]);
    }

    fn random<R: Rng + ?Sized>(self, rng: &mut R, out: &mut [f64]) {
        out[..3].fill_with(|| symmetric_unit(rng));
        Spherical.random(rng, &mut out[3..]);
    }
}

#[inline(always)]
fn vector<T: Scalar>(x: &[T]) -> Vector3<T> {
    Vector3::new(x[0], x[1], x[2])
}
