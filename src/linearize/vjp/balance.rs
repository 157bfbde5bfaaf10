//! Gradient of the weighted balance of forces at a fixed acceleration: one sweep along the tree, with the part of each term.

use super::rows::RowAdjoint;
use super::weights::Balanced;
use crate::dynamics::{Slopes, Sweep, Weighted};
use crate::model::Model;
use crate::scalar::Scalar;
use crate::sim::{
    AccelerationScratch, AdjointPoint, Moment, RowWeights, Simulator, StepSlopes, TermAdjoint,
    TermAdjoints, add_weighted_turning,
};

/// Weights of the balance, and working memory of [`add`](Self::add).
#[derive(Clone, Debug)]
pub(super) struct BalanceAdjoint<T: Scalar> {
    pub(super) terms: TermAdjoints<T>,
    sweep: Sweep<T>,
    /// μ.
    pub(super) mu: Vec<T>,
    /// M μ, which is of no use.
    by_a: Vec<T>,
    pub(super) rows: RowAdjoint<T>,
}

impl<T: Scalar> BalanceAdjoint<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        Self {
            terms: TermAdjoints::new(simulator),
            sweep: Sweep::new(model),
            mu: vec![T::zero(); model.nv()],
            by_a: vec![T::zero(); model.nv()],
            rows: RowAdjoint::new(simulator),
        }
    }

    /// Whether dampers and springs are those that the memory was made for.
    pub(super) fn is_of(&self, model: &Model) -> bool {
        self.terms.drives.is_of(model)
    }

    /// Adds the gradient of μᵀ r at a fixed acceleration.
    pub(super) fn add(
        &mut self,
        at: &Moment<'_, f64, T>,
        found: &AccelerationScratch<T>,
        here: &Balanced<'_, T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        let model = at.model();
        let balance = found.balance.as_deref().filter(|_| at.has_rows());
        let balance = balance.filter(|_| !here.is_free);
        let mut bodies = found.bodies();
        if balance.is_some() {
            bodies = &self.rows.bodies;
        }
        let mu = &self.mu[..];
        let weighted = Weighted {
            q: at.q(),
            v: at.v(),
            a: here.a,
            mu,
            external: bodies,
        };
        let point = AdjointPoint {
            moment: at,
            a: here.a,
            mu,
            is_free: here.is_free,
            by_contact: here.contact,
            rows: balance.map(|balance| RowWeights {
                balance,
                y: &self.rows.by_y,
                seen: &self.rows.seen,
                friction: &self.rows.by_friction,
            }),
        };
        let (sweep, terms) = (&mut self.sweep, &mut self.terms);
        sweep.start(model, &weighted);
        terms.add_forces(&point, &found.terms, sweep, out);
        if balance.is_some() {
            sweep.look(model, &self.rows.seen);
            terms.add_rows(&point, &found.terms, sweep, out);
            if !at.is_instant {
                let weights = &terms.contact.by_resistance;
                terms.drives.add_resistance(weights, &sweep.slots, out);
            }
        }
        if let Some(held) = &here.held {
            sweep.look(model, held.seen);
            terms.constraints.add(&point, held, sweep, out);
        }
        let mut slopes = Slopes {
            q: &mut *out.q,
            v: &mut *out.v,
            a: &mut self.by_a,
            parameters: &mut *out.parameters,
        };
        sweep.finish(model, &weighted, &mut slopes);
        if balance.is_some() || here.held.is_some() {
            add_weighted_turning(model, at.v(), &sweep.by_seen, out.v);
        }
    }
}
