//! Gradient through velocity forces of the middle of a step.
//!
//! The acceleration a₀ without joint limits solves  r₀ = ID(q, v, a₀) + s C a₀ − τ + R₀ a₀ = 0  with C = ∂c/∂v; with active joint limits or rows, a solves
//! r₁ = ID(q, v, a) + s C a₀ − τ₁ + R₁ a = 0. Backwards:  μ₁ = −(M + R₁)⁻¹ λ,  then  μ₀ = −(M + R₀ + s C)⁻ᵀ s Cᵀ μ₁, and the gradient is that of
//! μ₁ᵀ r₁ + μ₀ᵀ r₀ at fixed accelerations. Where no joint limit pushes, a is a₀ and only the second is there, with λ in place of s Cᵀ μ₁.
//!
//! Kinematic constraints hold a₀ with forces λ₀ beside it,  r₀ − Jᵀ λ₀ = 0  and  y₀ = J ã₀ + … = 0,  and rows of the step itself look ahead along ã₀. With all
//! weights g of a₀ that is  (M + R₀ + s C)ᵀ μ₀ = −(g − Jᵀ ρ),  where ρ is such that J μ₀ = 0, and y₀ is weighted with −ρ.
//!
//! As c is quadratic in v, s C a₀ = ½ (c(v + s a₀) − c(v − s a₀)): the sweep of inverse dynamics finds its gradient at two velocities.

use super::ahead::Ahead;
use super::gyroscopic::{Gyroscopic, fold_weights};
use super::{HalfStep, each_derivative, half_step, slope_in_time};
use crate::dynamics::{Gradients, Sweep, Weighted};
use crate::joint::Joint as _;
use crate::linalg::product::{add_scaled, dot};
use crate::model::Model;
use crate::scalar::{Dual, MapEach, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::balance::BalanceAdjoint;
use crate::sim::simulator::Simulator;
use crate::sim::terms::{
    Acting, DerivativePoint, StepGradientSum, TermWeights, Terms, add_weighted_turning, turned_into,
};
use crate::spatial::linear::cross;

/// A half step and its weights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change<'a, T: Scalar> {
    pub(crate) half_step: &'a HalfStep<T>,
    /// As they have been evaluated.
    pub(crate) terms: &'a Terms<T>,
    pub(crate) weights: Weights<'a, T>,
}

/// The weights.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Weights<'a, T> {
    /// The acceleration, which is a₀, with λ, and changes of the contact state.
    All(&'a [T], &'a [T]),
    /// Another acceleration, whose balance has been weighted already with μ₁, and whose rows with `λ_y`.
    Rest(&'a [T], &'a [T]),
}

/// Working memory of [`add`](Self::add).
#[derive(Clone, Debug)]
pub(crate) struct Adjoint<T: Scalar> {
    sweep: Sweep<T>,
    v: Vec<T>,
    rest: Vec<T>,
    weights: Vec<T>,
    by_v: Vec<T>,
    by_a: Vec<T>,
    /// The velocity on which s depends, on dual numbers.
    fastest: Vec<Dual<T, 1>>,
    /// μ₁, then μ₁ + μ₀.
    sum: Vec<T>,
    /// μ₀.
    mu: Vec<T>,
    /// `None` without constraints.
    held: Option<Box<BilateralAdjoint<T>>>,
}

/// Weights of constraints that hold a₀ and look ahead along it.
#[derive(Clone, Debug)]
struct BilateralAdjoint<T: Scalar> {
    ahead: Ahead<T>,
    /// Zeros: no bias depends on the acceleration, and nothing else is weighted.
    rest: Vec<T>,
    /// Of v⁺.
    by_next_v: Vec<T>,
    /// Of ã₀, along which rows look ahead.
    by_seen: Vec<T>,
    /// Of the rows that hold it.
    by_rows: Vec<T>,
    /// ã₀, and ã of the point ahead.
    seen: Vec<T>,
    seen_ahead: Vec<T>,
}

