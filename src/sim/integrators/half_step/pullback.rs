//! Gradient through velocity forces of the middle of a step.
//!
//! The acceleration a₀ without stops solves  r₀ = ID(q, v, a₀) + s C a₀ − τ + R₀ a₀ = 0  with C = ∂c/∂v; with stops that push or rows, a solves
//! r₁ = ID(q, v, a) + s C a₀ − τ₁ + R₁ a = 0. Backwards:  μ₁ = −(M + R₁)⁻¹ λ,  then  μ₀ = −(M + R₀ + s C)⁻ᵀ s Cᵀ μ₁, and the gradient is that of
//! μ₁ᵀ r₁ + μ₀ᵀ r₀ at fixed accelerations. Where no stop pushes, a is a₀ and only the second is there, with λ in place of s Cᵀ μ₁.
//!
//! Kinematic constraints hold a₀ with forces λ₀ beside it,  r₀ − Jᵀ λ₀ = 0  and  y₀ = J ã₀ + … = 0,  and rows of the step itself look ahead along ã₀. With all
//! weights g of a₀ that is  (M + R₀ + s C)ᵀ μ₀ = −(g − Jᵀ ρ),  where ρ is such that J μ₀ = 0, and y₀ is weighted with −ρ.
//!
//! C a₀ is the derivative of velocity forces along a₀: inverse dynamics on dual numbers, whose gradient the same sweep finds on dual numbers.

use crate::dynamics::{Gyroscopic, Slopes, Sweep, Weighted, each_left_out};
use crate::linalg::product::{add_scaled, dot};
use crate::scalar::{Dual, Scalar};
use crate::sim::integrators::balance::BalanceAdjoint;
use crate::sim::integrators::balance::{AccelerationWeights, Balanced, HeldWeights};
use crate::sim::{
    AccelerationScratch, Bias, Held, Moment, Simulator, StepSlopes, add_weighted_turning,
    turned_into,
};

/// Velocity forces of the middle of a step, and what is weighted.
#[derive(Clone, Copy)]
pub(in crate::sim::integrators) struct Change<'a, T> {
    pub(in crate::sim::integrators) gyroscopic: &'a Gyroscopic<T>,
    /// `true` if the acceleration is a₀; `false` if its balance has been weighted already, with μ₁.
    pub(in crate::sim::integrators) is_all: bool,
    pub(in crate::sim::integrators) weights: &'a AccelerationWeights<'a, T>,
}

/// A number with its derivative along the acceleration.
type Along<T> = Dual<T, 1>;

/// Working memory of [`add`](Self::add).
#[derive(Clone, Debug)]
pub(in crate::sim::integrators) struct MidpointAdjoint<T: Scalar> {
    sweep: Sweep<Along<T>>,
    q: Vec<Along<T>>,
    v: Vec<Along<T>>,
    rest: Vec<Along<T>>,
    mu: Vec<Along<T>>,
    by_q: Vec<Along<T>>,
    by_v: Vec<Along<T>>,
    by_a: Vec<Along<T>>,
    parameters: Vec<Along<T>>,
    /// μ₁, then μ₁ + μ₀.
    sum: Vec<T>,
    /// Weights of ã₀, along which rows look ahead.
    by_seen: Vec<T>,
    /// Weights of the rows that hold it.
    by_rows: Vec<T>,
    /// ã₀.
    seen: Vec<T>,
    /// The velocity on which s depends, on dual numbers.
    fastest: Vec<Along<T>>,
}

