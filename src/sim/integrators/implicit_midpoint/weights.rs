//! Weights of what a step goes through, backwards.

use nalgebra::DMatrix;

use super::held::add_rows;
use super::joint::{add_transposed, apply_transposed};
use super::pushforward::TakenStep;
use crate::linalg::product::dot;
use crate::scalar::{Differentiable, Scalar};
use crate::sim::simulator::Simulator;
use crate::sim::terms::StepGradientSum;

/// Weights of the intermediate quantities of a step.
#[derive(Clone, Debug)]
pub(super) struct Weights<T> {
    /// Of the position of the end.
    end_q: Vec<T>,
    /// y, that of the momentum of the end.
    pub(super) end_p: Vec<T>,
    /// w, of the residual, or of ξ; α is the same.
    pub(super) residual: Vec<T>,
    /// β, of the force of the middle.
    pub(super) force: Vec<T>,
    /// Of the impulse where it goes into the momentum of the end.
    impulse: Vec<T>,
    /// π, of the momentum of the start.
    pub(super) p: Vec<T>,
    /// Of the position of the middle.
    q: Vec<T>,
    /// Of the errors of constraints at the end, and, with the other sign, of the velocity across them there.
    pub(super) errors: Vec<T>,
    pub(super) rates: Vec<T>,
}

