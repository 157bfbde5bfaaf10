//! The sensitivity of the solution, transposed: from weights of the forces to weights of the problem's data.
//!
//! The equations e(f, y, μ) = 0 with y = W f + g give, in scaled numbers,  (∂e/∂f + ∂e/∂y W) δf = −∂e/∂y δg − ∂e/∂μ δμ. So weights λ of the forces
//! become  −(∂e/∂y)ᵀ z of g and −(∂e/∂μ)ᵀ z of μ, where  (∂e/∂f + ∂e/∂y W)ᵀ z = λ: one solution for any number of rows. Over a scalar with
//! derivatives the factors are those of the values, and each further step makes one more order of z exact.

use super::jacobian::{EquationJacobian, jacobian_of};
use super::law::Piece;
use super::system::{Kind, Unit};
use super::{ConeProblem, ConeSolver};
use crate::scalar::{MapEach, Scalar};

/// Working memory.
#[derive(Clone, Debug)]
pub(super) struct Transposed<T> {
    /// Of the equations of each unit.
    pub(super) jacobians: Vec<EquationJacobian<T>>,
    /// W′ by columns, for the sensitivity that is not transposed.
    pub(super) matrix: Vec<T>,
    /// z.
    z: Vec<T>,
    /// s (∂e/∂y)ᵀ z.
    by_velocity: Vec<T>,
}

impl<T: Scalar> Transposed<T> {
    pub(super) fn new(rows: usize) -> Self {
        Self {
            jacobians: Vec::with_capacity(rows),
            matrix: Vec::new(),
            z: Vec::with_capacity(rows),
            by_velocity: Vec::with_capacity(rows),
        }
    }

    /// s (∂e/∂y)ᵀ z of every unit.
    fn find_by_velocity(&mut self, units: &[Unit], scale: &[f64]) {
        for (unit, own) in units.iter().zip(&self.jacobians) {
            let rows = unit.row..unit.row + unit.rows();
            for (j, row) in rows.clone().enumerate() {
                let z = self.z[rows.clone()].iter().zip(&own.y);
                let sum = z.fold(T::zero(), |sum, (&z, slopes)| sum + z * slopes[j]);
                self.by_velocity[row] = sum * scale[row];
            }
        }
    }

    /// −(∂e/∂μ)ᵀ z of a unit.
    fn by_own_number(&self, unit: &Unit, slopes: &[T; 3]) -> T {
        let z = self.z[unit.row..][..unit.rows()].iter().zip(slopes);
        z.fold(T::zero(), |sum, (&z, &slope)| sum - z * slope)
    }
}

impl<T: Scalar> ConeSolver<T> {
    /// Turns weights of the forces of the last solution into those of the velocities g, Sᵀ λ.
    ///
    /// * `f` – the forces of that solution
    /// * `by_friction` – output, the weights of the friction, or the bound, of each block; empty if they are not needed
    pub(crate) fn respond_transposed(
        &mut self,
        problem: &ConeProblem<'_, T>,
        f: &[T],
        weights: &mut [T],
        by_friction: &mut [T],
    ) {
        let steps = self.search.newton.steps_at_solution() + T::ORDER;
        self.velocities(problem, f);
        self.linearize_equations(problem, f);
        let scaled = weights.iter_mut().zip(&self.search.newton.system.scale);
        scaled.for_each(|(weight, &scale)| *weight = *weight * scale);
        self.solve_transposed(problem, weights, steps);
        let (system, own) = (&self.search.newton.system, &mut self.transposed);
        own.find_by_velocity(&system.units, &system.scale);
        let out = weights.iter_mut().zip(&own.by_velocity);
        out.for_each(|(out, &x)| *out = -x);
        self.find_by_friction(f, by_friction);
    }

    /// Weights of the friction of every cone, of the bound of every interval and of the number of every moment, as far as there is memory for them.
    fn find_by_friction(&self, f: &[T], out: &mut [T]) {
        let (system, own) = (&self.search.newton.system, &self.transposed);
        for (unit, jacobian) in system.units.iter().zip(&own.jacobians) {
            let has_number = !matches!(unit.kind, Kind::Row | Kind::Ray);
            if let Some(out) = out.get_mut(unit.block).filter(|_| has_number) {
                let sum = own.by_own_number(unit, &jacobian.mu);
                *out = self.own_number_over(unit, sum, || f[system.normal(unit)]);
            }
        }
    }

