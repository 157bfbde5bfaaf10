//! Motion of all joints: velocities change by an acceleration over one time, a kick, and positions move on at them for another one, a drift. An Euler step has the same time
//! for both.

use nalgebra::Vector3;

use super::joint_tangents::{OfNumbers, joint_step, joint_step_in_numbers, stepped_velocity};
use crate::dynamics::ParameterSlots;
use crate::joint::MAX_NV;
use crate::linalg::product::add_scaled;
use crate::model::manifold::{q_range, v_range};
use crate::model::{Body, BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::sim::state::State;

/// Times of a motion, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Times<T> {
    pub(super) kick: T,
    pub(super) drift: T,
}

impl<T: Scalar> Times<T> {
    /// Moves from a state with an acceleration.
    pub(super) fn advance<P: Scalar>(
        self,
        model: &Model<P>,
        from: &State<T>,
        a: &[T],
        to: &mut State<T>,
    ) where
        T: Over<P>,
    {
        for body in model.independent() {
            let (own_q, own_v) = (q_range(body), v_range(body));
            let (q, v) = (
                &from.q.as_slice()[own_q.clone()],
                &from.v.as_slice()[own_v.clone()],
            );
            let next_q = &mut to.q.as_mut_slice()[own_q];
            let next_v = &mut to.v.as_mut_slice()[own_v.clone()];
            let (joint, center) = (body.joint, body.center());
            joint.step_velocity::<T, T>(&center, v, &a[own_v], self.kick, next_v);
            joint.move_on::<T, T>(&center, q, self.drift, next_q, next_v);
        }
    }
}

/// A motion that has been found: from a state to another one.
#[derive(Clone, Copy, Debug)]
pub(super) struct KickDrift<'a, T: Scalar> {
    pub(super) model: &'a Model,
    pub(super) from: &'a State<T>,
    pub(super) a: &'a [T],
    pub(super) to: &'a State<T>,
    /// With their derivatives in two numbers.
    pub(super) times: Times<OfNumbers<T>>,
}

/// Sums of the gradient of motions.
pub(super) struct MotionGradientSum<'a, T> {
    /// In the acceleration.
    pub(super) a: &'a mut [T],
    /// In parameters of the model, with their places; empty where they are not wanted.
    pub(super) parameters: &'a mut [T],
    pub(super) slots: &'a ParameterSlots,
    /// In the numbers on which the times depend.
    pub(super) numbers: [T; 2],
}

impl<T: Scalar> KickDrift<'_, T> {
    /// Turns the weights λ of the end, in tangent directions of q and then of v, into those of the start, and adds the gradient in all else.
    pub(super) fn pull(&self, lambda: &mut [T], out: &mut MotionGradientSum<'_, T>) {
        let (by_q, rest) = lambda.split_at_mut(self.model.nv());
        let by_v = &mut rest[..by_q.len()];
        for (id, body) in self.model.independent_with_ids() {
            let own = v_range(body);
            let (by_q, by_v) = (&mut by_q[own.clone()], &mut by_v[own]);
            match body.joint.nv() {
                1 => self.pull_straight(body, by_q[0], &mut by_v[0], out),
                _ => self.pull_curved(id, body, by_q, by_v, out),
            }
        }
    }

    /// w = v + κ a,  q⁺ = q + t w
    fn pull_straight(
        &self,
        body: &Body<f64>,
        by_q: T,
        by_v: &mut T,
        out: &mut MotionGradientSum<'_, T>,
    ) {
        let (k, Times { kick, drift }) = (body.v, self.times);
        *by_v += by_q * drift.re;
        out.a[k] += *by_v * kick.re;
        for (direction, slope) in out.numbers.iter_mut().enumerate() {
            let (kick, drift) = (kick.eps[direction], drift.eps[direction]);
            *slope += *by_v * self.a[k] * kick + by_q * self.to.v[k] * drift;
        }
    }

    /// Joints whose configuration is not a vector.
    fn pull_curved(
        &self,
        id: BodyId,
        body: &Body<f64>,
        by_q: &mut [T],
        by_v: &mut [T],
        out: &mut MotionGradientSum<'_, T>,
    ) {
        let Self {
            from, a, to, times, ..
        } = *self;
        let (own, nv) = (v_range(body), body.joint.nv());
        let mut sum = OfNumbers::from(0.0);
        let in_numbers = joint_step_in_numbers(body, from, a, to, times.kick, times.drift);
        for (tangent, by) in in_numbers.iter().zip([&*by_q, &*by_v]) {
            let weighted = tangent.iter().zip(by);
            weighted.for_each(|(x, &weight)| sum += x.each(|x| x * weight));
        }
        let [first, second, x, y, z] = sum.eps;
        out.numbers[0] += first;
        out.numbers[1] += second;
        let center = Vector3::new(x, y, z);
        out.slots.add_center(id, body, &center, out.parameters);
        let w = stepped_velocity(body, from, a, times.kick.re);
        let (dq, dv) = joint_step(body, from, &w, to, times.drift.re);
        let (mut q, mut by_w) = ([T::zero(); MAX_NV], [T::zero(); MAX_NV]);
        for (tangent, by) in [dq, dv].iter().zip([&*by_q, &*by_v]) {
            for (x, &weight) in tangent.iter().zip(by) {
                add_scaled(&mut q[..nv], &x.eps[..nv], weight);
                add_scaled(&mut by_w[..nv], &x.eps[MAX_NV..MAX_NV + nv], weight);
            }
        }
        by_q.copy_from_slice(&q[..nv]);
        add_scaled(&mut out.a[own], &by_w[..nv], times.kick.re);
        by_v.fill(T::zero());
        for (&x, w) in by_w.iter().zip(&w).take(nv) {
            add_scaled(by_v, &w.eps[..nv], x);
        }
    }
}
