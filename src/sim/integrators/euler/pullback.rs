//! Gradient of an Euler step: the step of each joint backwards, then its acceleration.

use nalgebra::Vector3;

use super::{advance, impact};
use crate::dynamics::{Calls, ParameterSlots};
use crate::joint::MAX_NV;
use crate::linalg::product::add_scaled;
use crate::model::manifold::v_range;
use crate::model::{Body, BodyId};
use crate::scalar::Scalar;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::acceleration::{
    AccelerationAdjoint, AccelerationScratch, AccelerationWeights,
};
use crate::sim::integrators::joint_tangents::{
    OfNumbers, joint_step, joint_step_in_numbers, stepped_velocity,
};
use crate::sim::integrators::method::{Pullback, StepPoint};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::StepGradientSum;

/// Working memory: the step, and its gradient.
#[derive(Clone, Debug)]
pub(crate) struct Adjoint<T: Scalar> {
    found: AccelerationScratch<T>,
    next: State<T>,
    evaluation: EvaluationAdjoint<T>,
    /// Workspace of impacts at their time, if there can be any.
    impact: Option<Box<impact::Adjoint<T>>>,
    /// Whether there is one in the step that has been found.
    has_impact: bool,
}

/// Gradient of one evaluation and of its results.
#[derive(Clone, Debug)]
pub(in crate::sim::integrators) struct EvaluationAdjoint<T: Scalar> {
    /// Of the acceleration.
    weights: Vec<T>,
    pub(in crate::sim::integrators) acceleration: AccelerationAdjoint<T>,
}

impl<T: Scalar> Pullback<T> for Adjoint<T> {
    fn new(simulator: &Simulator, calls: Calls) -> Self {
        Self {
            found: AccelerationScratch::new(simulator, calls),
            next: simulator.neutral_state(),
            evaluation: EvaluationAdjoint {
                weights: vec![T::zero(); simulator.model().nv()],
                acceleration: AccelerationAdjoint::new(simulator, calls),
            },
            impact: simulator
                .may_bounce()
                .then(|| Box::new(impact::Adjoint::new(simulator))),
            has_impact: false,
        }
    }

    fn add_gradient(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        adjoint: &[T],
        out: &mut StepGradientSum<'_, T>,
    ) {
        let point = EvaluationPoint::of_step(simulator, at.state, at.u);
        self.find(&point, at.acceleration);
        self.add(&point, adjoint, out);
    }
}

impl<T: Scalar> Adjoint<T> {
    /// Takes the step; whether there is an impact at its time in it.
    ///
    /// * `acceleration` – where it is known
    pub(super) fn find(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        acceleration: Option<&[T]>,
    ) -> bool {
        let (found, next) = (&mut self.found, &mut self.next);
        match acceleration {
            None => at.simulator.accelerate(at, found),
            Some(a) => at.simulator.accelerate_again(at, a, found),
        }
        self.has_impact = impact::lone(at, found).is_some_and(|lone| {
            let new = || Box::new(impact::Adjoint::new(at.simulator));
            let impact = self.impact.get_or_insert_with(new);
            impact.find(at, lone, found, next, &mut self.evaluation)
        });
        if !self.has_impact {
            advance(at, found, next);
        }
        self.has_impact
    }

    /// Adds the gradient of the step that has been found.
    pub(super) fn add(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        adjoint: &[T],
        out: &mut StepGradientSum<'_, T>,
    ) {
        let (found, next, own) = (&mut self.found, &self.next, &mut self.evaluation);
        match self.impact.as_mut().filter(|_| self.has_impact) {
            None => own.add(at, found, next, adjoint, out),
            Some(impact) => impact.add(at, found, next, adjoint, own, out),
        }
    }
}

