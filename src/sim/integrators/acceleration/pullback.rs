//! Gradient of the acceleration at which all terms balance, by the implicit function theorem.
//!
//! The acceleration solves  r(a, x) = ID(q, v, a) − τ − Σ Jᵀ F = 0  with ∂r/∂a = M + R, symmetric. So the gradient of λᵀ a is that of μᵀ r at fixed a
//! with μ = −(M + R)⁻¹ λ: one sweep. Forces of rows add to the weights, and rows of their own (`rows.rs`).

use crate::dynamics::{AbaScratch, Calls, resisted_forward_dynamics_into};
use crate::model::Model;
use crate::scalar::Scalar;
use crate::sim::integrators::balance::BalanceAdjoint;
use crate::sim::integrators::balance::{AccelerationWeights, Balanced};
use crate::sim::integrators::half_step::{Change, MidpointAdjoint};
use crate::sim::{AccelerationScratch, Moment, Simulator, StepSlopes};

/// Working memory of [`add`](Self::add).
#[derive(Clone, Debug)]
pub(in crate::sim::integrators) struct AccelerationAdjoint<T: Scalar> {
    /// The robot where nothing has weight: at rest there, forward dynamics is M⁻¹.
    weightless: Model,
    aba: AbaScratch<T>,
    rest: Vec<T>,
    balance: BalanceAdjoint<T>,
    /// λ, for callers.
    pub(in crate::sim::integrators) weights: Vec<T>,
    midpoint: Option<Box<MidpointAdjoint<T>>>,
}

impl<T: Scalar> AccelerationAdjoint<T> {
    pub(in crate::sim::integrators) fn new(simulator: &Simulator, calls: Calls) -> Self {
        let model = simulator.model();
        let weightless = model.clone().with_gravity(nalgebra::Vector3::zeros());
        let zeros = || vec![T::zero(); model.nv()];
        Self {
            aba: AbaScratch::for_calls(&weightless, calls),
            weightless,
            rest: zeros(),
            balance: BalanceAdjoint::new(simulator),
            weights: zeros(),
            midpoint: (simulator.always_in_the_middle())
                .then(|| Box::new(MidpointAdjoint::new(simulator))),
        }
    }

    /// Adds the gradient of λᵀ a, and of the weighted changes of the state of contact, as they have been found at a moment.
    pub(in crate::sim::integrators) fn add(
        &mut self,
        at: &Moment<'_, f64, T>,
        found: &mut AccelerationScratch<T>,
        weights: &AccelerationWeights<'_, T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        let is_free = self.solve(at, found, weights, out);
        if !is_free {
            let here = Balanced {
                a: &found.a,
                is_free,
                contact: weights.contact,
                held: None,
            };
            self.balance.add(at, found, &here, out);
        }
        if let Some(gyroscopic) = found.gyroscopic(at) {
            let new = || Box::new(MidpointAdjoint::new(at.simulator));
            let midpoint = self.midpoint.get_or_insert_with(new);
            let change = Change {
                gyroscopic,
                is_all: is_free,
                weights,
            };
            midpoint.add(&mut self.balance, at, found, &change, out);
        }
    }

    /// Finds μ of the balance with all its forces. Returns `true` where there is none: the acceleration is that without stops and rows, with velocity
    /// forces of the middle.
    fn solve(
        &mut self,
        at: &Moment<'_, f64, T>,
        found: &mut AccelerationScratch<T>,
        weights: &AccelerationWeights<'_, T>,
        out: &mut StepSlopes<'_, T>,
    ) -> bool {
        if at.has_rows() {
            let BalanceAdjoint { rows, mu, .. } = &mut self.balance;
            rows.solve(at, found, weights, mu);
            out.add_time_step(rows.by_time_step(at));
            return false;
        }
        let is_free = found.gyroscopic(at).is_some() && !found.terms.stops.any_pushes();
        if !is_free {
            self.solve_without_rows(at, found, weights.a);
        }
        is_free
    }

    /// μ = −(M + R)⁻¹ λ
    fn solve_without_rows(
        &mut self,
        at: &Moment<'_, f64, T>,
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
            &mut self.balance.mu,
        );
        self.balance.mu.iter_mut().for_each(|mu| *mu = -*mu);
    }
}
