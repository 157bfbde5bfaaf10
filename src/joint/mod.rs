//! Joints: the relative motion of a body and its parent.
//!
//! A joint connects frame J, fixed on the parent P, to the body frame B. Two conventions simplify all algorithms: the joint axis is the local z axis
//! of the body frame, and joint velocities are those of B with respect to J *expressed in B*. Then the motion subspace S of each kind is constant:
//! its columns are coordinate axes of the spatial vector `[linear; angular]`, or for a screw a fixed sum of two of them ([`JointKind::axes`]). `S v`
//! and `Sᵀ f` only select entries, the bias `Ṡ v` is zero, and the tangent space of each kind is a Lie algebra with the exponential of
//! [`Model::integrate`](crate::Model::integrate).
//!
//! No such frame exists for a universal joint: its two axes do not commute, so its configurations are not a Lie group. It has one name and two
//! coordinates, and the tree has two bodies for it, each with a revolute joint; see [`JointKind::Universal`].
//!
//! Each kind is a type in its own file that implements `Joint` (`kind.rs`), and a line of `with_joint!`, which runs code compiled for the kind.
//! [`JointKind`] selects the kind at run time and also implements `Joint` (`at_run_time.rs`): algorithms are compiled for revolute, prismatic and
//! floating joints, and once for all other kinds.
//!
//! All functions take constant time:
//!
//! | question | function | reference |
//! |---|---|---|
//! | how many coordinates, and degrees of freedom? | [`JointKind::nq`], [`JointKind::nv`] | |
//! | in which directions does it move (S)? | [`JointKind::axes`] | [Featherstone 2008, table 4.1] |
//!
//! The effect of a joint on a body is not public: poses, velocities and the manifold of a whole robot are in [`dynamics`](crate::dynamics) and
//! [`Model`](crate::Model). References: [Featherstone 2008, 4.4], [Murray, Li, Sastry 1994, chapter 2] and, for random rotations, [Shoemake 1992].

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

mod at_run_time;
mod axis;
mod fixed;
mod flight;
mod floating;
mod kind;
mod planar;
mod prismatic;
mod revolute;
mod screw;
mod spherical;
mod universal;

use std::fmt;

use nalgebra::Vector3;
use rand::{Rng, RngExt};

pub(crate) use axis::Coordinate;
pub use axis::{Axis, Pitch};
pub(crate) use fixed::Fixed;
use flight::Flight;
pub(crate) use floating::Floating;
use kind::sizes;
pub(crate) use kind::{Joint, with_joint};
pub(crate) use planar::Planar;
pub(crate) use prismatic::Prismatic;
pub(crate) use revolute::Revolute;
pub(crate) use screw::Screw;
pub(crate) use spherical::Spherical;
pub(crate) use universal::Universal;

use crate::scalar::{Over, Scalar};
use crate::spatial::linear::cross;
use crate::spatial::transform::TRANSFORM_ENTRIES;
use crate::spatial::{Force, Motion, SPATIAL, Transform};

/// The kinds of joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JointKind {
    /// No motion. The model merges such bodies into their parents.
    Fixed,
    /// Rotation about the local z axis; q = angle (rad), v = its rate (rad/s).
    Revolute,
    /// A revolute joint without position limits; q = angle (rad), not wrapped.
    Continuous,
    /// Translation along the local z axis; q = distance (m), v = its rate (m/s).
    Prismatic,
    /// Rotation about the local z axis with an advance along it; q = angle (rad), v = its rate (rad/s).
    Screw(Pitch),
    /// Two rotations in series about axes through one point; q = the two angles (rad), v = their rates (rad/s).
    ///
    /// A model has two bodies for such a joint, each with a revolute joint; the inner body has no inertia. So no body has this kind, and the kind has
    /// no [`axes`](Self::axes) and no pose, which would depend on the angle between the axes.
    Universal,
    /// Rotation about a point; q = unit quaternion (w, x, y, z), v = angular velocity in the body frame (rad/s).
    Spherical,
    /// Motion in the local x–y plane; q = (x, y, angle), v = (vx, vy, ω) in the body frame.
    Planar,
    /// Free motion; q = (position, unit quaternion), v = `[linear; angular]` velocity in the body frame.
    Floating,
}

