//! A moving body, its joint, and the coordinates of the joint.
//!
//! A joint has its own coordinates, or is a mimic joint. Only the functions here distinguish both cases: algorithms pass the whole of `q`, `v` or
//! `τ`, and the body selects its part.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::BodyId;
use super::manifold::{q_range, v_range};
use crate::joint::{Axis, Joint as _, JointKind};
use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::lift_vector;
use crate::spatial::transform::TRANSFORM_ENTRIES;
use crate::spatial::{Force, Inertia, Motion, Transform};

/// A moving body with its joint.
///
/// The body frame B is the joint's moving frame: its z axis is the axis of a revolute or prismatic joint. Links are frames on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Body<P> {
    /// The parent body; `None` is the world.
    pub parent: Option<BodyId>,
    /// Kind of the joint of the body.
    pub joint: JointKind,
    /// Pose `X_PJ` of the joint frame in the parent body (or the world).
    pub placement: Transform<P>,
    /// Inertia of all links merged into the body, in the body frame.
    pub inertia: Inertia<P>,
    /// Index of the joint's first configuration coordinate; of a mimic joint, that of its leader.
    pub q: usize,
    /// Index of the joint's first velocity coordinate; of a mimic joint, that of its leader.
    pub v: usize,
    /// Coupling of a mimic joint to its leader; `None` for a joint with its own coordinates.
    pub coupling: Option<Coupling<P>>,
    /// Index one past the last body of the subtree that starts here.
    pub subtree_end: usize,
}

numbers! { struct Body {
    parent: kept(), joint: kept(), placement: part(Transform), inertia: part(Inertia),
    q: kept(), v: kept(), coupling: part(Coupling), subtree_end: kept(),
} }

/// The position of a mimic joint is ratio · `q_leader` + offset, its velocity ratio · `v_leader`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling<P = f64> {
    /// Ratio of the rates.
    pub ratio: P,
    /// Position at the leader's zero, rad or m.
    pub offset: P,
}

numbers! { struct Coupling { ratio: Finite("ratio"), offset: Finite("offset") } }

impl<P: Scalar> Body<P> {
    /// Pose `X_PB` of the body in its parent, at the robot's configuration `q`.
    #[inline(always)]
    pub fn place<T: Over<P>>(&self, q: &[T]) -> Transform<T> {
        match self.coupling {
            None => self.joint.compose(&self.placement, &q[q_range(self)]),
            Some(coupling) => self.place_mimic(coupling, q),
        }
    }

    /// [`place`](Self::place) with the sines and cosines of all of `q`, which are computed together for speed.
    #[inline(always)]
    pub(crate) fn place_turned<T: Over<P>>(&self, q: &[T], sin_cos: &[(T, T)]) -> Transform<T> {
        match self.coupling {
            None => {
                let own = &q[q_range(self)];
                self.joint
                    .compose_turned(&self.placement, own, || sin_cos[self.q])
            }
            Some(coupling) => self.place_mimic(coupling, q),
        }
    }

    /// As numbers, so that the poses of other bodies stay in registers: they would else share memory with this one.
    #[inline(always)]
    fn place_mimic<T: Over<P>>(&self, at: Coupling<P>, q: &[T]) -> Transform<T> {
        Transform::from_entries(self.compose_mimic(at, q))
    }

    #[inline(never)]
    fn compose_mimic<T: Over<P>>(
        &self,
        Coupling { ratio, offset }: Coupling<P>,
        q: &[T],
    ) -> [T; TRANSFORM_ENTRIES] {
        let followed = [q[self.q] * ratio + offset];
        self.joint.compose(&self.placement, &followed).to_entries()
    }

    /// The point c of the body that an Euler step moves, in the body frame, m: the centre of mass for joints with a linear velocity in body axes, if
    /// there is mass; otherwise zero.
    #[inline]
    pub(crate) fn center<T: Over<P>>(&self) -> Vector3<T> {
        if !self.joint.turns_with_body() {
            return Vector3::zeros();
        }
        let per_mass = self.per_mass();
        lift_vector(&self.inertia.first_moment.map(|h| h * per_mass))
    }

    /// 1 / m, by which the first moment is the centre of mass, 1/kg; zero without mass.
    pub(crate) fn per_mass(&self) -> P {
        let (mass, one) = (self.inertia.mass, P::one());
        let least = P::constant(f64::MIN_POSITIVE);
        let per_mass = one / mass.select_lt(least, one, mass);
        mass.select_lt(least, P::zero(), per_mass)
    }

    /// [`JointKind::turning`] about the centre of mass at the velocity `v` of the robot: passes each coordinate with its value to `each`.
    #[inline(always)]
    pub(crate) fn turning<T: Over<P>>(&self, v: &[T], mut each: impl FnMut(usize, T)) {
        let own = &v[v_range(self)];
        (self.joint).turning(&self.center(), own, |k, x| each(self.v + k, x));
    }

    /// The velocity after an Euler step with the acceleration `a`, along the axes of before it; all of the robot's coordinates.
    #[inline(always)]
    pub(crate) fn step_velocity<T: Over<P>>(&self, v: &[T], a: &[T], dt: P, next_v: &mut [T]) {
        let own = v_range(self);
        let (v, a, next_v) = (&v[own.clone()], &a[own.clone()], &mut next_v[own]);
        (self.joint).step_velocity(&self.center(), v, a, dt, next_v);
    }

