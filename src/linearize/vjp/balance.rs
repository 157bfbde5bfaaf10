//! Gradient of the weighted balance of all terms at a fixed acceleration.
//!
//! The acceleration solves  r(a, x) = ID(q, v, a) − τ − Σ Jᵀ F = 0  with ∂r/∂a = M + R, symmetric. So the gradient of λᵀ a is that of μᵀ r at fixed a
//! with μ = −(M + R)⁻¹ λ: one sweep. Forces of rows add to the weights, and rows of their own (`rows.rs`).

use super::rows::RowAdjoint;
use super::weights::{AccelerationWeights, Balanced};
use crate::dynamics::{AbaScratch, Calls, Slopes, Sweep, Weighted, resisted_forward_dynamics_into};
use crate::model::Model;
use crate::sim::{
    AccelerationScratch, AdjointPoint, Moment, RowWeights, Simulator, StepSlopes, TermAdjoint,
    TermAdjoints,
};

/// μ, and working memory to find it and the gradient of μᵀ r.
#[derive(Clone, Debug)]
pub(super) struct BalanceAdjoint {
    /// The robot where nothing has weight: at rest there, forward dynamics is M⁻¹.
    weightless: Model,
    aba: AbaScratch<f64>,
    rest: Vec<f64>,
    terms: TermAdjoints,
    sweep: Sweep<f64>,
    /// μ.
    pub(super) mu: Vec<f64>,
    /// M μ, which is of no use.
    by_a: Vec<f64>,
    rows: RowAdjoint,
}

impl BalanceAdjoint {
    pub(super) fn new(simulator: &Simulator, calls: Calls) -> Self {
        let model = simulator.model();
        let weightless = model.clone().with_gravity(nalgebra::Vector3::zeros());
        let zeros = || vec![0.0; model.nv()];
        Self {
            aba: AbaScratch::for_calls(&weightless, calls),
            weightless,
            rest: zeros(),
            terms: TermAdjoints::new(simulator),
            sweep: Sweep::new(model),
            mu: zeros(),
            by_a: zeros(),
            rows: RowAdjoint::new(simulator),
        }
    }

    /// Whether dampers and springs are those that the memory was made for.
    pub(super) fn is_of(&self, model: &Model) -> bool {
        self.terms.drives.is_of(model)
    }

    /// Finds μ of the balance with all its forces. Returns `true` where there is none: the acceleration is that without stops and rows, with velocity
    /// forces of the middle.
    pub(super) fn solve(
        &mut self,
        at: &Moment<'_, f64, f64>,
        found: &mut AccelerationScratch<f64>,
        weights: &AccelerationWeights<'_>,
    ) -> bool {
        if at.has_rows() {
            self.rows.solve(at, found, weights, &mut self.mu);
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
        at: &Moment<'_, f64, f64>,
        found: &AccelerationScratch<f64>,
        lambda: &[f64],
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

    /// Adds the gradient of μᵀ r at a fixed acceleration.
    pub(super) fn add_balance(
        &mut self,
        at: &Moment<'_, f64, f64>,
        found: &AccelerationScratch<f64>,
        here: &Balanced<'_>,
        out: &mut StepSlopes<'_>,
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
            self.rows.add_turning(at, out.v);
        }
        let mut slopes = Slopes {
            q: &mut *out.q,
            v: &mut *out.v,
            a: &mut self.by_a,
            parameters: &mut *out.parameters,
        };
        sweep.finish(model, &weighted, &mut slopes);
    }
}
