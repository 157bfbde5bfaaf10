//! Gradient of the acceleration at which all terms balance, by the implicit function theorem.

use super::balance::BalanceAdjoint;
use super::midpoint::{Change, MidpointAdjoint};
use super::weights::{AccelerationWeights, Balanced};
use crate::dynamics::Calls;
use crate::model::Model;
use crate::sim::{AccelerationScratch, Moment, Simulator, StepSlopes};

/// Working memory of [`add`](Self::add).
#[derive(Clone, Debug)]
pub(super) struct AccelerationAdjoint {
    balance: BalanceAdjoint,
    /// λ, for callers.
    pub(super) weights: Vec<f64>,
    midpoint: Option<Box<MidpointAdjoint>>,
}

impl AccelerationAdjoint {
    pub(super) fn new(simulator: &Simulator, calls: Calls) -> Self {
        Self {
            balance: BalanceAdjoint::new(simulator, calls),
            weights: vec![0.0; simulator.model().nv()],
            midpoint: (simulator.always_in_the_middle())
                .then(|| Box::new(MidpointAdjoint::new(simulator))),
        }
    }

    /// Whether dampers and springs are those that the memory was made for.
    pub(super) fn is_of(&self, model: &Model) -> bool {
        self.balance.is_of(model)
    }

    /// Adds the gradient of λᵀ a, and of the weighted changes of the state of contact, as they have been found at a moment.
    pub(super) fn add(
        &mut self,
        at: &Moment<'_, f64, f64>,
        found: &mut AccelerationScratch<f64>,
        weights: &AccelerationWeights<'_>,
        out: &mut StepSlopes<'_>,
    ) {
        let is_free = self.balance.solve(at, found, weights);
        if !is_free {
            let here = Balanced {
                a: &found.a,
                is_free,
                contact: weights.contact,
            };
            self.balance.add_balance(at, found, &here, out);
        }
        if let Some(gyroscopic) = found.gyroscopic(at) {
            let new = || Box::new(MidpointAdjoint::new(at.simulator));
            let change = Change {
                gyroscopic,
                is_all: is_free,
                weights,
            };
            let midpoint = self.midpoint.get_or_insert_with(new);
            midpoint.add(&mut self.balance, at, found, &change, out);
        }
    }
}
