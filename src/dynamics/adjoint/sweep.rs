//! The gradient of μᵀ ID(q, v, a) by two passes along the tree.
//!
//! Inverse dynamics weighted with the joint rates μ is a sum over the bodies: with the motion W that these rates give to a body,
//!
//! > μᵀ ID = Σᵢ Wᵢ · (Iᵢ Aᵢ + Vᵢ ×* Iᵢ Vᵢ − Fᵢ) + Σₖ μₖ rₖ aₖ,   W = X⁻¹ `W_P` + S μ,
//!
//! with external forces F and armature r. Each body's own share is linear in its inertia, in A and in W, and quadratic in V, so its derivatives
//! are the maps that inverse dynamics has, each the other way:
//!
//! > ∂/∂A = I W,   ∂/∂V = I (W × V) − W ×* I V,   ∂/∂W = I A + V ×* I V − F.
//!
//! They are forces on the body, and are carried to the parent as forces are: V, A and W all go outward as X⁻¹ (…). Where a joint moves on by ξ, seen
//! from the parent, X⁻¹ M changes by X⁻¹ (M × ξ) for each of the three, which is the gradient in q and in the joint's placement.
//!
//! Further terms of a sum (forces that follow a body) add what they know of pose and velocity of a body between the passes.
//!
//! # References
//! [Griewank, Walther 2008, chapter 3]; [Featherstone 2008, section 5.3] for the passes that are reversed.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::slots::ParameterSlots;
use crate::dynamics::rnea::{Accelerated, joint_motion, world_acceleration};
use crate::dynamics::weightless::spared_part;
use crate::model::{Body, BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{cross, dot, rotate, scale};
use crate::spatial::{Force, INERTIAL_PARAMETERS, Inertia, Motion, Transform};

/// A motion, the external forces under it, and the weights of the joint forces that it needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weighted<'a, T> {
    pub(crate) q: &'a [T],
    pub(crate) v: &'a [T],
    pub(crate) a: &'a [T],
    /// μ.
    pub(crate) mu: &'a [T],
    /// On each body, in the body; empty for none.
    pub(crate) external: &'a [Force<T>],
}

/// A body in the passes. Derivatives are forces in the body, after the inward pass those of all that it carries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Swept<T> {
    pub(super) X_PB: Transform<T>,
    pub(crate) V: Motion<T>,
    /// Spatial acceleration, with that of the world against gravity.
    pub(crate) A: Motion<T>,
    /// The motion that the rates μ give it.
    pub(crate) W: Motion<T>,
    /// ∂/∂W, the force that inverse dynamics finds.
    pub(crate) F: Force<T>,
    pub(crate) by_A: Force<T>,
    pub(crate) by_V: Force<T>,
    /// Derivative in the pose, by a small motion of the body seen from the body, of what was added between the passes.
    pub(crate) by_pose: Force<T>,
}

/// Sums of a gradient.
#[derive(Debug)]
pub(crate) struct Gradients<'a, T> {
    /// In tangent directions of q.
    pub(crate) q: &'a mut [T],
    pub(crate) v: &'a mut [T],
    pub(crate) a: &'a mut [T],
    /// All parameters; empty if they are not wanted.
    pub(crate) parameters: &'a mut [T],
}

/// Working memory of the passes.
#[derive(Clone, Debug)]
pub(crate) struct Sweep<T> {
    sin_cos: Vec<(T, T)>,
    pub(crate) bodies: Vec<Swept<T>>,
    /// One more motion of each body, by rates that are given; empty where there is none.
    pub(crate) seen: Vec<Seen<T>>,
    /// The rates of that motion.
    seen_rates: Vec<T>,
    /// The derivative in them, after the pass inward.
    pub(crate) by_seen: Vec<T>,
    /// Derivative in the acceleration of the world against gravity of what was added between the passes.
    pub(crate) by_A_W: Force<T>,
    pub(crate) slots: ParameterSlots,
}

/// A motion of a body by rates along which others look, and the derivative in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen<T> {
    pub(crate) U: Motion<T>,
    pub(crate) by_U: Force<T>,
}