impl JointKind {
    /// All kinds, for tests and tables; the screw advances 10 mm/rad.
    pub const ALL: [Self; 9] = [
        Self::Fixed,
        Self::Revolute,
        Self::Continuous,
        Self::Prismatic,
        Self::Screw(Pitch::per_radian(0.01)),
        Self::Universal,
        Self::Spherical,
        Self::Planar,
        Self::Floating,
    ];

    /// Number of configuration coordinates.
    #[inline(always)]
    pub fn nq(self) -> usize {
        with_joint!(self, joint => joint.nq())
    }

    /// Number of velocity coordinates: degrees of freedom.
    #[inline(always)]
    pub fn nv(self) -> usize {
        with_joint!(self, joint => joint.nv())
    }

    /// `true` if a description gives an axis: of rotation, of translation, or normal to the plane.
    pub(crate) fn has_axis(self) -> bool {
        !matches!(self, Self::Fixed | Self::Spherical | Self::Floating)
    }

    /// `true` if positions have a least and a largest value, each coordinate by itself: revolute, prismatic, screw and universal joints.
    pub(crate) fn has_limits(self) -> bool {
        matches!(
            self,
            Self::Revolute | Self::Prismatic | Self::Screw(_) | Self::Universal
        )
    }

    /// Start of the unit quaternion in a configuration, of kinds that turn about all three axes.
    pub(crate) fn quaternion(self) -> Option<usize> {
        (0..self.nq()).position(|k| self.measures(k) == Coordinate::Quaternion)
    }

