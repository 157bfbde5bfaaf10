//! Weights of rows whose forces a solver finds, by the implicit function theorem.
//!
//! At fixed acceleration a and forces f let z = ∂(ID − τ − Jᵀ f) and y = ∂(J ã − w + R f). Then δf = S (y − J M⁻¹ z) with the solver's sensitivity S, and
//! δa = −M⁻¹ z + M⁻¹ Jᵀ δf. So with the weights λ of a, and those of f that are given beside,
//!
//! > λᵀ δa = μᵀ z + `λ_y`ᵀ y,   `λ_y` = Sᵀ J M⁻¹ λ,   μ = −M⁻¹ (λ + Jᵀ `λ_y`).

use super::weights::AccelerationWeights;
use crate::contact::ROWS;
use crate::linalg::product::{add_scaled, dot};
use crate::sim::{
    AccelerationScratch, ContactAdjoint, Moment, Simulator, each_turning, turned_into,
};
use crate::spatial::Force;

/// Weights of rows, and working memory to find them.
#[derive(Clone, Debug)]
pub(super) struct RowAdjoint {
    /// `λ_y`.
    pub(super) by_y: Vec<f64>,
    /// Of the forces of rows.
    by_force: Vec<f64>,
    /// Effect of the friction of each block; empty if it is not wanted.
    pub(super) by_friction: Vec<f64>,
    /// S, by columns, or derivatives in friction.
    response: Vec<f64>,
    /// Jᵀ `λ_y`.
    by_seen: Vec<f64>,
    /// ã.
    pub(super) seen: Vec<f64>,
    /// On each body, with those of rows.
    pub(super) bodies: Vec<Force<f64>>,
    scratch: Vec<f64>,
}

impl RowAdjoint {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (nv, n) = (simulator.model().nv(), simulator.model().n_bodies());
        let points = simulator.contacts().map_or(0, |contacts| {
            contacts
                .points()
                .len()
                .min(contacts.solver_options().points)
        });
        let rows = match simulator.needs_solver() {
            true => nv + ROWS * points,
            false => 0,
        };
        Self {
            by_y: Vec::with_capacity(rows),
            by_force: Vec::with_capacity(rows),
            by_friction: Vec::with_capacity(rows),
            response: Vec::with_capacity(rows * rows),
            by_seen: vec![0.0; nv],
            seen: vec![0.0; nv],
            bodies: vec![Force::zero(); n],
            scratch: vec![0.0; nv],
        }
    }

    /// Finds `λ_y` and μ.
    pub(super) fn solve(
        &mut self,
        at: &Moment<'_, f64, f64>,
        found: &mut AccelerationScratch<f64>,
        weights: &AccelerationWeights<'_>,
        mu: &mut [f64],
    ) {
        let has_friction = weights.has_friction;
        let term = &found.terms.contact;
        let Some(balance) = found.balance.as_deref_mut() else {
            return;
        };
        mu.copy_from_slice(weights.a);
        balance.factor().solve(mu);
        let (n, nv) = (balance.rows().count(), mu.len().max(1));
        let jacobian = balance.rows().first_rows(n);
        self.by_force.clear();
        (self.by_force).extend(jacobian.chunks_exact(nv).map(|row| dot(row, mu)));
        let by_force = &mut self.by_force;
        ContactAdjoint::add_bristle_weights(at, term, balance, weights.contact, by_force);
        self.response.clear();
        self.response.resize(n * n, 0.0);
        balance.solver_mut().response(&mut self.response);
        self.by_y.clear();
        let columns = self.response.chunks_exact(n.max(1));
        (self.by_y).extend(columns.map(|column| dot(column, &self.by_force)));
        self.by_friction.clear();
        if has_friction {
            let blocks = balance.rows().blocks();
            self.response.resize(n * blocks, 0.0);
            balance.solver_mut().friction_response(&mut self.response);
            let columns = self.response.chunks_exact(n.max(1));
            (self.by_friction).extend(columns.map(|column| dot(column, &self.by_force)));
        }
        self.by_seen.fill(0.0);
        let jacobian = balance.rows().first_rows(n);
        for (row, weight) in jacobian.chunks_exact(nv).zip(&self.by_y) {
            add_scaled(&mut self.by_seen, row, *weight);
        }
        self.scratch.copy_from_slice(&self.by_seen);
        balance.factor().solve(&mut self.scratch);
        for (mu, x) in mu.iter_mut().zip(&self.scratch) {
            *mu = -(*mu + x);
        }
        turned_into(at.model(), at.v(), &found.a, &mut self.seen);
        self.find_bodies(at, found);
    }

    /// Adds the gradient of `λ_y`ᵀ J ã in the velocity that turns axes.
    pub(super) fn add_turning(&self, at: &Moment<'_, f64, f64>, by_v: &mut [f64]) {
        for body in at.model().independent() {
            each_turning(body, at.v(), |k, x| {
                for (l, slope) in x.eps.iter().enumerate().take(body.joint.nv()) {
                    by_v[body.v + l] += self.by_seen[k] * slope;
                }
            });
        }
    }

    fn find_bodies(&mut self, at: &Moment<'_, f64, f64>, found: &AccelerationScratch<f64>) {
        self.bodies.fill(Force::zero());
        self.bodies[..found.bodies().len()].copy_from_slice(found.bodies());
        ContactAdjoint::add_body_forces(at, &found.terms.contact, &mut self.bodies);
    }
}
