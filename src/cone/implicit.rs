//! Derivatives of the solution by the implicit function theorem.

use super::law::{Piece, equations};
use super::newton::{Newton, RIDGE};
use super::system::{Kind, Unit};
use super::{ConeProblem, ConeSolver};
use crate::scalar::Scalar;

/// Pivots below this belong to redundant rows: the matrix gets the ridge, and the derivatives one more step, which takes its effect out.
const REDUNDANT: f64 = 1e-10;

impl Newton {
    /// Factorises the derivative of the equations at the solution; how many steps with it make a derivative exact.
    pub(super) fn steps_at_solution(&mut self) -> usize {
        self.assemble(0.0);
        self.lu.factorize();
        let regular = self.lu.smallest > REDUNDANT;
        if !regular {
            self.assemble(RIDGE);
            self.lu.factorize();
        }
        if regular { 1 } else { 2 }
    }
}

impl<T: Scalar> ConeSolver<T> {
    /// Chord steps  f ← f − (∂e/∂f)⁻¹ e(f)  over the scalar: each makes one more order of derivatives exact. The values stay. One step is
    /// for scalars that hold something else than derivatives.
    pub(super) fn differentiate(&mut self, problem: &ConeProblem<'_, T>, f: &mut [T]) {
        let steps = self.search.newton.steps_at_solution() - 1 + T::ORDER.max(1);
        for _ in 0..steps {
            self.velocities(problem, f);
            self.evaluate_equations(problem, f);
            self.search.newton.lu.solve(&mut self.e);
            self.step(f);
        }
    }

    fn step(&self, f: &mut [T]) {
        let newton = &self.search.newton;
        for (unit, own) in newton.system.units.iter().zip(&newton.equations) {
            for i in unit.row..unit.row + unit.rows() {
                let value = f[i].value(0);
                let moved = f[i] - self.e[i] * newton.system.scale[i];
                // Rounding shall not give a contact that is open a derivative.
                f[i] = match own.piece {
                    Piece::Separated => T::constant(value),
                    _ => moved - moved.value(0) + value,
                };
            }
        }
    }

    /// y = (G + diag R) f + g
    pub(super) fn velocities(&mut self, problem: &ConeProblem<'_, T>, f: &[T]) {
        let n = f.len();
        let system = &self.search.newton.system;
        for i in 0..n {
            let regularization = self.search.regularization / (system.scale[i] * system.scale[i]);
            self.y[i] = (problem.regularization[i] + regularization)
                .mul_add(f[i], problem.free_velocity[i]);
        }
        for (column, &f) in problem.matrix.chunks_exact(n.max(1)).zip(f) {
            for (y, &g) in self.y.iter_mut().zip(column) {
                *y = g.mul_add(f, *y);
            }
        }
    }

    /// Forces and velocities of a unit, scaled.
    pub(super) fn scaled_numbers(&self, unit: &Unit, f: &[T]) -> [[T; 3]; 2] {
        let scale = self.search.newton.system.scale[unit.row];
        let mut out = [[T::zero(); 3]; 2];
        for i in 0..unit.rows() {
            out[0][i] = f[unit.row + i] / scale;
            out[1][i] = self.y[unit.row + i] * scale;
        }
        out
    }

    /// The number of the law of a unit, scaled: μ, or the bound of an interval or of a moment.
    pub(super) fn own_number(&self, problem: &ConeProblem<'_, T>, unit: &Unit, f: &[T]) -> T {
        let (system, given) = (&self.search.newton.system, problem.friction[unit.block]);
        self.own_number_over(unit, given, || f[system.normal(unit)])
    }

    /// A number of a block in the scaled number of the law of a unit.
    ///
    /// * `normal` – the normal force of a moment
    pub(super) fn own_number_over(&self, unit: &Unit, given: T, normal: impl Fn() -> T) -> T {
        let scale = || self.search.newton.system.scale[unit.row];
        match unit.kind {
            Kind::Interval => given / scale(),
            Kind::Spin | Kind::Roll => given * normal() / scale(),
            Kind::Row | Kind::Ray | Kind::Cone => given,
        }
    }

    /// The equations of every unit, in scaled numbers.
    fn evaluate_equations(&mut self, problem: &ConeProblem<'_, T>, f: &[T]) {
        let newton = &self.search.newton;
        for (unit, own) in newton.system.units.iter().zip(&newton.equations) {
            let [force, velocity] = self.scaled_numbers(unit, f);
            let friction = self.own_number(problem, unit, f);
            let e = equations(own.piece, force, velocity, friction, newton.kappa);
            for i in 0..unit.rows() {
                self.e[unit.row + i] = e[i] * own.weight[i];
            }
        }
    }
}