    /// Number of bodies of the joint in a model: 0 for a fixed joint, 2 for a universal joint, otherwise 1.
    pub(crate) fn n_bodies(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Universal => 2,
            _ => 1,
        }
    }

    /// The kind of the joint of each of its bodies.
    pub(crate) fn of_body(self) -> Self {
        match self {
            Self::Universal => Self::Revolute,
            own => own,
        }
    }

    /// The columns of the motion subspace S.
    ///
    /// # Panics
    /// If the kind is universal.
    #[inline(always)]
    pub fn axes(self) -> impl Iterator<Item = Axis> {
        #[inline(always)]
        fn axes_of<J: Joint>(joint: J) -> (&'static [usize], f64) {
            assert!(
                joint.coordinates().len() == joint.nv(),
                "a universal joint moves two bodies, whose revolute joints have the axes"
            );
            (joint.coordinates(), joint.pitch())
        }
        let (coordinates, pitch) = with_joint!(self, joint => axes_of(joint));
        coordinates.iter().map(
            #[inline(always)]
            move |&coordinate| Axis::new(coordinate, pitch),
        )
    }

    /// The k-th of the [`axes`](Self::axes).
    #[inline(always)]
    pub(crate) fn axis(self, k: usize) -> Axis {
        with_joint!(self, joint => joint.axis(k))
    }

    /// The pose `X_JB` of the body frame in the joint frame; `q` has length [`nq`](Self::nq).
    ///
    /// # Panics
    /// If the kind is universal.
    pub(crate) fn transform<T: Scalar>(self, q: &[T]) -> Transform<T> {
        with_joint!(self, joint => joint.transform(q))
    }

    /// The pose `X_PB = X_PJ X_JB(q)` of the body frame in the parent, cheaper than the product.
    ///
    /// # Panics
    /// If the kind is universal.
    #[inline(always)]
    pub(crate) fn compose<P: Scalar, T: Over<P>>(
        self,
        X_PJ: &Transform<P>,
        q: &[T],
    ) -> Transform<T> {
        self.compose_turned(
            X_PJ,
            q,
            #[inline(always)]
            || q[0].sin_cos(),
        )
    }

    /// [`compose`](Self::compose) with the sine and cosine of a revolute joint's angle, where they are known.
    #[inline(always)]
    pub(crate) fn compose_turned<P: Scalar, T: Over<P>>(
        self,
        X_PJ: &Transform<P>,
        q: &[T],
        sin_cos: impl FnOnce() -> (T, T),
    ) -> Transform<T> {
        // As numbers, so that the pose of the frequent kinds stays in registers: it would else share memory with this one.
        with_joint!(self, joint => joint.compose(X_PJ, q, sin_cos),
            else Transform::from_entries(self.compose_rare(X_PJ, q)))
    }

    #[inline(never)]
    fn compose_rare<P: Scalar, T: Over<P>>(
        self,
        X_PJ: &Transform<P>,
        q: &[T],
    ) -> [T; TRANSFORM_ENTRIES] {
        with_joint!(self, joint => joint.compose(X_PJ, q, || q[0].sin_cos()).to_entries())
    }

    /// The velocity S v of the body with respect to the joint frame, in the body frame; also S a for accelerations.
    ///
    /// # Panics
    /// If the kind is universal.
    pub(crate) fn motion<T: Scalar>(self, v: &[T]) -> Motion<T> {
        let mut out = Motion::zero();
        self.add_motion(v, &mut out);
        out
    }

    /// V += S v.
    ///
    /// # Panics
    /// If the kind is universal.
    #[inline(always)]
    pub(crate) fn add_motion<T: Scalar>(self, v: &[T], V: &mut Motion<T>) {
        with_joint!(self, joint => joint.add_motion(v, V),
            else *V += Motion::from_array(self.motion_rare(v)));
    }

    /// S v as numbers, so that the motion of the frequent kinds stays in registers.
    #[inline(never)]
    fn motion_rare<T: Scalar>(self, v: &[T]) -> [T; SPATIAL] {
        let mut out = Motion::zero();
        with_joint!(self, joint => joint.add_motion(v, &mut out));
        out.to_array()
    }

    /// V × S v: the velocity-product acceleration of a body that moves with V and whose joint moves with v.
    ///
    /// # Panics
    /// If the kind is universal.
    #[inline(always)]
    pub(crate) fn velocity_product<T: Scalar>(self, V: &Motion<T>, v: &[T]) -> Motion<T> {
        with_joint!(self, joint => joint.velocity_product(V, v),
            else V.cross(&Motion::from_array(self.motion_rare(v))))
    }

    /// Sᵀ F: hands the joint forces of a spatial force on the body, in the body frame, to `each(k, τₖ)`, one coordinate after
    /// the other.
    ///
    /// # Panics
    /// If the kind is universal.
    #[inline(always)]
    pub(crate) fn project<T: Scalar>(self, F: &Force<T>, mut each: impl FnMut(usize, T)) {
        with_joint!(self, joint => joint.project(F, each), else {
            let tau = self.project_rare(F.to_array());
            for (k, &tau) in tau.iter().enumerate().take(self.nv()) {
                each(k, tau);
            }
        });
    }

    /// Sᵀ F from numbers to numbers, so that for the frequent kinds the force stays in registers.
    #[inline(never)]
    fn project_rare<T: Scalar>(self, F: [T; SPATIAL]) -> [T; MAX_NV] {
        let (F, mut out) = (Force::from_array(F), [T::zero(); MAX_NV]);
        with_joint!(self, joint => joint.project(&F, |k, tau| out[k] = tau));
        out
    }

    /// out = q ⊕ dv: follows the constant velocity `dv` (tangent, length nv) for one unit of time.
    #[inline(always)]
    pub(crate) fn integrate<T: Scalar>(self, q: &[T], dv: &[T], out: &mut [T]) {
        // The frequent kinds stay in the caller's loop.
        with_joint!(self, joint => joint.integrate(q, dv, out), else self.integrate_rare(q, dv, out));
    }

    #[inline(never)]
    fn integrate_rare<T: Scalar>(self, q: &[T], dv: &[T], out: &mut [T]) {
        with_joint!(self, joint => joint.integrate(q, dv, out));
    }

    /// [`advance`](Self::advance) of position and velocity of a point of the body in place of its origin.
    ///
    /// * `center` – finds the point, in the body, m; called for kinds other than revolute and prismatic joints
    #[inline(always)]
    pub(crate) fn advance_about<D: Scalar, T: Over<D>>(
        self,
        center: impl FnOnce() -> Vector3<T>,
        q: &[T],
        v: &[T],
        a: &[T],
        dt: D,
        next_q: &mut [T],
        next_v: &mut [T],
    ) {
        match self {
            Self::Revolute | Self::Continuous | Self::Prismatic => {
                let v = dt.scale_add(a[0], v[0]);
                next_v[0] = v;
                next_q[0] = dt.scale_add(v, q[0]);
            }
            _ => self.advance_rare(&center(), q, v, a, dt, next_q, next_v),
        }
    }

    #[inline(never)]
    fn advance_rare<D: Scalar, T: Over<D>>(
        self,
        center: &Vector3<T>,
        q: &[T],
        v: &[T],
        a: &[T],
        dt: D,
        next_q: &mut [T],
        next_v: &mut [T],
    ) {
        T::vectorized(
            #[inline(always)]
            || {
                self.step_velocity(center, v, a, dt, next_v);
                self.move_on(center, q, dt, next_q, next_v);
            },
        );
    }

    /// The first half of a step: the velocity after it, along the axes of before it.
    #[inline(always)]
    pub(crate) fn step_velocity<D: Scalar, T: Over<D>>(
        self,
        center: &Vector3<T>,
        v: &[T],
        a: &[T],
        dt: D,
        next_v: &mut [T],
    ) {
        for (k, v_next) in next_v.iter_mut().enumerate() {
            *v_next = dt.scale_add(a[k], v[k]);
        }
        self.turning(center, v, |k, x| next_v[k] += x * dt);
    }

    /// The second half: the position, and the axes of the velocity with it.
    #[inline(always)]
    pub(crate) fn move_on<D: Scalar, T: Over<D>>(
        self,
        center: &Vector3<T>,
        q: &[T],
        dt: D,
        next_q: &mut [T],
        next_v: &mut [T],
    ) {
        with_joint!(self, joint => joint.advance(center, q, dt, next_q, next_v));
    }

    /// ω × (v + ω × c) of the kinds whose linear velocity turns with the body, along its coordinates. With it, a rate of their velocity becomes the
    /// acceleration ã with which a step goes on: that of the velocity which the origin has, in the joint frame and seen from the body, while the
    /// body turns about the point c and that goes straight on.
    ///
    /// * `center` – c; zero for the acceleration of the origin itself
    #[inline(always)]
    pub(crate) fn turning<T: Scalar>(
        self,
        center: &Vector3<T>,
        v: &[T],
        mut each: impl FnMut(usize, T),
    ) {
        if !self.turns_with_body() {
            return;
        }
        let V = Motion::from_array(self.motion_rare(v));
        let velocity = V.linear + cross(&V.angular, center);
        let turned = cross(&V.angular, &velocity);
        let linear = self.axes().take_while(|axis| !axis.is_angular());
        linear.for_each(|axis| each(axis.coordinate(), turned[axis.coordinate()]));
    }

    /// out = q1 ⊖ q0: the tangent with `integrate(q0, out) = q1`, rotations by the shorter way.
    pub(crate) fn difference<T: Scalar>(self, q0: &[T], q1: &[T], out: &mut [T]) {
        with_joint!(self, joint => joint.difference(q0, q1, out));
    }

    /// The configuration in which B = J.
    pub(crate) fn neutral<T: Scalar>(self, out: &mut [T]) {
        with_joint!(self, joint => joint.neutral(out));
    }

    /// A random configuration: angles in (−π, π), lengths in (−1, 1) m, rotations uniform on SO(3).
    pub(crate) fn random<R: Rng + ?Sized>(self, rng: &mut R, out: &mut [f64]) {
        with_joint!(self, joint => joint.random(rng, out));
    }

    /// The rate of tangent coordinates u that are measured from a fixed configuration, when the joint moves with v:
    /// u̇ = v + ½ \[u, v\] + ¹⁄₁₂ \[u, \[u, v\]\] + O(u⁴), the inverse of the exponential's differential.
    ///
    /// # References
    /// [Hairer, Lubich, Wanner 2006, section III.4]; [Munthe-Kaas 1999].
    pub(crate) fn tangent_rate<T: Scalar>(self, u: &[T], v: &[T], out: &mut [T]) {
        /// Coefficients B₁ = ½ and B₂ / 2! = ¹⁄₁₂ of the series of x / (1 − e⁻ˣ).
        const SERIES: [f64; 2] = [0.5, 1.0 / 12.0];
        out.copy_from_slice(v);
        // One coordinate, or two independent ones, have no brackets.
        if self.nv() <= 1 || self == Self::Universal {
            return;
        }
        let (u, v) = (self.motion(u), self.motion(v));
        let first = u.cross(&v);
        let second = u.cross(&first);
        for (axis, out) in self.axes().zip(out) {
            let k = axis.coordinate();
            *out += first.coordinate(k) * SERIES[0] + second.coordinate(k) * SERIES[1];
        }
    }
}