impl<T: Scalar> BilateralAdjoint<T> {
    fn new(simulator: &Simulator) -> Box<Self> {
        let zeros = || vec![T::zero(); simulator.model().nv()];
        Box::new(Self {
            ahead: Ahead::new(simulator),
            rest: zeros(),
            by_next_v: zeros(),
            by_seen: zeros(),
            by_rows: Vec::with_capacity(simulator.bilateral_rows()),
            seen: zeros(),
            seen_ahead: zeros(),
        })
    }

    /// Adds the gradient of the dependence of rows on the velocity after the step; a₀ gets weights.
    ///
    /// * `by_y` – `λ_y`
    fn look_ahead(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        by_y: &[T],
        terms: &Terms<T>,
        balance: &mut BalanceAdjoint<T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let (rest, by_next_v) = (&self.rest[..], &mut self.by_next_v);
        let point = self.ahead.point(at, &self.seen);
        turned_into(at.model(), point.v(), rest, &mut self.seen_ahead);
        let point = DerivativePoint {
            point: &point,
            a: rest,
            acting: Acting::Ahead,
        };
        let weights = TermWeights {
            mu: rest,
            y: by_y,
            by_contact: &[],
            friction: &[],
        };
        by_next_v.fill(T::zero());
        let mut slopes = StepGradientSum {
            q: &mut *out.q,
            v: by_next_v,
            contact: &mut [],
            activation: &mut [],
            u: &mut *out.u,
            parameters: &mut *out.parameters,
            has_parts: out.has_parts,
        };
        balance.add(&point, &weights, Some(&self.seen_ahead), terms, &mut slopes);
        add_scaled(out.v, by_next_v, T::one());
        // v⁺ = v + Δt ã₀
        out.add_time_step(dot(by_next_v, &self.seen));
        let by_seen = self.by_seen.iter_mut().zip(by_next_v);
        by_seen.for_each(|(by_seen, &mut x)| *by_seen = x * at.dt());
    }

    /// Adds the weights that a₀ has for rows that look ahead along it to others, and takes those of the rows that hold it.
    fn hold(&mut self, gyroscopic: &Gyroscopic<T>, mu: &mut [T]) {
        add_scaled(mu, &self.by_seen, T::one());
        let bilateral = &gyroscopic.bilateral;
        self.by_rows.clear();
        self.by_rows.resize(bilateral.count(), T::zero());
        bilateral.solve_transposed(mu, &mut self.by_rows);
        self.by_rows.iter_mut().for_each(|x| *x = -*x);
    }
}

impl<T: Scalar> Adjoint<T> {
    /// Makes memory for a simulator.
    pub(crate) fn new(simulator: &Simulator) -> Box<Self> {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let zeros = || vec![T::zero(); nv];
        Box::new(Self {
            sweep: Sweep::new(model),
            v: zeros(),
            rest: zeros(),
            weights: zeros(),
            by_v: zeros(),
            by_a: zeros(),
            fastest: vec![Dual::from(0.0); nv],
            sum: zeros(),
            mu: zeros(),
            held: (simulator.bilateral_rows() > 0).then(|| BilateralAdjoint::new(simulator)),
        })
    }

    /// Adds the gradient through these forces; where a₀ is the acceleration, that of λᵀ a and of the weighted changes of the contact state altogether.
    pub(crate) fn add(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        change: &Change<'_, T>,
        balance: &mut BalanceAdjoint<T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let gyroscopic = &change.half_step.gyroscopic;
        self.start(at, change);
        if let Some(held) = &mut self.held {
            turned_into(at.model(), at.v(), &gyroscopic.a, &mut held.seen);
            if let Weights::Rest(_, by_y) = change.weights {
                held.look_ahead(at, by_y, change.terms, balance, out);
            }
            held.hold(gyroscopic, &mut self.mu);
            let slots = &self.sweep.slots;
            add_weighted_turning(at.model(), at.v(), &held.by_seen, slots, out);
        }
        gyroscopic.factor.solve_transposed(&mut self.mu);
        self.mu.iter_mut().for_each(|mu| *mu = -*mu);
        add_scaled(&mut self.sum, &self.mu, T::one());
        self.add_balance(at, change, balance, out);
        self.add_velocity_forces(at, gyroscopic, out);
    }