    /// Passes each pair of a linear and an angular coordinate, with their ratio x, to `each`: while the body turns about its centre of mass and that
    /// rests in the joint frame, the rate of the former is the sum of all x times the latter. None of kinds whose linear velocity does not turn with
    /// the body.
    pub(crate) fn each_spin<T: Over<P>>(&self, mut each: impl FnMut(usize, usize, T)) {
        if !self.joint.turns_with_body() {
            return;
        }
        let c = self.center::<T>();
        // v = −ω × c = c × ω, coordinate by coordinate:  (c × ê_j)_i = ± c_k
        for (l, along) in self.axes().filter(|(_, axis)| !axis.is_angular()) {
            for (k, about) in self.axes().filter(|(_, axis)| axis.is_angular()) {
                let (i, j) = (along.coordinate(), about.coordinate() - 3);
                if i == (j + 1) % 3 {
                    each(l, k, c[3 - i - j]);
                } else if i != j {
                    each(l, k, -c[3 - i - j]);
                }
            }
        }
    }

    /// V += S v with the robot's velocity (or acceleration) `v`, in the body frame.
    #[inline(always)]
    pub(crate) fn add_motion<T: Over<P>>(&self, v: &[T], V: &mut Motion<T>) {
        self.add_motion_over::<P, T>(v, V);
    }

    /// [`add_motion`](Self::add_motion) over a scalar over one over the data, as dual numbers of dual numbers are.
    #[inline(always)]
    pub(crate) fn add_motion_over<R: Over<P>, T: Over<R>>(&self, v: &[T], V: &mut Motion<T>) {
        match self.coupling {
            None => self.joint.add_motion(&v[v_range(self)], V),
            Some(coupling) => {
                let followed = v[self.v] * <R as From<P>>::from(coupling.ratio);
                self.joint.add_motion(&[followed], V);
            }
        }
    }

    /// S v: the velocity of the body with respect to its parent, in the body frame.
    #[inline]
    pub(crate) fn motion<T: Over<P>>(&self, v: &[T]) -> Motion<T> {
        let mut out = Motion::zero();
        self.add_motion(v, &mut out);
        out
    }

    /// V × S v: the velocity-product acceleration of the body moving with V.
    #[inline(always)]
    pub(crate) fn velocity_product<T: Over<P>>(&self, V: &Motion<T>, v: &[T]) -> Motion<T> {
        self.velocity_product_over::<P, T>(V, v)
    }

    /// [`velocity_product`](Self::velocity_product) over a scalar over one over the data.
    #[inline(always)]
    pub(crate) fn velocity_product_over<R: Over<P>, T: Over<R>>(
        &self,
        V: &Motion<T>,
        v: &[T],
    ) -> Motion<T> {
        match self.coupling {
            None => self.joint.velocity_product(V, &v[v_range(self)]),
            Some(coupling) => {
                let followed = v[self.v] * <R as From<P>>::from(coupling.ratio);
                self.joint.velocity_product(V, &[followed])
            }
        }
    }

    /// Projects a spatial force, Sᵀ F: passes the component of a spatial force on the body, in the body frame, along each of the robot's coordinates to
    /// `each(coordinate, force)`.
    #[inline(always)]
    pub(crate) fn project<T: Over<P>>(&self, F: &Force<T>, mut each: impl FnMut(usize, T)) {
        self.joint.project(
            F,
            #[inline(always)]
            |k, x| each(self.v + k, self.scaled(x)),
        );
    }

    /// Adds Sᵀ F to the joint forces: τ += Sᵀ F.
    #[inline(always)]
    pub(crate) fn add_projection<T: Over<P>>(&self, F: &Force<T>, tau: &mut [T]) {
        self.project(F, |k, x| tau[k] += x);
    }

    /// The columns of S with the velocity coordinates that they belong to.
    #[inline]
    pub(crate) fn columns<T: Over<P>>(&self) -> impl Iterator<Item = (usize, Motion<T>)> {
        let scale = |S: Motion<T>| {
            self.coupling
                .map_or(S, |coupling| S * T::from(coupling.ratio))
        };
        let axes = self.axes();
        axes.map(move |(k, axis)| (k, scale(axis.motion())))
    }

    /// The velocity coordinates with the axis in the body that each moves along, or in proportion.
    #[inline]
    pub(crate) fn axes(&self) -> impl Iterator<Item = (usize, Axis)> {
        let axes = self.joint.axes().enumerate();
        axes.map(
            #[inline(always)]
            |(k, axis)| (self.v + k, axis),
        )
    }

    /// The force per unit rate of the coordinate that the joint has or follows, from that per unit rate of the joint.
    #[inline(always)]
    pub(crate) fn scaled_force<T: Over<P>>(&self, F: Force<T>) -> Force<T> {
        match self.coupling {
            None => F,
            Some(Coupling { ratio, .. }) => F.scaled(T::from(ratio)),
        }
    }

    /// A force or a Jacobian entry of the joint itself, along the coordinate that it has or follows.
    #[inline(always)]
    pub(crate) fn scaled<T: Over<P>>(&self, x: T) -> T {
        match self.coupling {
            None => x,
            Some(Coupling { ratio, .. }) => x * ratio,
        }
    }
}