impl<T: Scalar> MidpointAdjoint<T> {
    pub(in crate::sim::integrators) fn new(simulator: &Simulator) -> Self {
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
            sum: vec![T::zero(); nv],
            by_seen: vec![T::zero(); nv],
            by_rows: Vec::with_capacity(simulator.held_rows()),
            seen: vec![T::zero(); nv],
            fastest: zeros(nv),
        }
    }

    /// Adds the gradient through these forces; where no stop pushes and no row takes part, that of λᵀ a and of the weighted changes of the state of
    /// contact altogether.
    pub(in crate::sim::integrators) fn add(
        &mut self,
        balance: &mut BalanceAdjoint<T>,
        at: &Moment<'_, f64, T>,
        found: &AccelerationScratch<T>,
        change: &Change<'_, T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        let (gyroscopic, s) = (change.gyroscopic, at.half_step.unwrap_or(T::zero()));
        if change.is_all {
            self.sum.fill(T::zero());
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
        let is_held = gyroscopic.bilateral.count() > 0;
        if is_held {
            self.hold(balance, at, gyroscopic);
        }
        gyroscopic.factor.solve_transposed(&mut balance.mu);
        balance.mu.iter_mut().for_each(|mu| *mu = -*mu);
        add_scaled(&mut self.sum, &balance.mu, T::one());
        if is_held {
            turned_into(at.model(), at.v(), &gyroscopic.a, &mut self.seen);
        }
        let here = Balanced {
            a: &gyroscopic.a,
            is_free: true,
            contact: match change.is_all {
                true => change.weights.contact,
                false => &[],
            },
            held: is_held.then_some(HeldWeights {
                y: &self.by_rows,
                seen: &self.seen,
                rows: Held {
                    forces: &gyroscopic.bilateral.forces,
                    bias: Bias::Start,
                },
            }),
        };
        balance.add(at, found, &here, out);
        if is_held {
            add_weighted_turning(at.model(), at.v(), &self.by_seen, out.v);
        }
        self.add_velocity_forces(at, gyroscopic, s, out);
        self.add_whirl(at, gyroscopic, out);
    }

    /// Adds the weights that a₀ has for rows that look ahead along it, and takes those of the rows that hold it.
    fn hold(
        &mut self,
        balance: &mut BalanceAdjoint<T>,
        at: &Moment<'_, f64, T>,
        gyroscopic: &Gyroscopic<T>,
    ) {
        let by_next_v = self.by_seen.iter_mut().zip(&balance.memory.by_next_v);
        by_next_v.for_each(|(by_seen, &x)| *by_seen = x * at.dt());
        add_scaled(&mut balance.mu, &self.by_seen, T::one());
        let bilateral = &gyroscopic.bilateral;
        bilateral.solve_transposed(&mut balance.mu, &mut self.by_rows);
        self.by_rows.iter_mut().for_each(|x| *x = -*x);
    }

    /// Adds the gradient of (μ₀ + μ₁)ᵀ s C a₀ at fixed a₀ and s.
    fn add_velocity_forces(
        &mut self,
        at: &Moment<'_, f64, T>,
        gyroscopic: &Gyroscopic<T>,
        s: T,
        out: &mut StepSlopes<'_, T>,
    ) {
        let model = at.model();
        for (out, &q) in self.q.iter_mut().zip(at.q()) {
            *out = Dual::constant_of(q);
        }
        for (k, out) in self.v.iter_mut().enumerate() {
            *out = Dual::new(gyroscopic.v[k], [gyroscopic.a[k]]);
            self.mu[k] = Dual::constant_of(self.sum[k]);
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

    /// Adds the gradient of (μ₀ + μ₁)ᵀ s C a₀ in s, which the time step has and, where it grows with it, the speed.
    fn add_whirl(
        &mut self,
        at: &Moment<'_, f64, T>,
        gyroscopic: &Gyroscopic<T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        if at.simulator.always_in_the_middle() && !out.has_parts {
            return;
        }
        let by_s = dot(&self.sum, &gyroscopic.change);
        let v = self.fastest.iter_mut().zip(at.v());
        v.for_each(|(out, &v)| *out = Dual::constant_of(v));
        let dt = Along::variable(T::constant(at.dt()), 0);
        let s = at.simulator.half_of(dt, &self.fastest);
        out.add_time_step(by_s * s.map_or(T::zero(), |s| s.eps[0]));
        if at.simulator.always_in_the_middle() {
            return;
        }
        for k in at.simulator.turning() {
            self.fastest[k].eps[0] = T::one();
            let s = at.simulator.half_step(&self.fastest);
            out.v[k] += by_s * s.map_or(T::zero(), |s| s.eps[0]);
            self.fastest[k].eps[0] = T::zero();
        }
    }
}