impl<T: Differentiable> Weights<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let zeros = || vec![T::zero(); simulator.model().nv()];
        let rows = || vec![T::zero(); simulator.bilateral_rows()];
        Self {
            end_q: zeros(),
            end_p: zeros(),
            residual: zeros(),
            force: zeros(),
            impulse: zeros(),
            p: zeros(),
            q: zeros(),
            errors: rows(),
            rates: rows(),
        }
    }

    /// Those of the end, and those of ξ.
    pub(super) fn start(&mut self, taken: &TakenStep<T>, adjoint: &[T], dt: f64) {
        let (by_q, by_v) = adjoint.split_at(self.p.len());
        self.end_p.copy_from_slice(by_v);
        self.rates.fill(T::zero());
        let end = &taken.point().end;
        end.solve_transposed(&mut self.end_p, &mut self.rates);
        self.end_q.fill(T::zero());
        plus_transposed(&taken.end.momentum_by_q, &self.end_p, &mut self.end_q);
        plus_transposed(&taken.held.rate_by_q, &self.rates, &mut self.end_q);
        let both = self.end_q.iter_mut().zip(by_q);
        both.for_each(|(out, &by_q)| *out = by_q - *out);
        self.impulse.copy_from_slice(&self.end_p);
        self.p.copy_from_slice(&self.end_p);
        let xi = &mut self.residual;
        let scaled = xi.iter_mut().zip(&self.end_q);
        scaled.for_each(|(out, &x)| *out = x * dt);
        for own in &taken.middle.joints {
            let range = own.range();
            let xi = &mut xi[range.clone()];
            xi.fill(T::zero());
            add_transposed(&own.end[1], &self.end_q[range.clone()], xi);
            add_transposed(&own.end_momentum, &self.end_p[range.clone()], xi);
            apply_transposed(&own.carry, &mut self.impulse[range.clone()]);
            let p = &mut self.p[range.clone()];
            p.copy_from_slice(&self.impulse[range]);
            apply_transposed(&own.carry, p);
        }
    }

    /// Those of the residual, and of all that it depends on.
    pub(super) fn find(&mut self, taken: &TakenStep<T>, dt: f64) {
        let middle = &taken.middle;
        let [by_q, by_v, _] = &middle.force_by;
        let impulse = self.impulse.iter();
        (self.force.iter_mut().zip(impulse)).for_each(|(out, &x)| *out = x * dt);
        // Through the force at the end: ξ is its velocity, and moves its position.
        let (q, xi) = (&mut self.q, &mut self.residual);
        q.fill(T::zero());
        plus_transposed(by_q, &self.force, q);
        plus_transposed(by_v, &self.force, xi);
        let vectors = middle.vectors.iter();
        vectors.for_each(|&k| xi[k] += q[k] * (0.5 * dt));
        for own in &middle.joints {
            add_transposed(&own.middle[1], &q[own.range()], &mut xi[own.range()]);
        }
        let held = &taken.point().held;
        let rows = held.start.jacobian.chunks_exact(self.p.len().max(1));
        let by_impulses = rows.map(|row| dot(row, &self.p));
        let errors = self.errors.iter_mut().zip(by_impulses);
        errors.for_each(|(out, x)| *out = x);
        middle.saddle.solve_transposed(xi, &mut self.errors);
        let all = xi.iter_mut().chain(&mut self.errors);
        all.for_each(|x| *x = -*x);
        add_rows(&held.end, &self.errors, &mut self.end_q);
        self.take_residual(taken, dt);
    }

    /// Adds what the residual μ − (dexp 2φ)ᵀ p − (dexp φ)ᵀ ½ Δt f takes.
    fn take_residual(&mut self, taken: &TakenStep<T>, dt: f64) {
        let middle = &taken.middle;
        // Of half of the impulse, less its sign, in the place of the position's.
        self.q.copy_from_slice(&self.residual);
        for own in &middle.joints {
            apply_transposed(&own.momentum[1], &mut self.q[own.range()]);
        }
        for (k, &x) in self.q.iter().enumerate() {
            self.force[k] -= x * (0.5 * dt);
            self.p[k] -= x;
        }
        for own in &middle.joints {
            let range = own.range();
            let (x, p) = (&mut self.q[range.clone()], &mut self.p[range]);
            // ½ (1 + A) in place of 1.
            p.iter_mut().zip(&*x).for_each(|(p, &x)| *p += x * 0.5);
            apply_transposed(&own.carry, x);
            p.iter_mut().zip(&*x).for_each(|(p, &x)| *p -= x * 0.5);
        }
        let [by_q, ..] = &middle.force_by;
        self.q.fill(T::zero());
        plus_transposed(by_q, &self.force, &mut self.q);
        plus_transposed(&middle.kinetic.momentum_by_q, &self.residual, &mut self.q);
    }

    /// Adds the gradient in state and input.
    pub(super) fn add_state(&self, taken: &TakenStep<T>, out: &mut StepGradientSum<'_, T>) {
        let (start, middle) = (&taken.start, &taken.middle);
        plus_transposed(&start.momentum_by_q, &self.p, out.q);
        plus_transposed(&start.mass, &self.p, out.v);
        plus_transposed(&middle.force_by[2], &self.force, out.u);
        let vectors = middle.vectors.iter();
        vectors.for_each(|&k| out.q[k] += self.q[k] + self.end_q[k]);
        for own in &middle.joints {
            let range = own.range();
            let by_q = &mut out.q[range.clone()];
            add_transposed(&own.middle[0], &self.q[range.clone()], by_q);
            add_transposed(&own.end[0], &self.end_q[range.clone()], by_q);
        }
    }

    /// Derivative in the time step, of which this may be a part: at fixed Δt ξ it makes the velocity of the middle slower, and the impulse of its force larger.
    pub(super) fn by_time_step(&self, taken: &TakenStep<T>, dt: f64) -> T {
        let (point, middle) = (taken.point(), &taken.middle);
        let slower = |by: &DMatrix<T>, weights: &[T]| {
            let n = by.nrows().max(1);
            let columns = by.as_slice().chunks_exact(n).zip(&point.xi);
            columns.fold(T::zero(), |sum, (column, &xi)| {
                sum + dot(column, weights) * xi
            })
        };
        let [_, by_v, _] = &middle.force_by;
        let by_velocity = slower(by_v, &self.force) + slower(&middle.kinetic.mass, &self.residual);
        (dot(&self.force, &point.force) - by_velocity) * (1.0 / dt)
    }
}

/// out += mᵀ x
fn plus_transposed<T: Scalar>(m: &DMatrix<T>, x: &[T], out: &mut [T]) {
    let columns = m.as_slice().chunks_exact(x.len().max(1));
    out.iter_mut()
        .zip(columns)
        .for_each(|(out, column)| *out += dot(column, x));
}
