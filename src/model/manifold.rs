//! The configuration manifold of a whole robot.

use nalgebra::DVector;
use rand::{Rng, RngExt};

use super::{Body, Model};
use crate::joint::JointKind;
use crate::scalar::Scalar;

impl<P: Scalar> Model<P> {
    /// The configuration in which every joint frame coincides with its body: zeros and identity quaternions. Length `nq`.
    pub fn neutral(&self) -> DVector<f64> {
        let mut q = DVector::zeros(self.nq());
        for body in self.independent() {
            body.joint.neutral(&mut q.as_mut_slice()[q_range(body)]);
        }
        q
    }

    /// q ⊕ dv: the configuration reached from `q` with the constant velocity `dv` (length `nv`) in one unit of time.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn integrate<T: Scalar>(&self, q: &[T], dv: &[T]) -> DVector<T> {
        let mut out = DVector::zeros(self.nq());
        self.integrate_into(q, dv, out.as_mut_slice());
        out
    }

    /// [`integrate`](Self::integrate) without allocation.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn integrate_into<T: Scalar>(&self, q: &[T], dv: &[T], out: &mut [T]) {
        self.check_q(q);
        self.check_v(dv);
        self.check_q(out);
        for body in self.independent() {
            body.joint.integrate(
                &q[q_range(body)],
                &dv[v_range(body)],
                &mut out[q_range(body)],
            );
        }
    }

    /// q1 ⊖ q0: the tangent vector (length `nv`) with `integrate(q0, q1 ⊖ q0) = q1`. Rotations go the shorter way; revolute and
    /// continuous joints are plain numbers, which are not wrapped.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn difference<T: Scalar>(&self, q0: &[T], q1: &[T]) -> DVector<T> {
        let mut out = DVector::zeros(self.nv());
        self.difference_into(q0, q1, out.as_mut_slice());
        out
    }

    /// [`difference`](Self::difference) without allocation.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn difference_into<T: Scalar>(&self, q0: &[T], q1: &[T], out: &mut [T]) {
        self.check_q(q0);
        self.check_q(q1);
        self.check_v(out);
        for body in self.independent() {
            body.joint.difference(
                &q0[q_range(body)],
                &q1[q_range(body)],
                &mut out[v_range(body)],
            );
        }
    }

    /// The configuration at the fraction `t` of the way from `q0` to `q1`: q0 ⊕ t (q1 ⊖ q0).
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn interpolate<T: Scalar>(&self, q0: &[T], q1: &[T], t: T) -> DVector<T> {
        let dv = self.difference(q0, q1).map(|x| x * t);
        self.integrate(q0, dv.as_slice())
    }

    /// out = u̇, the rate of the tangent coordinates `u` measured from a fixed configuration when the robot moves with `v`; see
    /// [`JointKind::tangent_rate`].
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn tangent_rate_into<T: Scalar>(&self, u: &[T], v: &[T], out: &mut [T]) {
        self.check_v(u);
        self.check_v(v);
        self.check_v(out);
        for body in self.independent() {
            body.joint.tangent_rate(
                &u[v_range(body)],
                &v[v_range(body)],
                &mut out[v_range(body)],
            );
        }
    }

    /// A random configuration: within the position limits where a joint has both, else as in [`JointKind::random`] and moved
    /// into the limit that there is; rotations are uniform on SO(3).
    pub fn random_configuration<R: Rng + ?Sized>(&self, rng: &mut R) -> DVector<f64> {
        let mut q = DVector::zeros(self.nq());
        for body in self.independent() {
            body.joint.random(rng, &mut q.as_mut_slice()[q_range(body)]);
        }
        for joint in self.joints() {
            let body = self.body(joint.body);
            if body.coupling.is_some()
                || body.joint.nq() != 1
                || body.joint == JointKind::Continuous
            {
                continue;
            }
            let q = &mut q[body.q];
            *q = match (joint.limits.lower, joint.limits.upper) {
                (Some(lower), Some(upper)) if lower < upper => rng.random_range(lower..upper),
                (Some(lower), Some(_)) => lower,
                (Some(lower), None) => q.max(lower),
                (None, Some(upper)) => q.min(upper),
                (None, None) => *q,
            };
        }
        q
    }

    /// The bodies whose joints have coordinates of their own.
    pub(crate) fn independent(&self) -> impl Iterator<Item = &Body<P>> {
        self.bodies().iter().filter(|body| body.coupling.is_none())
    }

    pub(crate) fn check_q<T>(&self, q: &[T]) {
        assert_eq!(
            q.len(),
            self.nq(),
            "a configuration of \"{}\" has nq = {} entries",
            self.name(),
            self.nq()
        );
    }

    pub(crate) fn check_v<T>(&self, v: &[T]) {
        assert_eq!(
            v.len(),
            self.nv(),
            "a tangent vector of \"{}\" has nv = {} entries",
            self.name(),
            self.nv()
        );
    }
}

impl<P: Scalar> Model<P> {
    /// External forces are given for every body, or for none.
    pub(crate) fn check_external<F>(&self, external: &[F]) {
        let n = external.len();
        assert!(
            n == 0 || n == self.n_bodies(),
            "\"{}\" has {} bodies, got {n} external forces",
            self.name(),
            self.n_bodies()
        );
    }
}

/// Where a body's joint has its configuration.
#[inline]
pub(crate) fn q_range<P>(body: &Body<P>) -> std::ops::Range<usize> {
    body.q..body.q + body.joint.nq()
}

/// Where a body's joint has its velocity.
#[inline]
pub(crate) fn v_range<P>(body: &Body<P>) -> std::ops::Range<usize> {
    body.v..body.v + body.joint.nv()
}
