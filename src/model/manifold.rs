//! The configuration manifold of a whole robot.

use nalgebra::DVector;
use rand::{Rng, RngExt};

use super::{Body, BodyId, Model};
use crate::joint::JointKind;
use crate::scalar::{Over, Scalar};

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

    /// Computes a step of semi-implicit Euler from configuration `q` and velocity `v` with the acceleration `a` held for the time `dt` (s), joint
    /// by joint; see [`JointKind::advance`]. For linear velocities in body axes the step moves the centre of mass.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub(crate) fn advance_into<T: Over<P>>(
        &self,
        q: &[T],
        v: &[T],
        a: &[T],
        dt: P,
        next_q: &mut [T],
        next_v: &mut [T],
    ) {
        self.check_q(q);
        self.check_v(v);
        self.check_v(a);
        self.check_q(next_q);
        self.check_v(next_v);
        for body in self.independent() {
            let (own_q, own_v) = (q_range(body), v_range(body));
            body.joint.advance_about(
                || body.center(),
                &q[own_q.clone()],
                &v[own_v.clone()],
                &a[own_v.clone()],
                dt,
                &mut next_q[own_q],
                &mut next_v[own_v],
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
    /// If a slice has the wrong length, or the fraction is not finite.
    pub fn interpolate<T: Scalar>(&self, q0: &[T], q1: &[T], t: T) -> DVector<T> {
        let is_finite = !t.has_value() || (0..T::LANES).all(|lane| t.value(lane).is_finite());
        assert!(is_finite, "the fraction t must be finite, got {t:?}");
        let dv = self.difference(q0, q1).map(|x| x * t);
        self.integrate(q0, dv.as_slice())
    }

    /// out = u̇, the rate of the tangent coordinates `u` measured from a fixed configuration when the robot moves with `v`:
    /// the inverse of the right Jacobian of the exponential of each joint.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub(crate) fn tangent_rate_into<T: Scalar>(&self, u: &[T], v: &[T], out: &mut [T]) {
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

    /// A random configuration: within the position limits of joints with both limits, otherwise within ±π or ±1 m and clamped to an existing limit;
    /// rotations are uniform on SO(3).
    pub fn random_configuration<R: Rng + ?Sized>(&self, rng: &mut R) -> DVector<f64> {
        let mut q = DVector::zeros(self.nq());
        for body in self.independent() {
            body.joint.random(rng, &mut q.as_mut_slice()[q_range(body)]);
        }
        for joint in self.joint_parts() {
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

    /// A random velocity (length `nv`): each coordinate uniform in ±`speed` (rad/s or m/s), and within the speed limits of its joint and its mimic joints.
    ///
    /// # Panics
    /// If `speed` is negative or not finite.
    pub fn random_velocity<R: Rng + ?Sized>(&self, rng: &mut R, speed: f64) -> DVector<f64> {
        assert!(
            speed >= 0.0 && speed.is_finite(),
            "the speed is {speed}: negative or not finite"
        );
        let mut largest = DVector::from_element(self.nv(), speed);
        for joint in self.joint_parts() {
            let body = self.body(joint.body);
            let ratio = (body.coupling).map_or(1.0, |coupling| coupling.ratio.value(0).abs());
            if let Some(limit) = joint.limits.velocity {
                let at = &mut largest.as_mut_slice()[v_range(body)];
                at.iter_mut().for_each(|x| *x = x.min(limit / ratio));
            }
        }
        largest.map(|largest| largest * rng.random_range(-1.0..1.0))
    }

    /// The bodies whose joints have coordinates of their own.
    pub(crate) fn independent(&self) -> impl Iterator<Item = &Body<P>> {
        self.bodies().iter().filter(|body| body.coupling.is_none())
    }

    /// [`independent`](Self::independent) with the index of each body.
    pub(crate) fn independent_with_ids(&self) -> impl Iterator<Item = (BodyId, &Body<P>)> {
        let all = self.bodies().iter().enumerate();
        let own = all.filter(|(_, body)| body.coupling.is_none());
        own.map(|(i, body)| (BodyId(i), body))
    }

    #[inline]
    pub(crate) fn check_q<T>(&self, q: &[T]) {
        assert_eq!(
            q.len(),
            self.nq(),
            "a configuration of \"{}\" has nq = {} entries",
            self.name(),
            self.nq()
        );
    }

    #[inline]
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
    #[inline]
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

/// Range of a body's joint in the configuration.
#[inline]
pub(crate) fn q_range<P>(body: &Body<P>) -> std::ops::Range<usize> {
    body.q..body.q + body.joint.nq()
}

/// Range of a body's joint in the velocity.
#[inline]
pub(crate) fn v_range<P>(body: &Body<P>) -> std::ops::Range<usize> {
    body.v..body.v + body.joint.nv()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{JointSpec, Limits, LinkSpec, ModelBuilder, samples};
    use crate::spatial::Quaternion;
    use nalgebra::Matrix3;
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    // For the Haar measure on SO(3):  E[R] = 0, E[tr R] = 0, E[(tr R)²] = 1, and the angle has the mean π/2 + 2/π.
    #[test]
    fn moments_of_random_rotations_equal_those_of_the_haar_measure() {
        /// Number of draws.
        const N: u32 = 40_000;
        /// Six standard errors of a mean over N draws with a variance of one at most.
        const SIX_SIGMA: f64 = 6.0 / 200.0;
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let (mut mean, mut square, mut angle) = (Matrix3::zeros(), 0.0, 0.0);
        for _ in 0..N {
            let mut q = [0.0; 4];
            JointKind::Spherical.random(&mut rng, &mut q);
            let rotation = Quaternion::from_slice(&q);
            mean += rotation.to_matrix() / f64::from(N);
            square += rotation.to_matrix().trace().powi(2) / f64::from(N);
            angle += rotation.log().norm() / f64::from(N);
        }
        assert!(mean.amax() < SIX_SIGMA, "{mean}");
        assert!(mean.trace().abs() < SIX_SIGMA, "{}", mean.trace());
        assert!((square - 1.0).abs() < SIX_SIGMA * 2.0, "{square}");
        let expected = std::f64::consts::FRAC_PI_2 + std::f64::consts::FRAC_2_PI;
        assert!((angle - expected).abs() < SIX_SIGMA, "{angle}");
    }

    #[test]
    fn random_states_are_within_all_limits_and_reach_them() {
        let limits = Limits {
            lower: Some(0.5),
            upper: Some(0.7),
            velocity: Some(0.2),
            effort: None,
        };
        let mut builder = ModelBuilder::new("elbow");
        builder.add_link(LinkSpec::new("world"));
        builder.add_link(LinkSpec::new("arm").with_mass(1.0, [0.0; 3], [0.1; 3]));
        builder.add_joint(
            JointSpec::new("elbow", JointKind::Revolute, "world", "arm").with_limits(limits),
        );
        let model = builder.build().unwrap();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let (mut largest, mut fastest) = (0.0_f64, 0.0_f64);
        for _ in 0..1000 {
            let (q, v) = (
                model.random_configuration(&mut rng)[0],
                model.random_velocity(&mut rng, 5.0)[0],
            );
            assert!((0.5..=0.7).contains(&q) && v.abs() <= 0.2, "{q}, {v}");
            (largest, fastest) = (largest.max(q), fastest.max(v.abs()));
        }
        assert!(largest > 0.69 && fastest > 0.19);
        let v = samples::random_tree(12, 1).random_velocity(&mut rng, 0.0);
        assert_eq!(v.amax(), 0.0);
    }
}