impl fmt::Display for JointKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fixed => "fixed",
            Self::Revolute => "revolute",
            Self::Continuous => "continuous",
            Self::Prismatic => "prismatic",
            Self::Screw(_) => "screw",
            Self::Universal => "universal",
            Self::Spherical => "spherical",
            Self::Planar => "planar",
            Self::Floating => "floating",
        })
    }
}

/// A number uniform in (−1, 1).
fn symmetric_unit<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    rng.random_range(-1.0..1.0)
}

/// Largest number of degrees of freedom of a joint.
pub(crate) const MAX_NV: usize = SPATIAL;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::Quaternion;
    use approx::assert_relative_eq;
    use nalgebra::Vector3;
    use num_dual::Dual64;
    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    /// The kinds that a body can have.
    fn of_bodies() -> impl Iterator<Item = JointKind> {
        let is_one = |kind: &JointKind| kind.n_bodies() < 2;
        JointKind::ALL.into_iter().filter(is_one)
    }

    fn random_configuration(kind: JointKind, seed: u64) -> Vec<f64> {
        let mut q = vec![0.0; kind.nq()];
        kind.random(&mut Xoshiro256PlusPlus::seed_from_u64(seed), &mut q);
        q
    }

    /// `[Rᵀ ṗ; (Rᵀ Ṙ)^∨]`: the velocity in the body frame of a pose that moves.
    fn body_velocity(X: &Transform<Dual64>) -> [f64; 6] {
        let value = |x: Dual64| x.re;
        let rate = |x: Dual64| x.eps;
        let rotation = X.rotation.map(value);
        let omega = rotation.transpose() * X.rotation.map(rate);
        let linear = rotation.transpose() * X.translation.map(rate);
        [
            linear.x, linear.y, linear.z, omega.m32, omega.m13, omega.m21,
        ]
    }

    /// The pose at time t on the curve q ⊕ t v, with its rate.
    fn moving_pose(kind: JointKind, q: &[f64], v: &[f64], t: f64) -> Transform<Dual64> {
        let t = Dual64::new(t, 1.0);
        let q: Vec<Dual64> = q.iter().map(|&q| q.into()).collect();
        let dv: Vec<Dual64> = v.iter().map(|&v| t * v).collect();
        let mut moved = vec![Dual64::from(0.0); kind.nq()];
        kind.integrate(&q, &dv, &mut moved);
        kind.transform(&moved)
    }

    proptest! {
        #[test]
        fn difference_inverts_integrate_for_every_kind(seed: u64, dv in prop::array::uniform6(-1.7..1.7)) {
            for kind in JointKind::ALL {
                let q0 = random_configuration(kind, seed);
                let dv = &dv[..kind.nv()];
                let (mut q1, mut back) = (q0.clone(), vec![0.0; kind.nv()]);
                kind.integrate(&q0, dv, &mut q1);
                kind.difference(&q0, &q1, &mut back);
                for (a, b) in dv.iter().zip(&back) {
                    prop_assert!((a - b).abs() < 1e-12, "{kind}: {dv:?} came back as {back:?}");
                }
            }
        }

        #[test]
        fn integrate_inverts_difference_for_every_kind(seed: u64) {
            for kind in of_bodies() {
                let (q0, q1) = (random_configuration(kind, seed), random_configuration(kind, seed ^ 1));
                let (mut dv, mut back) = (vec![0.0; kind.nv()], q0.clone());
                kind.difference(&q0, &q1, &mut dv);
                kind.integrate(&q0, &dv, &mut back);
                let (expected, actual) = (kind.transform(&q1), kind.transform(&back));
                prop_assert!((expected.rotation - actual.rotation).norm() < 1e-11, "{kind}");
                prop_assert!((expected.translation - actual.translation).norm() < 1e-11, "{kind}");
            }
        }

        // Along q ⊕ t v the body velocity is S v at every t: S is the derivative of the transform, and its bias is zero.
        #[test]
        fn rate_of_transform_along_a_tangent_equals_motion_subspace(
            seed: u64, v in prop::array::uniform6(-1.5..1.5), t in prop_oneof![Just(0.0), Just(1e-9), -1.5..1.5],
        ) {
            for kind in of_bodies() {
                let q = random_configuration(kind, seed);
                let v = &v[..kind.nv()];
                let rate = body_velocity(&moving_pose(kind, &q, v, t));
                let expected = kind.motion(v).to_array();
                for (a, b) in rate.iter().zip(&expected) {
                    prop_assert!((a - b).abs() < 1e-11, "{kind} at t = {t}: {rate:?} against {expected:?}");
                }
            }
        }

        // With u(t) the tangent coordinates of (q ⊕ u₀) ⊕ t v from q, u̇(0) is the tangent rate, to fourth order in u₀.
        #[test]
        fn tangent_rate_equals_derivative_of_difference(seed: u64, v in prop::array::uniform6(-1.5..1.5)) {
            const SMALL: f64 = 1e-2;
            for kind in JointKind::ALL {
                let q: Vec<Dual64> = random_configuration(kind, seed).iter().map(|&q| q.into()).collect();
                let v = &v[..kind.nv()];
                let u: Vec<f64> = (0..kind.nv()).map(|k| SMALL * (1.0 - 0.3 * k as f64)).collect();
                let tangent = |x: &[f64]| x.iter().map(|&x| x.into()).collect::<Vec<Dual64>>();
                let dv: Vec<Dual64> = v.iter().map(|&v| Dual64::new(0.0, v)).collect();
                let (mut start, mut moved, mut from_q) = (q.clone(), q.clone(), tangent(v));
                kind.integrate(&q, &tangent(&u), &mut start);
                kind.integrate(&start, &dv, &mut moved);
                kind.difference(&q, &moved, &mut from_q);
                let mut rate = vec![0.0; kind.nv()];
                kind.tangent_rate(&u, v, &mut rate);
                for (a, b) in rate.iter().zip(&from_q) {
                    prop_assert!((a - b.eps).abs() < SMALL.powi(4), "{kind}: {a} against {}", b.eps);
                }
            }
        }

        #[test]
        fn shortcuts_equal_the_general_products(seed: u64, x in prop::array::uniform12(-1.5..1.5)) {
            let V = Motion::<f64>::from_array(std::array::from_fn(|k| x[k]));
            let X_PJ = Transform::new(
                Quaternion::exp(&Vector3::new(x[0], x[1], x[2])).to_matrix(),
                Vector3::new(x[3], x[4], x[5]),
            );
            for kind in of_bodies() {
                let (q, v) = (random_configuration(kind, seed), &x[6..6 + kind.nv()]);
                let product = kind.velocity_product(&V, v) - V.cross(&kind.motion(v));
                prop_assert!(product.to_array().iter().all(|x| x.abs() < 1e-14), "{kind}");
                let (direct, product) = (kind.compose(&X_PJ, &q), X_PJ * kind.transform(&q));
                prop_assert!((direct.rotation - product.rotation).norm() < 1e-14, "{kind}");
                prop_assert!((direct.translation - product.translation).norm() < 1e-14, "{kind}");
            }
        }
    }

    #[test]
    fn motions_and_forces_at_a_joint_equal_those_of_its_transform() {
        let V = Motion::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4]);
        let F = Force::from_array([1.3, 0.2, -0.6, -1.0, 0.9, 0.5]);
        for kind in of_bodies() {
            let q = random_configuration(kind, 5);
            let X = kind.transform(&q);
            let motion =
                with_joint!(kind, joint => joint.motion_inverse(&q, &V)) - X.motion_inverse(&V);
            assert!(motion.to_array().iter().all(|x| x.abs() < 1e-15), "{kind}");
            let force = with_joint!(kind, joint => joint.force(&q, &F)) - X.force(&F);
            assert!(force.to_array().iter().all(|x| x.abs() < 1e-15), "{kind}");
        }
    }

    #[test]
    fn projection_is_the_transpose_of_the_motion() {
        let F = Force::from_array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        for kind in of_bodies() {
            let v: Vec<f64> = (0..kind.nv()).map(|k| 0.5 + k as f64).collect();
            let mut tau = vec![0.0; kind.nv()];
            kind.project(&F, |k, x| tau[k] = x);
            let power: f64 = v.iter().zip(&tau).map(|(v, tau)| v * tau).sum();
            assert_relative_eq!(power, kind.motion(&v).power(&F), epsilon = 1e-14);
        }
    }

    #[test]
    fn neutral_configuration_is_the_identity() {
        for kind in of_bodies() {
            let mut q = vec![f64::NAN; kind.nq()];
            kind.neutral(&mut q);
            assert_eq!(kind.transform(&q), Transform::identity(), "{kind}");
        }
    }

    #[test]
    fn quaternions_stay_unit_over_a_million_steps() {
        let mut q = random_configuration(JointKind::Spherical, 3);
        let mut next = q.clone();
        for k in 0..1_000_000 {
            JointKind::Spherical.integrate(
                &q,
                &[0.013, -0.021, 1e-4 * f64::from(k % 7)],
                &mut next,
            );
            std::mem::swap(&mut q, &mut next);
        }
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((norm - 1.0).abs() < 1e-14, "norm {norm}");
    }
}
