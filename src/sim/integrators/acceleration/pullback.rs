//! Gradient of the acceleration at which all terms balance, by the implicit function theorem.
//!
//! The acceleration solves  r(a, x) = ID(q, v, a) − τ − Σ Jᵀ F = 0  with ∂r/∂a = M + R, symmetric. So the gradient of λᵀ a is that of μᵀ r at fixed a
//! with μ = −(M + R)⁻¹ λ: one sweep. Forces of rows add to the weights, and rows of their own (`rows.rs`).

use super::AccelerationScratch;
use super::rows::{AccelerationWeights, RowAdjoint};
use crate::dynamics::{AbaScratch, Calls, ParameterSlots, resisted_forward_dynamics_into};
use crate::model::Model;
use crate::scalar::Scalar;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::balance::BalanceAdjoint;
use crate::sim::integrators::half_step;
use crate::sim::simulator::Simulator;
use crate::sim::terms::{Acting, DerivativePoint, StepGradientSum, TermWeights};

/// Working memory of [`add`](Self::add).
#[derive(Clone, Debug)]
pub(crate) struct AccelerationAdjoint<T: Scalar> {
    /// The robot where nothing has weight: at rest there, forward dynamics is M⁻¹.
    weightless: Model,
    aba: AbaScratch<T>,
    rest: Vec<T>,
    /// μ.
    mu: Vec<T>,
    rows: RowAdjoint<T>,
    balance: BalanceAdjoint<T>,
    /// With semi-implicit Euler allocated at the first step with fast rotation.
    half_step: Option<Box<half_step::Adjoint<T>>>,
}

impl<T: Scalar> AccelerationAdjoint<T> {
    pub(crate) fn new(simulator: &Simulator, calls: Calls) -> Self {
        let model = simulator.model();
        let weightless = model.clone().with_gravity(nalgebra::Vector3::zeros());
        let zeros = || vec![T::zero(); model.nv()];
        let at_middle = simulator.always_in_the_middle();
        Self {
            aba: AbaScratch::for_calls(&weightless, calls),
            weightless,
            rest: zeros(),
            mu: zeros(),
            rows: RowAdjoint::new(simulator),
            balance: BalanceAdjoint::new(simulator),
            half_step: at_middle.then(|| half_step::Adjoint::new(simulator)),
        }
    }

    /// Places of parameters of the model.
    pub(crate) fn slots(&self) -> &ParameterSlots {
        self.balance.slots()
    }

    /// Adds the gradient of λᵀ a, and of the weighted changes of the contact state, as they have been found at an instant.
    pub(crate) fn add(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &mut AccelerationScratch<T>,
        weights: &AccelerationWeights<'_, T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let has_rows = found.has_rows(at);
        if let Some(balance) = found.balance.as_deref_mut().filter(|_| has_rows) {
            balance.prepare_slopes(at);
        }
        let is_free = self.is_free(at, found);
        if !is_free {
            self.solve(at, found, weights, out);
            self.add_balance(at, found, weights, out);
        }
        let Some(own) = found.half_step(at) else {
            return;
        };
        let new = || half_step::Adjoint::new(at.simulator);
        let half_step = self.half_step.get_or_insert_with(new);
        let change = half_step::Change {
            half_step: own,
            terms: &found.terms,
            weights: match is_free {
                true => half_step::Weights::All(weights.a, weights.contact),
                false => half_step::Weights::Rest(&self.mu, &self.rows.by_y),
            },
        };
        half_step.add(at, &change, &mut self.balance, out);
    }

    /// Adds the gradient of the gap of a contact point, of which a row of the evaluation is the normal, times a weight.
    pub(in crate::sim::integrators) fn add_gap(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &AccelerationScratch<T>,
        row: usize,
        weight: T,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let Some(balance) = found.balance.as_deref() else {
            return;
        };
        self.mu.fill(T::zero());
        self.rows.weigh_one(row, balance.rows().count(), weight);
        let weights = TermWeights {
            mu: &self.mu,
            y: &self.rows.by_y,
            by_contact: &[],
            friction: &[],
        };
        let point = DerivativePoint {
            point: at,
            a: &found.a,
            acting: Acting::Gaps(balance),
        };
        let seen = Some(&self.rows.seen[..]);
        (self.balance).add(&point, &weights, seen, &found.terms, out);
    }

    /// Whether the acceleration is a₀ of a half step: without rows, joint limits that push, and bounded forces.
    fn is_free(&self, at: &EvaluationPoint<'_, f64, T>, found: &AccelerationScratch<T>) -> bool {
        let has_half_step = !found.has_rows(at) && found.half_step(at).is_some();
        let terms = &found.terms;
        has_half_step && !terms.stops.any_pushes() && terms.bounded_forces.is_empty()
    }

    /// Adds the gradient of the balance of all that acts.
    fn add_balance(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &AccelerationScratch<T>,
        weights: &AccelerationWeights<'_, T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let (rows, balance) = (&self.rows, found.balance.as_deref());
        let balance = balance.filter(|_| found.has_rows(at));
        let weights = TermWeights {
            mu: &self.mu,
            y: &rows.by_y,
            by_contact: weights.contact,
            friction: &rows.by_friction,
        };
        let (point, seen) = (
            DerivativePoint::of_all(at, &found.a, balance),
            balance.map(|_| &rows.seen[..]),
        );
        (self.balance).add(&point, &weights, seen, &found.terms, out);
    }

    /// Finds μ of the balance of all that acts.
    fn solve(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &mut AccelerationScratch<T>,
        weights: &AccelerationWeights<'_, T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        if found.has_rows(at) {
            self.rows.solve(at, found, weights, &mut self.mu);
            out.add_time_step(self.rows.by_time_step(at));
        } else {
            self.solve_without_rows(at, found, weights.a);
        }
    }

    /// μ = −(M + R)⁻¹ λ
    fn solve_without_rows(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &AccelerationScratch<T>,
        lambda: &[T],
    ) {
        resisted_forward_dynamics_into(
            &self.weightless,
            at.q(),
            &self.rest,
            lambda,
            found.resistance(at),
            &[],
            &mut self.aba,
            &mut self.mu,
        );
        self.mu.iter_mut().for_each(|mu| *mu = -*mu);
    }
}