    /// Finds z of scaled weights by so many steps.
    fn solve_transposed(&mut self, problem: &ConeProblem<'_, T>, weights: &[T], steps: usize) {
        let own = &mut self.transposed;
        for x in [&mut own.z, &mut own.by_velocity] {
            x.clear();
            x.resize(weights.len(), T::zero());
        }
        for step in 0..steps {
            self.e.copy_from_slice(weights);
            // At the first z is still zero.
            if step > 0 {
                self.subtract_product(problem);
            }
            self.search.newton.lu.solve_transposed(&mut self.e);
            let z = self.transposed.z.iter_mut().zip(&self.e);
            z.for_each(|(z, &e)| *z += e);
        }
    }

    /// The derivatives of the equations of every unit, with their weights, at the forces and the velocities that have been found.
    pub(super) fn linearize_equations(&mut self, problem: &ConeProblem<'_, T>, f: &[T]) {
        let mut jacobians = std::mem::take(&mut self.transposed.jacobians);
        let newton = &self.search.newton;
        jacobians.clear();
        for (unit, own) in newton.system.units.iter().zip(&newton.equations) {
            let [force, velocity] = self.scaled_numbers(unit, f);
            let friction = self.own_number(problem, unit, f);
            let mut out = jacobian_of(own.piece, force, velocity, friction, newton.kappa);
            for (i, &weight) in own.weight.iter().enumerate() {
                out.f[i] = out.f[i].map_each(|x| x * weight);
                out.y[i] = out.y[i].map_each(|x| x * weight);
                out.mu[i] = out.mu[i] * weight;
            }
            jacobians.push(out);
        }
        self.transposed.jacobians = jacobians;
    }

    /// Takes (∂e/∂f + ∂e/∂y W)ᵀ z from the values in `e`. Rows without a force have no weight: their velocities may be without bounds.
    fn subtract_product(&mut self, problem: &ConeProblem<'_, T>) {
        let (newton, own) = (&self.search.newton, &mut self.transposed);
        let (system, n) = (&newton.system, own.z.len());
        own.find_by_velocity(&system.units, &system.scale);
        let all = system.units.iter().zip(&newton.equations);
        for ((unit, equations), jacobian) in all.zip(&own.jacobians) {
            let rows = unit.row..unit.row + unit.rows();
            if equations.piece == Piece::Separated {
                self.e[rows].fill(T::zero());
                continue;
            }
            for (j, row) in rows.clone().enumerate() {
                let z = own.z[rows.clone()].iter().zip(&jacobian.f);
                let by_force = z.fold(T::zero(), |sum, (&z, slopes)| sum + z * slopes[j]);
                let scale = system.scale[row];
                let regularization = self.search.regularization / (scale * scale);
                let given = problem.regularization[row] + regularization;
                let column = problem.matrix[n * row..n * (row + 1)].iter();
                let pairs = column.zip(&own.by_velocity);
                let beside = given * own.by_velocity[row];
                let by_velocity = pairs.fold(beside, |sum, (&w, &x)| w.mul_add(x, sum));
                self.e[row] -= by_force + by_velocity * scale;
            }
        }
        for k in 0..self.transposed.jacobians.len() {
            self.subtract_by_normal(problem, k);
        }
    }

    /// The part of the normal force that bounds a moment.
    fn subtract_by_normal(&mut self, problem: &ConeProblem<'_, T>, k: usize) {
        let newton = &self.search.newton;
        let (system, unit) = (&newton.system, &newton.system.units[k]);
        if newton.equations[k].piece == Piece::Turning {
            let (normal, given) = (system.normal(unit), problem.friction[unit.block]);
            let by_bound = (self.transposed).by_own_number(unit, &self.transposed.jacobians[k].mu);
            let scale = T::constant(system.scale[normal]);
            let change = self.own_number_over(unit, by_bound * given, || scale);
            self.e[normal] += change;
        }
    }
}
