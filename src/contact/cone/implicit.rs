//! Derivatives of the solution by the implicit function theorem.

use super::law::{Piece, equations};
use super::newton::{Newton, RIDGE};
use super::system::Kind;
use super::{ConeProblem, ConeSolver};
use crate::scalar::Scalar;

/// Pivots below this belong to redundant rows: the matrix gets the ridge, and the derivatives one more step, which takes its effect out.
const REDUNDANT: f64 = 1e-10;

impl Newton {
    /// Factorises the derivative of the equations at the solution; whether without the ridge.
    pub(super) fn factorize_at_solution(&mut self) -> bool {
        self.assemble(0.0);
        self.lu.factorize();
        let regular = self.lu.smallest > REDUNDANT;
        if !regular {
            self.assemble(RIDGE);
            self.lu.factorize();
        }
        regular
    }
}

impl<T: Scalar> ConeSolver<T> {
    /// Chord steps  f ← f − (∂e/∂f)⁻¹ e(f)  over the scalar: each makes one more order of derivatives exact. The values stay.
    pub(super) fn differentiate(&mut self, problem: &ConeProblem<'_, T>, f: &mut [T]) {
        let regular = self.search.newton.factorize_at_solution();
        let steps = if regular { T::ORDER } else { T::ORDER + 1 };
        for _ in 0..steps {
            self.velocities(problem, f);
            self.equations(problem, f);
            self.search.newton.lu.solve(&mut self.e);
            self.step(f);
        }
    }

    fn step(&self, f: &mut [T]) {
        let newton = &self.search.newton;
        for (unit, local) in newton.system.units.iter().zip(&newton.locals) {
            for i in unit.row..unit.row + unit.rows() {
                let value = f[i].value(0);
                let moved = f[i] - self.e[i] * newton.system.scale[i];
                // Rounding shall not give a contact that is open a derivative.
                f[i] = match local.piece {
                    Piece::Off => T::constant(value),
                    _ => moved - moved.value(0) + value,
                };
            }
        }
    }

    /// y = (G + diag R) f + g
    fn velocities(&mut self, problem: &ConeProblem<'_, T>, f: &[T]) {
        let n = f.len();
        let system = &self.search.newton.system;
        for i in 0..n {
            let softening = self.search.softening / (system.scale[i] * system.scale[i]);
            self.y[i] = (problem.regularization[i] + softening).mul_add(f[i], problem.offset[i]);
        }
        for (column, &f) in problem.matrix.chunks_exact(n.max(1)).zip(f) {
            for (y, &g) in self.y.iter_mut().zip(column) {
                *y = g.mul_add(f, *y);
            }
        }
    }

    /// The equations of every unit, in scaled numbers.
    fn equations(&mut self, problem: &ConeProblem<'_, T>, f: &[T]) {
        let newton = &self.search.newton;
        for (unit, local) in newton.system.units.iter().zip(&newton.locals) {
            let scale = newton.system.scale[unit.row];
            let (mut force, mut velocity) = ([T::zero(); 3], [T::zero(); 3]);
            for i in 0..unit.rows() {
                force[i] = f[unit.row + i] / scale;
                velocity[i] = self.y[unit.row + i] * scale;
            }
            let friction = problem.friction[unit.block];
            let e = equations(local.piece, force, velocity, friction, newton.kappa);
            for i in 0..unit.rows() {
                self.e[unit.row + i] = e[i] * local.weight[i];
            }
        }
    }

    /// The Jacobian of the last solution:  δf = S (δG f + δR f + δg)  at fixed friction.
    ///
    /// Of the last lane that [`solve`](Self::solve) did. No allocation.
    ///
    /// * `out` – output, S by columns, n × n
    ///
    /// # Panics
    /// If the length is wrong.
    pub fn response(&mut self, out: &mut [f64]) {
        let newton = &mut self.search.newton;
        let n = newton.system.n;
        assert_eq!(out.len(), n * n, "the response is n × n");
        newton.factorize_at_solution();
        out.fill(0.0);
        for (unit, local) in newton.system.units.iter().zip(&newton.locals) {
            for j in 0..unit.rows() {
                let column = unit.row + j;
                let out = &mut out[column * n..(column + 1) * n];
                for i in 0..unit.rows() {
                    out[unit.row + i] = -local.slopes.y[i][j] * newton.system.scale[column];
                }
            }
        }
        newton.responses(out);
    }

    /// ∂f/∂μ of the last solution, one column for each block.
    ///
    /// * `out` – output by columns, n × number of blocks; zeros for blocks that are no cones
    ///
    /// # Panics
    /// If the length is wrong.
    pub fn friction_response(&mut self, out: &mut [f64]) {
        let newton = &mut self.search.newton;
        let n = newton.system.n;
        assert_eq!(out.len(), n * self.blocks, "the response is n × blocks");
        newton.factorize_at_solution();
        out.fill(0.0);
        for (unit, local) in newton.system.units.iter().zip(&newton.locals) {
            if unit.kind == Kind::Cone {
                for i in 0..3 {
                    out[unit.block * n + unit.row + i] = -local.slopes.mu[i];
                }
            }
        }
        newton.responses(out);
    }
}

impl Newton {
    /// Every column c ← s (∂e/∂f)⁻¹ c, where the equations are −c.
    fn responses(&self, out: &mut [f64]) {
        let n = self.system.n;
        for column in out.chunks_exact_mut(n.max(1)) {
            self.lu.solve(column);
            for (f, scale) in column.iter_mut().zip(&self.system.scale) {
                *f *= scale;
            }
        }
    }
}