impl<T: Scalar> EvaluationAdjoint<T> {
    /// Adds the gradient of λᵀ x⁺.
    ///
    /// * `found`, `next` – the evaluation, and x⁺
    /// * `adjoint` – λ
    pub(in crate::sim::integrators) fn add(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &mut AccelerationScratch<T>,
        next: &State<T>,
        adjoint: &[T],
        out: &mut StepGradientSum<'_, T>,
    ) {
        let by_contact = &adjoint[2 * at.model().nv()..];
        self.add_joint_steps(at, &found.a, next, adjoint, out);
        // m⁺ = m + (m⁺ − m)
        add_scaled(out.contact, by_contact, T::one());
        let of_acceleration = AccelerationWeights {
            a: &self.weights,
            contact: by_contact,
            has_friction: out.has_parts,
        };
        (self.acceleration).add(at, found, &of_acceleration, out);
    }

    /// Adds the gradient through the step of each joint; its acceleration gets weights.
    fn add_joint_steps(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        a: &[T],
        next: &State<T>,
        adjoint: &[T],
        out: &mut StepGradientSum<'_, T>,
    ) {
        let (by_q, by_v) = adjoint.split_at(at.model().nv());
        let (weights, dt) = (&mut self.weights, at.dt());
        for (id, body) in at.model().independent_with_ids() {
            if body.joint.nv() == 1 {
                // q⁺ = q + Δt v⁺,  v⁺ = v + Δt a
                let k = body.v;
                let by_next_v = by_v[k] + by_q[k] * dt;
                out.q[k] += by_q[k];
                out.v[k] += by_next_v;
                weights[k] = by_next_v * dt;
                out.add_time_step(by_next_v * a[k] + by_q[k] * next.v[k]);
            } else {
                let curved = Curved {
                    at,
                    a,
                    next,
                    by_q,
                    by_v,
                };
                curved.add(body, weights, out);
                if !out.parameters.is_empty() {
                    let slots = self.acceleration.slots();
                    curved.add_numbers(id, body, slots, out);
                }
            }
        }
    }
}

/// A step of joints whose configuration is not a vector:  (δq⁺, δv⁺) = D (δq, δw) with w the velocity after it along the axes of before it.
struct Curved<'a, T: Scalar> {
    at: &'a EvaluationPoint<'a, f64, T>,
    a: &'a [T],
    next: &'a State<T>,
    /// Weights of q⁺ and v⁺.
    by_q: &'a [T],
    by_v: &'a [T],
}

impl<T: Scalar> Curved<'_, T> {
    fn add(&self, body: &Body<f64>, weights: &mut [T], out: &mut StepGradientSum<'_, T>) {
        let (state, dt, nv) = (self.at.state, self.at.dt(), body.joint.nv());
        let w = stepped_velocity(body, state, self.a, T::constant(dt));
        let (dq, dv) = joint_step(body, state, &w, self.next, T::constant(dt));
        let mut by_w = [T::zero(); MAX_NV];
        for k in 0..nv {
            let (x, y) = (self.by_q[body.v + k], self.by_v[body.v + k]);
            for l in 0..nv {
                out.q[body.v + l] += x * dq[k].eps[l] + y * dv[k].eps[l];
                by_w[l] += x * dq[k].eps[MAX_NV + l] + y * dv[k].eps[MAX_NV + l];
            }
        }
        for l in 0..nv {
            for (&x, w) in by_w.iter().zip(&w).take(nv) {
                out.v[body.v + l] += x * w.eps[l];
            }
            weights[body.v + l] = by_w[l] * dt;
        }
    }

    /// Adds the derivatives in the time step and in the centre of mass by which the body is moved.
    fn add_numbers(
        &self,
        id: BodyId,
        body: &Body<f64>,
        slots: &ParameterSlots,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let dt = OfNumbers::variable(T::constant(self.at.dt()), 0);
        let steps = joint_step_in_numbers(body, self.at.state, self.a, self.next, dt, dt);
        let mut sum = OfNumbers::from(0.0);
        for (step, weights) in steps.iter().zip([self.by_q, self.by_v]) {
            let own = step.iter().zip(&weights[v_range(body)]);
            own.for_each(|(x, &weight)| sum += x.each(|x| x * weight));
        }
        let [by_dt, _, x, y, z] = sum.eps;
        out.add_time_step(by_dt);
        slots.add_center(id, body, &Vector3::new(x, y, z), out.parameters);
    }
}
