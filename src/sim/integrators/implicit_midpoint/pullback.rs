//! Gradient of the step by the implicit function theorem, backwards, from its last part to its first.
//!
//! With the weights λ of q⁺ and of v⁺, and y = M⁻¹ λ of the latter, momentum and position of the end have weights; those of ξ that follow give
//! w = −(∂r/∂ξ)⁻ᵀ (…), the weights of the residual. Then momentum and force of the middle have the weights α and β, and the momentum of the start has π.
//! The gradient in parameters of the robot is that of their sum at fixed states (`numbers.rs`).

use std::borrow::Cow;

use super::numbers::NumberDerivatives;
use super::pushforward::TakenStep;
use super::weights::Weights;
use crate::dynamics::Calls;
use crate::scalar::Differentiable;
use crate::sim::integrators::method::{Pullback, StepPoint};
use crate::sim::simulator::Simulator;
use crate::sim::terms::StepGradientSum;

/// Working memory: the step with its derivatives, and weights.
#[derive(Clone, Debug)]
pub(crate) struct Adjoint<T: Differentiable> {
    taken: TakenStep<T>,
    weights: Weights<T>,
    numbers: NumberDerivatives<T>,
}

impl<T: Differentiable> Pullback<T> for Adjoint<T> {
    fn new(simulator: &Simulator, _: Calls) -> Self {
        Self {
            taken: TakenStep::new(simulator),
            weights: Weights::new(simulator),
            numbers: NumberDerivatives::new(simulator),
        }
    }

    fn add_gradient(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        adjoint: &[T],
        out: &mut StepGradientSum<'_, T>,
    ) {
        let parts = self.taken.take(simulator, at);
        let mut weights = Cow::Borrowed(adjoint);
        for k in (1..parts).rev() {
            let mut before = vec![T::zero(); adjoint.len()];
            let (q, v) = before.split_at_mut(adjoint.len() / 2);
            let own = &mut StepGradientSum {
                q,
                v,
                contact: &mut *out.contact,
                activation: &mut [],
                u: &mut *out.u,
                parameters: &mut *out.parameters,
                has_parts: out.has_parts,
            };
            self.add_part(simulator, at.u, k, &weights, own);
            weights = Cow::Owned(before);
        }
        self.add_part(simulator, at.u, 0, &weights, out);
    }
}

impl<T: Differentiable> Adjoint<T> {
    /// Adds the gradient through one part of the step.
    fn add_part(
        &mut self,
        simulator: &Simulator,
        u: &[T],
        k: usize,
        adjoint: &[T],
        out: &mut StepGradientSum<'_, T>,
    ) {
        self.taken.find(simulator, u, k);
        let dt = self.taken.duration(simulator);
        self.weights.start(&self.taken, adjoint, dt);
        self.weights.find(&self.taken, dt);
        self.weights.add_state(&self.taken, out);
        if !out.parameters.is_empty() {
            let (taken, weights) = (&self.taken, &self.weights);
            out.add_time_step(weights.by_time_step(taken, simulator.time_step()));
            let at = &taken.start_of(u, k);
            self.numbers.add(simulator, at, taken, weights, out);
        }
    }
}
