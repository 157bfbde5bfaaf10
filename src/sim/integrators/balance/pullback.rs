//! Gradient of the weighted balance of forces at a fixed acceleration: one sweep along the tree, with the part of each term.

use crate::dynamics::{Gradients, ParameterSlots, Sweep, Weighted};
use crate::scalar::Scalar;
use crate::sim::simulator::Simulator;
use crate::sim::terms::{
    Acting, AdjointMemory, AdjointSink, AllDerivatives, DerivativePoint, Numbers, StepGradientSum,
    TermDerivatives, TermWeights, Terms, add_weighted_turning,
};

/// Working memory of [`add`](Self::add).
#[derive(Clone, Debug)]
pub(crate) struct BalanceAdjoint<T: Scalar> {
    terms: AllDerivatives<T>,
    memory: AdjointMemory<T>,
    sweep: Sweep<T>,
    /// M μ, which is not needed.
    by_a: Vec<T>,
}

impl<T: Scalar> BalanceAdjoint<T> {
    pub(crate) fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        let mut terms = AllDerivatives::new(simulator);
        terms.reserve_numbers(simulator);
        Self {
            terms,
            memory: AdjointMemory::new(simulator),
            sweep: Sweep::new(model),
            by_a: vec![T::zero(); model.nv()],
        }
    }

    /// Places of parameters of the model.
    pub(crate) fn slots(&self) -> &ParameterSlots {
        &self.sweep.slots
    }

    /// Adds the gradient of  μᵀ (ID − τ − Jᵀ f) + λᵀ y  and of the weighted changes of the contact state.
    ///
    /// * `seen` – ã; `None` where there are no rows
    /// * `found` – the terms as they have been evaluated
    pub(crate) fn add(
        &mut self,
        at: &DerivativePoint<'_, T>,
        weights: &TermWeights<'_, T>,
        seen: Option<&[T]>,
        found: &Terms<T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let (point, model, sweep) = (at.point, at.point.model(), &mut self.sweep);
        let weighted = Weighted {
            q: point.q(),
            v: point.v(),
            a: at.a,
            mu: weights.mu,
            external: &[],
        };
        let has_forces = !matches!(at.acting, Acting::Ahead | Acting::Gaps(_));
        let has_numbers = !matches!(at.acting, Acting::Ahead);
        let wants_parameters = has_numbers && !out.parameters.is_empty();
        sweep.start(model, &weighted);
        let mut sink = AdjointSink::new(at, weights, sweep, &mut self.memory, out);
        if has_forces {
            self.terms.emit_forces(at, found, &mut sink);
        }
        if let Some(seen) = seen {
            sink.look(seen);
            self.terms.emit_rows(at, found, &mut sink);
        }
        if wants_parameters {
            let mut numbers = Numbers::of(&mut sink);
            self.terms.emit_numbers(at, found, &mut numbers);
        }
        sink.finish();
        let mut slopes = Gradients {
            q: &mut *out.q,
            v: &mut *out.v,
            a: &mut self.by_a,
            parameters: &mut *out.parameters,
        };
        sweep.finish(model, &weighted, &mut slopes);
        if seen.is_some() {
            add_weighted_turning(model, point.v(), &sweep.by_seen, &sweep.slots, out);
        }
    }
}
