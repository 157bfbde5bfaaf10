//! Gradient of the weighted balance of forces at a fixed acceleration: one sweep along the tree, with the part of each term.

use super::rows::RowAdjoint;
use super::weights::Balanced;
use crate::dynamics::{Slopes, Sweep, Weighted};
use crate::scalar::Scalar;
use crate::sim::{
    AccelerationScratch, AdjointMemory, AdjointSink, AllSlopes, Bias, Held, Moment, Numbers,
    Simulator, SlopePoint, SlopeWeights, StepSlopes, TermSlopes, add_weighted_turning,
};

/// Weights of the balance, and working memory of [`add`](Self::add).
#[derive(Clone, Debug)]
pub(in crate::sim::integrators) struct BalanceAdjoint<T: Scalar> {
    terms: AllSlopes<T>,
    pub(in crate::sim::integrators) memory: AdjointMemory<T>,
    sweep: Sweep<T>,
    /// μ.
    pub(in crate::sim::integrators) mu: Vec<T>,
    /// M μ, which is of no use.
    by_a: Vec<T>,
    pub(in crate::sim::integrators) rows: RowAdjoint<T>,
}

impl<T: Scalar> BalanceAdjoint<T> {
    pub(in crate::sim::integrators) fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        let mut terms = AllSlopes::new(simulator);
        terms.reserve_numbers(simulator);
        Self {
            terms,
            memory: AdjointMemory::new(simulator),
            sweep: Sweep::new(model),
            mu: vec![T::zero(); model.nv()],
            by_a: vec![T::zero(); model.nv()],
            rows: RowAdjoint::new(simulator),
        }
    }

    /// Adds the gradient of μᵀ r at a fixed acceleration.
    pub(in crate::sim::integrators) fn add(
        &mut self,
        at: &Moment<'_, f64, T>,
        found: &AccelerationScratch<T>,
        here: &Balanced<'_, T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        let (model, rows, sweep) = (at.model(), &self.rows, &mut self.sweep);
        let balance = found.balance.as_deref().filter(|_| at.has_rows());
        let balance = balance.filter(|_| !here.is_free);
        let weighted = Weighted {
            q: at.q(),
            v: at.v(),
            a: here.a,
            mu: &self.mu,
            external: &[],
        };
        let of_balance = balance.filter(|_| at.simulator.held_rows() > 0);
        let of_balance = of_balance.map(|balance| Held {
            forces: balance.rows().forces(),
            bias: (balance.gyroscopic()).map_or(Bias::Moment, |_| Bias::Ahead(&rows.ahead)),
        });
        let point = SlopePoint {
            moment: at,
            a: here.a,
            is_free: here.is_free,
            balance,
            held: here.held.map(|held| held.rows).or(of_balance),
        };
        let weights = SlopeWeights {
            mu: &self.mu,
            y: here.held.map_or(&rows.by_y, |held| held.y),
            by_contact: here.contact,
            friction: &rows.by_friction,
        };
        let wants_parameters = !out.parameters.is_empty();
        sweep.start(model, &weighted);
        let mut sink = AdjointSink::new(&point, &weights, sweep, &mut self.memory, out);
        self.terms.emit_forces(&point, &found.terms, &mut sink);
        let looks = balance.is_some() || here.held.is_some();
        if looks {
            sink.look(here.held.map_or(&rows.seen, |held| held.seen));
            self.terms.emit_rows(&point, &found.terms, &mut sink);
        }
        if wants_parameters {
            let mut numbers = Numbers::of(&mut sink);
            self.terms.emit_numbers(&point, &found.terms, &mut numbers);
        }
        sink.finish();
        let mut slopes = Slopes {
            q: &mut *out.q,
            v: &mut *out.v,
            a: &mut self.by_a,
            parameters: &mut *out.parameters,
        };
        sweep.finish(model, &weighted, &mut slopes);
        if looks {
            add_weighted_turning(model, at.v(), &sweep.by_seen, out.v);
        }
    }
}
