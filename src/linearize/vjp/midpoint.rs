//! Gradient through velocity forces of the middle of a step.
//!
//! The acceleration a₀ without stops solves  r₀ = ID(q, v, a₀) + s C a₀ − τ + R₀ a₀ = 0  with C = ∂c/∂v; with stops that push or rows, a solves
//! r₁ = ID(q, v, a) + s C a₀ − τ₁ + R₁ a = 0. Backwards:  μ₁ = −(M + R₁)⁻¹ λ,  then  μ₀ = −(M + R₀ + s C)⁻ᵀ s Cᵀ μ₁, and the gradient is that of
//! μ₁ᵀ r₁ + μ₀ᵀ r₀ at fixed accelerations. Where no stop pushes, a is a₀ and only the second is there, with λ in place of s Cᵀ μ₁.
//!
//! C a₀ is the derivative of velocity forces along a₀: inverse dynamics on dual numbers, whose gradient the same sweep finds on dual numbers.

use super::balance::BalanceAdjoint;
use super::weights::{AccelerationWeights, Balanced};
use crate::dynamics::{Gyroscopic, Slopes, Sweep, Weighted, each_left_out};
use crate::linalg::product::{add_scaled, dot};
use crate::scalar::Dual;
use crate::sim::{AccelerationScratch, Moment, Simulator, StepSlopes};

/// Velocity forces of the middle of a step, and what is weighted.
#[derive(Clone, Copy)]
pub(super) struct Change<'a> {
    pub(super) gyroscopic: &'a Gyroscopic<f64>,
    /// `true` if the acceleration is a₀; `false` if its balance has been weighted already, with μ₁.
    pub(super) is_all: bool,
    pub(super) weights: &'a AccelerationWeights<'a>,
}

/// A number with its derivative along the acceleration.
type Along = Dual<f64, 1>;

/// Working memory of [`add`](Self::add).
#[derive(Clone, Debug)]
pub(super) struct MidpointAdjoint {
    sweep: Sweep<Along>,
    q: Vec<Along>,
    v: Vec<Along>,
    rest: Vec<Along>,
    mu: Vec<Along>,
    by_q: Vec<Along>,
    by_v: Vec<Along>,
    by_a: Vec<Along>,
    parameters: Vec<Along>,
    /// μ₁, then μ₁ + μ₀.
    sum: Vec<f64>,
    /// The velocity on which s depends, on dual numbers.
    fastest: Vec<Along>,
}

impl MidpointAdjoint {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, zeros) = (simulator.model(), |n: usize| vec![Along::from(0.0); n]);
        let (sweep, nv) = (Sweep::new(model), model.nv());
        Self {
            parameters: zeros(sweep.slots.len),
            sweep,
            q: zeros(model.nq()),
            v: zeros(nv),
            rest: zeros(nv),
            mu: zeros(nv),
            by_q: zeros(nv),
            by_v: zeros(nv),
            by_a: zeros(nv),
            sum: vec![0.0; nv],
            fastest: zeros(nv),
        }
    }

    /// Adds the gradient through these forces; where no stop pushes and no row takes part, that of λᵀ a and of the weighted changes of the state of
    /// contact altogether.
    pub(super) fn add(
        &mut self,
        balance: &mut BalanceAdjoint,
        at: &Moment<'_, f64, f64>,
        found: &AccelerationScratch<f64>,
        change: &Change<'_>,
        out: &mut StepSlopes<'_>,
    ) {
        let (gyroscopic, s) = (change.gyroscopic, at.half_step.unwrap_or(0.0));
        let mut here = Balanced {
            a: &gyroscopic.a,
            is_free: true,
            contact: &[],
        };
        if change.is_all {
            here.contact = change.weights.contact;
            self.sum.fill(0.0);
            balance.mu.copy_from_slice(change.weights.a);
        } else {
            self.sum.copy_from_slice(&balance.mu);
            // s Cᵀ μ₁
            let columns = gyroscopic
                .slope
                .as_slice()
                .chunks_exact(self.sum.len().max(1));
            for (k, column) in columns.enumerate() {
                balance.mu[k] = s * dot(column, &self.sum);
            }
        }
        gyroscopic.factor.solve_transposed(&mut balance.mu);
        balance.mu.iter_mut().for_each(|mu| *mu = -*mu);
        add_scaled(&mut self.sum, &balance.mu, 1.0);
        balance.add(at, found, &here, out);
        self.add_velocity_forces(at, gyroscopic, s, out);
        self.add_whirl(at, gyroscopic, out);
    }

    /// Adds the gradient of (μ₀ + μ₁)ᵀ s C a₀ at fixed a₀ and s.
    fn add_velocity_forces(
        &mut self,
        at: &Moment<'_, f64, f64>,
        gyroscopic: &Gyroscopic<f64>,
        s: f64,
        out: &mut StepSlopes<'_>,
    ) {
        let model = at.model();
        for (out, &q) in self.q.iter_mut().zip(at.q()) {
            *out = q.into();
        }
        for (k, out) in self.v.iter_mut().enumerate() {
            *out = Dual::new(gyroscopic.v[k], [gyroscopic.a[k]]);
            self.mu[k] = self.sum[k].into();
        }
        each_left_out(model, |k| self.v[k] = Along::from(0.0));
        let wanted = out.parameters.len().min(self.parameters.len());
        let results = [&mut self.by_q, &mut self.by_v, &mut self.by_a];
        results.into_iter().for_each(|x| x.fill(Along::from(0.0)));
        self.parameters[..wanted].fill(Along::from(0.0));
        let weighted = Weighted {
            q: &self.q,
            v: &self.v,
            a: &self.rest,
            mu: &self.mu,
            external: &[],
        };
        let mut slopes = Slopes {
            q: &mut self.by_q,
            v: &mut self.by_v,
            a: &mut self.by_a,
            parameters: &mut self.parameters[..wanted],
        };
        self.sweep.add(model, &weighted, &mut slopes);
        each_left_out(model, |k| self.by_v[k] = Along::from(0.0));
        let pairs = [
            (&mut *out.q, &self.by_q),
            (&mut *out.v, &self.by_v),
            (&mut *out.parameters, &self.parameters),
        ];
        for (out, x) in pairs {
            let entries = out.iter_mut().zip(x);
            entries.for_each(|(out, x)| *out += s * x.eps[0]);
        }
    }

    /// Adds the gradient of (μ₀ + μ₁)ᵀ s C a₀ in s, where it grows with the speed.
    fn add_whirl(
        &mut self,
        at: &Moment<'_, f64, f64>,
        gyroscopic: &Gyroscopic<f64>,
        out: &mut StepSlopes<'_>,
    ) {
        if at.simulator.always_in_the_middle() {
            return;
        }
        let by_s = dot(&self.sum, &gyroscopic.change);
        let v = self.fastest.iter_mut().zip(at.v());
        v.for_each(|(out, &v)| *out = v.into());
        for k in at.simulator.turning() {
            self.fastest[k].eps[0] = 1.0;
            let s = at.simulator.half_step(&self.fastest);
            out.v[k] += by_s * s.map_or(0.0, |s| s.eps[0]);
            self.fastest[k].eps[0] = 0.0;
        }
    }
}
