//! The sensitivity of the solution: changes of forces by changes of velocities.
//!
//! The equations e(f, y) = 0 with y = W f + g give, in scaled numbers,  (∂e/∂f + ∂e/∂y W) δf = −∂e/∂y δg. Over a scalar with derivatives the
//! factors are those of the values, and each further step makes one more order of δf exact.

use super::jacobian::EquationJacobian;
use super::law::Piece;
use super::newton::Newton;
use super::system::Unit;
use super::{ConeProblem, ConeSolver};
use crate::nested::IntoNested;
use crate::scalar::{Linear, Scalar, is_more_than_values};

/// The equations about a solution to first order, in scaled numbers.
struct Derivatives<'a, P> {
    newton: &'a Newton,
    /// Derivatives of the equations of a unit.
    jacobians: &'a [EquationJacobian<P>],
    /// W′ by columns; none where one step is enough.
    w: &'a [P],
    /// Numbers of the blocks.
    friction: &'a [P],
    /// Chord steps that make a change exact.
    steps: usize,
}

impl<P: Scalar> Derivatives<'_, P> {
    /// δy ← δf by chord steps on  ∂e/∂f δf + ∂e/∂y (W δf + δy) = 0.
    #[inline(always)]
    fn apply<S: Linear<P>>(&self, change: &mut [S], memory: &mut [S]) {
        let system = &self.newton.system;
        let n = system.n;
        assert_eq!(change.len(), n, "a change of each velocity");
        let (f, e) = memory.split_at_mut(n);
        f.fill(S::zero());
        for step in 0..self.steps {
            let given = change.iter().zip(&system.scale);
            let start = e.iter_mut().zip(given);
            start.for_each(|(e, (&y, &scale))| *e = y * P::from(scale));
            // At the first step the forces are still zero.
            let columns = self.w.chunks_exact(n.max(1)).zip(&*f);
            for (column, &f) in columns.take(if step == 0 { 0 } else { n }) {
                for i in 0..n {
                    e[i] = f.times_plus(column[i], e[i]);
                }
            }
            self.equation_changes(f, e);
            self.newton.lu.solve_over::<P, S>(e);
            f.iter_mut().zip(&*e).for_each(|(f, &e)| *f -= e);
        }
        let scaled = f.iter().zip(&system.scale);
        let out = change.iter_mut().zip(scaled);
        out.for_each(|(out, (&f, &scale))| *out = f * P::from(scale));
    }

    /// δy ← ∂e/∂f δf + ∂e/∂y δy, unit by unit.
    #[inline(always)]
    fn equation_changes<S: Linear<P>>(&self, all: &[S], y: &mut [S]) {
        for (i, unit) in self.newton.system.units.iter().enumerate() {
            let (rows, own) = (unit.row..unit.row + unit.rows(), &self.jacobians[i]);
            let (f, y) = (&all[rows.clone()], &mut y[rows]);
            let mut e = [S::zero(); 3];
            for (i, e) in e.iter_mut().enumerate().take(f.len()) {
                for j in 0..f.len() {
                    *e = f[j].times_plus(own.f[i][j], *e);
                    *e = y[j].times_plus(own.y[i][j], *e);
                }
            }
            if self.newton.equations[i].piece == Piece::Turning {
                let (normal, by_force) = self.bound_by_normal(unit);
                let bounds = e.iter_mut().zip(own.mu);
                bounds.for_each(|(e, slope)| *e = all[normal].times_plus(slope * by_force, *e));
            }
            y.copy_from_slice(&e[..f.len()]);
        }
    }

    /// Row of the normal force that bounds a moment, and the bound beside it.
    fn bound_by_normal(&self, unit: &Unit) -> (usize, P) {
        let system = &self.newton.system;
        let normal = system.normal(unit);
        let scale = system.scale[normal] / system.scale[unit.row];
        (normal, self.friction[unit.block] * scale)
    }
}

impl<T: Scalar> ConeSolver<T> {
    /// Turns each change of the velocities, δy = δG f + δR f + δg of length n, into that of the forces, S δy; several at once over lanes.
    ///
    /// * `problem`, `f` – the last problem, and its forces
    /// * `memory` – working memory, of length 2 n at least
    ///
    /// # Panics
    /// If the scalar has lanes, of which only the last solution is there, or no values.
    pub(crate) fn apply_sensitivity<'x, S: Linear<T>>(
        &mut self,
        problem: &ConeProblem<'_, T>,
        f: &[T],
        changes: impl Iterator<Item = &'x mut [S]>,
        memory: &mut [S],
    ) {
        assert!(
            T::LANES == 1 && T::HAS_VALUES,
            "the sensitivity of forces that a solver finds is that of one solution, and follows from its values"
        );
        let steps = self.search.newton.steps_at_solution() + T::ORDER;
        self.find_slopes(problem, f, steps > 1);
        let (newton, own) = (&self.search.newton, &self.transposed);
        let memory = &mut memory[..2 * newton.system.n];
        let slopes = Derivatives {
            newton,
            jacobians: &own.jacobians,
            w: &own.matrix,
            friction: problem.friction,
            steps,
        };
        S::vectorized(
            #[inline(always)]
            || {
                for change in changes {
                    slopes.apply(change, memory);
                }
            },
        );
    }

    /// The derivatives of the equations of every unit, and, where it is needed, W′.
    fn find_slopes(&mut self, problem: &ConeProblem<'_, T>, f: &[T], needs_matrix: bool) {
        if is_more_than_values::<T>() {
            self.velocities(problem, f);
            self.linearize_equations(problem, f);
            self.scale_matrix(problem);
            return;
        }
        let (newton, own) = (&self.search.newton, &mut self.transposed);
        let jacobians = newton.equations.iter().map(|own| own.jacobian.cast());
        own.jacobians.clear();
        own.jacobians
            .extend(jacobians.take(newton.system.units.len()));
        own.matrix.clear();
        if needs_matrix {
            own.matrix
                .extend(newton.system.w.iter().map(|&w| T::from(w)));
        }
    }

    /// W′ with all parts of its scalars; units that give way without a force do not couple to others.
    fn scale_matrix(&mut self, problem: &ConeProblem<'_, T>) {
        let (system, out) = (&self.search.newton.system, &mut self.transposed.matrix);
        let n = system.n;
        out.clear();
        out.resize(n * n, T::zero());
        for (of, other) in system.units.iter().nested(|of| {
            let others = system.units.iter();
            others.map(move |other| (of, other))
        }) {
            if of.absent || other.absent {
                continue;
            }
            for j in of.row..of.row + of.rows() {
                for i in other.row..other.row + other.rows() {
                    let scale = system.scale[i] * system.scale[j];
                    out[n * j + i] = problem.matrix[n * j + i] * scale;
                }
            }
        }
        for unit in &system.units {
            for i in unit.row..unit.row + unit.rows() {
                let own = &mut out[i * (n + 1)];
                if unit.absent {
                    *own = T::one();
                } else {
                    let scale = system.scale[i] * system.scale[i];
                    let given = problem.regularization[i] * scale;
                    *own += given + self.search.regularization;
                }
            }
        }
    }
}
