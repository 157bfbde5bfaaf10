//! Gradient of the acceleration at which all terms balance, by the implicit function theorem.
//!
//! The acceleration solves  r(a, x) = ID(q, v, a) − τ − Σ Jᵀ F = 0  with ∂r/∂a = M + R, symmetric. So the gradient of λᵀ a is that of μᵀ r at fixed a
//! with μ = −(M + R)⁻¹ λ: one sweep.

use super::midpoint::MidpointAdjoint;
use crate::dynamics::{AbaScratch, Calls, Slopes, Sweep, Weighted, resisted_forward_dynamics_into};
use crate::model::Model;
use crate::sim::{
    AccelerationScratch, AdjointPoint, Moment, Simulator, StepSlopes, TermAdjoint, TermAdjoints,
};

/// Working memory of [`add`](Self::add).
#[derive(Clone, Debug)]
pub(super) struct AccelerationAdjoint {
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
    /// λ, for callers.
    pub(super) weights: Vec<f64>,
    midpoint: Option<Box<MidpointAdjoint>>,
}

/// Weights of what is found at a moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct AccelerationWeights<'a> {
    /// λ, of the acceleration.
    pub(super) a: &'a [f64],
    /// Of what the step, or the rate at a moment, adds to the state of contact.
    pub(super) contact: &'a [f64],
}

/// Where the gradient of μᵀ r is taken.
#[derive(Clone, Copy, Debug)]
pub(super) struct Balanced<'a> {
    pub(super) a: &'a [f64],
    /// `true` for the acceleration that there would be without stops.
    pub(super) is_free: bool,
    /// See [`AccelerationWeights`].
    pub(super) contact: &'a [f64],
}

impl AccelerationAdjoint {
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
            weights: zeros(),
            midpoint: (simulator.always_in_the_middle())
                .then(|| Box::new(MidpointAdjoint::new(simulator))),
        }
    }

    /// Adds the gradient of λᵀ a, and of the weighted changes of the state of contact, as they have been found at a moment without rows.
    pub(super) fn add(
        &mut self,
        at: &Moment<'_, f64, f64>,
        found: &AccelerationScratch<f64>,
        weights: &AccelerationWeights<'_>,
        out: &mut StepSlopes<'_>,
    ) {
        if let Some(gyroscopic) = found.gyroscopic(at) {
            let new = || Box::new(MidpointAdjoint::new(at.simulator));
            let mut midpoint = self.midpoint.take().unwrap_or_else(new);
            midpoint.add(self, at, found, gyroscopic, weights, out);
            self.midpoint = Some(midpoint);
            return;
        }
        self.solve(at, found, weights.a);
        let here = Balanced {
            a: &found.a,
            is_free: false,
            contact: weights.contact,
        };
        self.add_balance(at, found, &here, out);
    }

    /// μ = −(M + R)⁻¹ λ
    pub(super) fn solve(
        &mut self,
        at: &Moment<'_, f64, f64>,
        found: &AccelerationScratch<f64>,
        lambda: &[f64],
    ) {
        resisted_forward_dynamics_into(
            &self.weightless,
            (at.q(), &self.rest),
            (lambda, found.resistance(at)),
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
        let (model, mu) = (at.model(), &self.mu[..]);
        let weighted = Weighted {
            q: at.q(),
            v: at.v(),
            a: here.a,
            mu,
            external: found.bodies(),
        };
        let point = AdjointPoint {
            moment: at,
            a: here.a,
            mu,
            is_free: here.is_free,
            by_contact: here.contact,
        };
        self.sweep.start(model, &weighted);
        (self.terms).add_forces(&point, &found.terms, &mut self.sweep, out);
        let mut slopes = Slopes {
            q: &mut *out.q,
            v: &mut *out.v,
            a: &mut self.by_a,
            parameters: &mut *out.parameters,
        };
        self.sweep.finish(model, &weighted, &mut slopes);
    }
}