impl<T: Scalar> Sweep<T> {
    /// Makes memory for a model.
    pub(crate) fn new<P: Scalar>(model: &Model<P>) -> Self {
        let at_rest = Swept {
            X_PB: Transform::identity(),
            V: Motion::zero(),
            A: Motion::zero(),
            W: Motion::zero(),
            F: Force::zero(),
            by_A: Force::zero(),
            by_V: Force::zero(),
            by_pose: Force::zero(),
        };
        Self {
            sin_cos: vec![(T::zero(), T::one()); model.nq()],
            bodies: vec![at_rest; model.n_bodies()],
            seen: Vec::with_capacity(model.n_bodies()),
            seen_rates: Vec::with_capacity(model.nv()),
            by_seen: Vec::with_capacity(model.nv()),
            by_A_W: Force::zero(),
            slots: ParameterSlots::new(model),
        }
    }

    /// Adds the gradient of μᵀ ID to `out`.
    pub(crate) fn add<P: Scalar>(
        &mut self,
        model: &Model<P>,
        at: &Weighted<'_, T>,
        out: &mut Gradients<'_, T>,
    ) where
        T: Over<P>,
    {
        self.start(model, at);
        self.finish(model, at, out);
    }

    /// The pass outward; what further terms know of a body may then be added to its derivatives.
    pub(crate) fn start<P: Scalar>(&mut self, model: &Model<P>, at: &Weighted<'_, T>)
    where
        T: Over<P>,
    {
        T::vectorized(
            #[inline(always)]
            || self.outward(model, at),
        );
    }

    /// Starts one more motion of the bodies, by `rates`, after the pass outward: what depends on it is added to its derivatives until the pass
    /// inward, which ends it.
    pub(crate) fn look<P: Scalar>(&mut self, model: &Model<P>, rates: &[T])
    where
        T: Over<P>,
    {
        self.seen.clear();
        self.seen_rates.clear();
        self.seen_rates.extend_from_slice(rates);
        self.by_seen.clear();
        self.by_seen.resize(rates.len(), T::zero());
        for (own, body) in self.bodies.iter().zip(model.bodies()) {
            let parent = body.parent.map(|p| self.seen[p.0].U);
            let mut U = parent.map_or_else(Motion::zero, |U| own.X_PB.motion_inverse(&U));
            body.add_motion(rates, &mut U);
            let by_U = Force::zero();
            self.seen.push(Seen { U, by_U });
        }
    }

    /// Pose of a body in the world, after the pass outward.
    pub(crate) fn pose<P: Scalar>(&self, model: &Model<P>, body: BodyId) -> Transform<T> {
        let mut pose = self.bodies[body.0].X_PB;
        let mut next = model.body(body).parent;
        while let Some(parent) = next {
            pose = self.bodies[parent.0].X_PB * pose;
            next = model.body(parent).parent;
        }
        pose
    }

    /// Takes the derivatives in that motion of a body to its joint and its parent. Returns the derivative in a small motion of the joint, seen from there.
    #[inline(never)]
    fn hand_seen_on<P: Scalar>(&mut self, i: usize, body: &Body<P>) -> Force<T>
    where
        T: Over<P>,
    {
        body.add_projection(&self.seen[i].by_U, &mut self.by_seen);
        let by_U = self.bodies[i].X_PB.force(&self.seen[i].by_U);
        body.parent.map(|p| p.0).map_or_else(Force::zero, |p| {
            let parent = &mut self.seen[p];
            parent.by_U += by_U;
            -parent.U.cross_force(&by_U)
        })
    }

    /// The pass inward, which adds the gradient to `out`.
    pub(crate) fn finish<P: Scalar>(
        &mut self,
        model: &Model<P>,
        at: &Weighted<'_, T>,
        out: &mut Gradients<'_, T>,
    ) where
        T: Over<P>,
    {
        T::vectorized(
            #[inline(always)]
            || self.inward(model, at, out),
        );
    }

    /// From the world to the tips: motions, and the derivatives of each body's own share.
    #[inline(always)]
    fn outward<P: Scalar>(&mut self, model: &Model<P>, at: &Weighted<'_, T>)
    where
        T: Over<P>,
    {
        let A_W = world_acceleration(model);
        self.by_A_W = Force::zero();
        T::sin_cos_each(at.q, &mut self.sin_cos);
        for (i, body) in model.bodies().iter().enumerate() {
            let X = body.place_turned(at.q, &self.sin_cos);
            let (before, own) = self.bodies.split_at_mut(i);
            let (V, A, mut W) = match body.parent.map(|p| &before[p.0]) {
                Some(parent) => (
                    X.motion_inverse(&parent.V),
                    X.motion_inverse(&parent.A),
                    X.motion_inverse(&parent.W),
                ),
                None => (Motion::zero(), X.motion_inverse(&A_W), Motion::zero()),
            };
            let carried = Accelerated { V, A };
            let Accelerated { V, A } = joint_motion(body, Some(at.v), Some(at.a), carried);
            body.add_motion(at.mu, &mut W);
            let I = &body.inertia;
            // Field by field: a whole struct would be put together in memory and read again.
            let own = &mut own[0];
            own.by_A = I.times(&W);
            own.by_V = I.times(&W.cross(&V)) - W.cross_force(&I.times(&V));
            own.F = I.force(&V, &A);
            if let Some(&F_ext) = at.external.get(i) {
                own.F = own.F - F_ext;
            }
            own.by_pose = Force::zero();
            (own.X_PB, own.V, own.A, own.W) = (X, V, A, W);
        }
        if !model.weightless().is_empty() {
            self.spare(model);
        }
    }

    /// Takes the weight W · F₀ = g · L of what gravity does not act on from the sum: F₀, and derivatives in the pose and in gravity.
    #[inline(never)]
    fn spare<P: Scalar>(&mut self, model: &Model<P>)
    where
        T: Over<P>,
    {
        for k in 0..model.weightless().len() {
            let (spared, F) = spared_part(model, k, |i| self.bodies[i].X_PB);
            let own = &mut self.bodies[spared.body.0];
            let L = spared.momentum(&own.W);
            own.F += F;
            own.by_pose.angular += cross(&L, &spared.gravity);
            self.by_A_W.linear -= rotate(&spared.X_WB.rotation, &L);
        }
    }

    /// The derivative of that weight in masses and first moments.
    #[inline(never)]
    fn spare_inertias<P: Scalar>(&self, model: &Model<P>, out: &mut [T])
    where
        T: Over<P>,
    {
        for (k, own) in model.weightless().iter().enumerate() {
            let (spared, _) = spared_part(model, k, |i| self.bodies[i].X_PB);
            let W = &self.bodies[own.body.0].W;
            let first = self.slots.inertia[own.body.0];
            for (k, out) in out[first..].iter_mut().take(4).enumerate() {
                let unit = Inertia::<T>::unit(k);
                let (mass, moment) = own.of(unit.mass, &unit.first_moment);
                let L = scale(&W.linear, mass) + cross(&W.angular, &moment);
                *out += dot(&spared.gravity, &L);
            }
        }
    }

    /// From the tips to the world: the gradient at each joint and body, then the parent takes over.
    #[inline(always)]
    fn inward<P: Scalar>(
        &mut self,
        model: &Model<P>,
        at: &Weighted<'_, T>,
        out: &mut Gradients<'_, T>,
    ) where
        T: Over<P>,
    {
        let A_W = world_acceleration(model);
        let mut by_A_W = self.by_A_W;
        for (i, body) in model.bodies().iter().enumerate().rev() {
            let seen = match self.seen.is_empty() {
                true => None,
                false => Some(self.hand_seen_on(i, body)),
            };
            let (before, own) = self.bodies.split_at_mut(i);
            let own = &mut own[0];
            add_joint_rates(body, at.v, own, out);
            let felt = own.felt();
            let mut turned = match body.parent {
                Some(p) => felt.hand_on(&mut before[p.0]),
                None => {
                    by_A_W += felt.by_A;
                    felt.by_pose - A_W.cross_force(&felt.by_A)
                }
            };
            if let Some(seen) = seen {
                turned += seen;
            }
            let by_q = own.X_PB.force_inverse(&turned);
            body.add_projection(&by_q, out.q);
            if !out.parameters.is_empty() {
                self.slots.add_inertia(i, own, out.parameters);
                self.slots.add_placement(i, body, &turned, out.parameters);
                self.add_coupling(i, body, at, &by_q, out.parameters);
            }
        }
        self.seen.clear();
        if !model.weightless().is_empty() && !out.parameters.is_empty() {
            self.spare_inertias(model, out.parameters);
        }
        self.add_armature(model, at, out);
        if let Some(gravity) = self.slots.gravity.filter(|_| !out.parameters.is_empty()) {
            // A_W = −g
            for k in 0..3 {
                out.parameters[gravity + k] -= by_A_W.linear[k];
            }
        }
    }

    /// The position of a mimic joint is r q + o, and each of its rates r times that of its leader.
    #[inline(never)]
    fn add_coupling<P: Scalar>(
        &self,
        i: usize,
        body: &Body<P>,
        at: &Weighted<'_, T>,
        by_q: &Force<T>,
        out: &mut [T],
    ) where
        T: Over<P>,
    {
        let Some(ratio) = self.slots.coupling[i] else {
            return;
        };
        let along = |F: &Force<T>| along_joint(body, F);
        let (own, k, by_q) = (&self.bodies[i], body.v, along(by_q));
        let by_v = along(&(own.by_V - own.V.cross_force(&own.by_A)));
        let (by_a, by_mu) = (along(&own.by_A), along(&own.F));
        out[ratio] += by_q * at.q[body.q] + by_v * at.v[k] + by_a * at.a[k] + by_mu * at.mu[k];
        if let Some(seen) = self.seen.get(i) {
            out[ratio] += along(&seen.by_U) * self.seen_rates[k];
        }
        out[ratio + 1] += by_q;
    }

    /// Σₖ μₖ rₖ aₖ
    #[inline(always)]
    fn add_armature<P: Scalar>(
        &self,
        model: &Model<P>,
        at: &Weighted<'_, T>,
        out: &mut Gradients<'_, T>,
    ) where
        T: Over<P>,
    {
        for (k, &armature) in model.armature().iter().enumerate() {
            out.a[k] += at.mu[k] * armature;
        }
        if !out.parameters.is_empty() {
            let own = out.parameters[self.slots.armature..].iter_mut();
            let products = at.mu.iter().zip(at.a);
            own.zip(products)
                .for_each(|(own, (&mu, &a))| *own += mu * a);
        }
    }
}

/// A force along the one axis of a joint itself, also of one that follows another.
pub(super) fn along_joint<P: Scalar, T: Over<P>>(body: &Body<P>, F: &Force<T>) -> T {
    let mut sum = T::zero();
    body.joint.project(F, |_, x| sum += x);
    sum
}

/// V = … + S v,  A = … + S a + V × S v
#[inline(always)]
fn add_joint_rates<P: Scalar, T: Over<P>>(
    body: &Body<P>,
    v: &[T],
    own: &mut Swept<T>,
    out: &mut Gradients<'_, T>,
) {
    let mut joint = Motion::zero();
    body.add_motion(v, &mut joint);
    own.by_V += joint.cross_force(&own.by_A);
    body.add_projection(&own.by_A, out.a);
    body.add_projection(&(own.by_V - own.V.cross_force(&own.by_A)), out.v);
}

/// Derivatives of a body, seen from its parent.
struct Felt<T> {
    F: Force<T>,
    by_A: Force<T>,
    by_V: Force<T>,
    by_pose: Force<T>,
}

impl<T: Scalar> Swept<T> {
    #[inline(always)]
    fn felt(&self) -> Felt<T> {
        let X = &self.X_PB;
        Felt {
            F: X.force(&self.F),
            by_A: X.force(&self.by_A),
            by_V: X.force(&self.by_V),
            by_pose: X.force(&self.by_pose),
        }
    }
}

impl<T: Scalar> Felt<T> {
    /// Adds to the derivatives of the parent. Returns the derivative in a small motion of the joint, seen from the parent:  −Σ M ×* ∂/∂M.
    #[inline(always)]
    fn hand_on(&self, parent: &mut Swept<T>) -> Force<T> {
        parent.F += self.F;
        parent.by_A += self.by_A;
        parent.by_V += self.by_V;
        parent.by_pose += self.by_pose;
        let turned = parent.V.cross_force(&self.by_V) + parent.A.cross_force(&self.by_A);
        self.by_pose - (turned + parent.W.cross_force(&self.F))
    }
}

impl ParameterSlots {
    /// W · (I A) + (W × V) · (I V)
    #[inline(always)]
    fn add_inertia<T: Scalar>(&self, i: usize, own: &Swept<T>, out: &mut [T]) {
        let own_range = self.inertia[i]..self.inertia[i] + INERTIAL_PARAMETERS;
        let slopes = Inertia::power_slopes(&own.W, &own.A);
        let of_velocity = Inertia::power_slopes(&own.W.cross(&own.V), &own.V);
        for (k, out) in out[own_range].iter_mut().enumerate() {
            *out += slopes[k] + of_velocity[k];
        }
    }

    /// The increment of a placement moves the joint, along the axes of the joint frame.
    #[inline(always)]
    pub(super) fn add_placement<P: Scalar, T: Over<P>>(
        &self,
        i: usize,
        body: &Body<P>,
        turned: &Force<T>,
        out: &mut [T],
    ) {
        let Some(first) = self.placement[i] else {
            return;
        };
        let slopes = body.placement.lift::<T>().force_inverse(turned).to_array();
        for (out, slope) in out[first..].iter_mut().zip(slopes) {
            *out += slope;
        }
    }
}
