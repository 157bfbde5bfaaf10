//! Weights of rows whose forces a solver finds, by the implicit function theorem.
//!
//! At fixed acceleration a and forces f let z = ∂(ID − τ − Jᵀ f) and y = ∂(J ã − w + R f). Then δf = S (y − J M⁻¹ z) with the solver's sensitivity S, and
//! δa = −M⁻¹ z + M⁻¹ Jᵀ δf. So with the weights λ of a, and given weights of f,
//!
//! > λᵀ δa = μᵀ z + `λ_y`ᵀ y,   `λ_y` = Sᵀ J M⁻¹ λ,   μ = −M⁻¹ (λ + Jᵀ `λ_y`).

use super::AccelerationScratch;
use crate::linalg::product::{add_scaled, dot};
use crate::scalar::Scalar;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::simulator::Simulator;
use crate::sim::terms::{AllDerivatives, DerivativePoint, TermDerivatives, turned_into};

/// Weights of the results at an instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AccelerationWeights<'a, T> {
    /// λ, of the acceleration.
    pub(crate) a: &'a [T],
    /// Of what the step, or the rate at an instant, adds to the contact state.
    pub(crate) contact: &'a [T],
    /// Whether the gradient in friction is requested.
    pub(crate) has_friction: bool,
}

/// Weights of rows, and working memory to find them.
#[derive(Clone, Debug)]
pub(super) struct RowAdjoint<T> {
    /// `λ_y`.
    pub(super) by_y: Vec<T>,
    /// Effect of the friction of each block; empty if it is not wanted.
    pub(super) by_friction: Vec<T>,
    /// Effect of the scale in which laws hold: that of the time step on smoothed laws, see `Balance::smooth`.
    by_scale: T,
    /// Jᵀ `λ_y`.
    by_seen: Vec<T>,
    /// ã.
    pub(super) seen: Vec<T>,
    scratch: Vec<T>,
}

impl<T: Scalar> RowAdjoint<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let nv = simulator.model().nv();
        let points = simulator.contacts().map_or(0, |contacts| {
            contacts
                .points()
                .len()
                .min(contacts.solver_options().points)
        });
        let of_each = simulator.contacts().map_or(0, |c| c.rows_of_each());
        let rows = match simulator.needs_solver() {
            true => simulator.bilateral_rows() + simulator.joint_rows() + of_each * points,
            false => 0,
        };
        Self {
            by_y: Vec::with_capacity(rows),
            by_friction: Vec::with_capacity(rows),
            by_scale: T::zero(),
            by_seen: vec![T::zero(); nv],
            seen: vec![T::zero(); nv],
            scratch: vec![T::zero(); nv],
        }
    }

    /// Weighs one of so many rows, while ã = 0.
    pub(super) fn weigh_one(&mut self, row: usize, rows: usize, weight: T) {
        self.by_y.clear();
        self.by_y.resize(rows, T::zero());
        self.by_y[row] = weight;
        self.seen.fill(T::zero());
    }

    /// Derivative of the weighted sum in the time step through the smoothing of laws; zero for exact laws, which have no scale. There s = √(Δt / Δt₀).
    pub(super) fn by_time_step(&self, at: &EvaluationPoint<'_, f64, T>) -> T {
        let contacts = at.solved_contacts();
        let smoothed = contacts.is_some_and(|contacts| contacts.smoothing().is_some());
        match smoothed {
            true => self.by_scale * (0.5 / at.dt()),
            false => T::zero(),
        }
    }

    /// Finds `λ_y` and μ.
    pub(super) fn solve(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        found: &mut AccelerationScratch<T>,
        weights: &AccelerationWeights<'_, T>,
        mu: &mut [T],
    ) {
        let has_friction = weights.has_friction;
        let Some(balance) = found.balance.as_deref() else {
            return;
        };
        mu.copy_from_slice(weights.a);
        balance.factor().solve(mu);
        let (n, nv) = (balance.rows().count(), mu.len().max(1));
        let jacobian = balance.rows().first_rows(n);
        // The weights of the forces become those of y.
        self.by_y.clear();
        (self.by_y).extend(jacobian.chunks_exact(nv).map(|row| dot(row, mu)));
        let (by_force, point) = (
            &mut self.by_y,
            DerivativePoint::of_all(at, &found.a, Some(balance)),
        );
        AllDerivatives::each_rate_by_force(&point, &found.terms, &mut |rate, row, slope| {
            by_force[row] += slope * weights.contact[rate];
        });
        self.by_friction.clear();
        if has_friction {
            (self.by_friction).resize(balance.rows().blocks(), T::zero());
        }
        let Some(balance) = found.balance.as_deref_mut() else {
            return;
        };
        let weighted = dot(&self.by_y, balance.rows().forces());
        balance.respond_transposed(at, &mut self.by_y, &mut self.by_friction);
        let rows = balance.rows();
        self.by_scale = rows.by_scale(&self.by_y, &self.by_friction, weighted);
        self.by_seen.fill(T::zero());
        let jacobian = balance.rows().first_rows(n);
        for (row, weight) in jacobian.chunks_exact(nv).zip(&self.by_y) {
            add_scaled(&mut self.by_seen, row, *weight);
        }
        self.scratch.copy_from_slice(&self.by_seen);
        balance.factor().solve(&mut self.scratch);
        for (mu, &x) in mu.iter_mut().zip(&self.scratch) {
            *mu = -(*mu + x);
        }
        turned_into(at.model(), at.v(), &found.a, &mut self.seen);
    }
}