    /// Weights of a₀: λ, or s Cᵀ μ₁.
    fn start(&mut self, at: &EvaluationPoint<'_, f64, T>, change: &Change<'_, T>) {
        match change.weights {
            Weights::All(lambda, _) => {
                self.sum.fill(T::zero());
                self.mu.copy_from_slice(lambda);
            }
            Weights::Rest(mu, _) => {
                self.sum.copy_from_slice(mu);
                let slope = &change.half_step.gyroscopic.slope;
                for (k, own) in self.mu.iter_mut().enumerate() {
                    let (rows, column) = slope.in_tree(k);
                    *own = half_step(at) * dot(column, &mu[rows]);
                }
            }
        }
    }

    /// Adds the gradient of the balance at a₀.
    fn add_balance(
        &self,
        at: &EvaluationPoint<'_, f64, T>,
        change: &Change<'_, T>,
        balance: &mut BalanceAdjoint<T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let (gyroscopic, held) = (&change.half_step.gyroscopic, self.held.as_deref());
        let point = DerivativePoint {
            point: at,
            a: &gyroscopic.a,
            acting: Acting::Start(&gyroscopic.bilateral.forces),
        };
        let weights = TermWeights {
            mu: &self.mu,
            y: held.map_or(&[], |held| &held.by_rows),
            by_contact: match change.weights {
                Weights::All(_, contact) => contact,
                Weights::Rest(..) => &[],
            },
            friction: &[],
        };
        let seen = held.map(|held| &held.seen[..]);
        balance.add(&point, &weights, seen, change.terms, out);
    }

    /// Adds the gradient of (μ₀ + μ₁)ᵀ s C a₀ at fixed a₀.
    fn add_velocity_forces(
        &mut self,
        at: &EvaluationPoint<'_, f64, T>,
        gyroscopic: &Gyroscopic<T>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let model = at.model();
        for side in [1.0, -1.0] {
            self.by_v.fill(T::zero());
            gyroscopic.velocity_into(model, half_step(at), side, &mut self.v);
            for (weight, &sum) in self.weights.iter_mut().zip(&self.sum) {
                *weight = sum * (0.5 * side);
            }
            let weighted = Weighted {
                q: at.q(),
                v: &self.v,
                a: &self.rest,
                mu: &self.weights,
                external: &[],
            };
            let mut slopes = Gradients {
                q: &mut *out.q,
                v: &mut self.by_v,
                a: &mut self.by_a,
                parameters: &mut *out.parameters,
            };
            self.sweep.add(model, &weighted, &mut slopes);
            self.add_centers(model, out.parameters);
            fold_weights(model, &mut self.by_v);
            add_scaled(out.v, &self.by_v, T::one());
        }
        let by_s = dot(&self.sum, &gyroscopic.change);
        each_derivative(at, &mut self.fastest, |k, slope| out.v[k] += by_s * slope);
        if out.has_parts {
            out.add_time_step(by_s * slope_in_time(at, &mut self.fastest));
        }
    }

    /// Adds the gradient in the centres of mass about which bodies spin, where N v has weights: the origin moves with −ω × c.
    fn add_centers(&self, model: &Model, parameters: &mut [T]) {
        for (id, body) in model.independent_with_ids() {
            if body.joint.turns_with_body() {
                let [spin, weights] = [&self.v, &self.by_v].map_each(|v| body.motion(v));
                let by_center = cross(&spin.angular, &weights.linear);
                (self.sweep.slots).add_center(id, body, &by_center, parameters);
            }
        }
    }
}
