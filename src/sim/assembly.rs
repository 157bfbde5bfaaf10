//! Assembly of closed loops: finds a configuration and velocity that satisfy the kinematic constraints.

#![expect(
    non_snake_case,
    reason = "J, M: monogram notation, see the conventions"
)]

use nalgebra::{DMatrix, DVector};
use thiserror::Error;

use super::simulator::Simulator;
use super::state::State;
use crate::constraint::{ConstraintRow, ConstraintRows};
use crate::dynamics::{MassMatrixFactor, mass_matrix};
use crate::linalg::symmetric_eigen;
use crate::scalar::{Over, Scalar};

/// A state that satisfies the constraints.
#[derive(Clone, Debug)]
pub struct Assembly {
    /// The state.
    pub state: State,
    /// Largest remaining error, m or rad.
    pub error: f64,
    /// Number of iterations.
    pub iterations: usize,
}

/// A loop that does not close from where it starts.
#[derive(Clone, PartialEq, Error)]
#[error(
    "the constraints of \"{model}\" do not close from this configuration: {error:e} (m or rad) is left in row {row} after {iterations} steps; is it within reach, or does another start help?"
)]
pub struct AssemblyError {
    /// The robot.
    pub model: String,
    /// The row with the largest error, in the order of [`Simulator::constraint_errors`].
    pub row: usize,
    /// That error, m or rad.
    pub error: f64,
    /// Number of iterations.
    pub iterations: usize,
    /// The best configuration found.
    pub q: DVector<f64>,
}

crate::error::debug_by_message! { AssemblyError }

/// Errors that count as closed, m or rad.
const CLOSED: f64 = 1e-12;
/// Errors that are accepted where rounding allows no better ones, m or rad.
const ACCEPTED: f64 = 1e-9;
const MOST_ITERATIONS: usize = 200;
/// Longest step of a coordinate, rad or m: if a loop is far from closed, its Jacobian is valid only nearby.
const LONGEST_STEP: f64 = 0.5;
/// Initial damping relative to the largest diagonal entry of J Jᵀ, its factor of change, and its minimum.
const DAMPING: (f64, f64, f64) = (1e-3, 4.0, 1e-14);
/// Eigenvalues of J M⁻¹ Jᵀ below this part of the largest one are of redundant rows.
const REDUNDANT: f64 = 1e-10;

impl<P: Scalar> Simulator<P> {
    /// Computes the errors φ of the kinematic constraints at a state, row by row (m or rad); zero for a closed constraint. Allocates.
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn constraint_errors<T: Over<P>>(&self, state: &State<T>) -> Vec<T> {
        let rows = self.constraint_rows(state);
        rows.rows.iter().map(|row| row.error).collect()
    }

    fn constraint_rows<T: Over<P>>(&self, state: &State<T>) -> ConstraintRows<T> {
        self.check(state);
        let mut rows = ConstraintRows::new(self.bilateral_rows(), self.model().nv());
        let at = (state.q.as_slice(), state.v.as_slice());
        let dt = T::from(self.time_step());
        rows.evaluate(self.model(), self.constraints(), at.0, at.1, dt);
        rows
    }
}

impl Simulator<f64> {
    /// Closes the kinematic constraints, except those that are [springs](crate::constraint::Constraint::with_spring). Returns a nearby configuration
    /// that satisfies them, and the velocity that satisfies them with the least change of kinetic energy, v − M⁻¹ Jᵀ (J M⁻¹ Jᵀ)⁺ J v. Allocates.
    ///
    /// Uses Levenberg–Marquardt steps on the configuration manifold, q ⊕ −Jᵀ (J Jᵀ + λ)⁻¹ φ; redundant rows are allowed. Joint limits are ignored.
    ///
    /// # Errors
    /// If an error above 1e-9 remains: the loop cannot be closed, or not from this start.
    ///
    /// # Panics
    /// If the state has the wrong length.
    ///
    /// # References
    /// [Marquardt 1963].
    pub fn assemble(&self, state: &State) -> Result<Assembly, AssemblyError> {
        let mut state = state.clone();
        let mut iterations = 0;
        let (mut damping, factor, least) = DAMPING;
        let mut errors = self.open_errors(&state);
        while largest(&errors).1 > CLOSED && iterations < MOST_ITERATIONS {
            iterations += 1;
            let trial = self.nearer(&state, &errors, damping);
            let now = self.open_errors(&trial);
            if square(&now) < square(&errors) {
                (state, errors) = (trial, now);
                damping = (damping / factor).max(least);
            } else {
                damping *= factor;
            }
        }
        let (row, error) = largest(&errors);
        if error.is_nan() || error > ACCEPTED {
            return Err(AssemblyError {
                model: self.model().name().into(),
                row,
                error,
                iterations,
                q: state.q,
            });
        }
        self.project_velocity(&mut state);
        Ok(Assembly {
            state,
            error,
            iterations,
        })
    }

    /// q ⊕ −Jᵀ (J Jᵀ + λ s)⁻¹ φ with the largest diagonal entry s of J Jᵀ, no coordinate further than the longest step.
    fn nearer(&self, state: &State, errors: &[f64], damping: f64) -> State {
        let J = self.constraint_jacobian(state);
        let mut square = &J * J.transpose();
        let ridge = damping * square.diagonal().amax().max(f64::MIN_POSITIVE);
        for k in 0..errors.len() {
            square[(k, k)] += ridge;
        }
        let phi = DVector::from_column_slice(errors);
        let multipliers = square
            .cholesky()
            .map_or(phi.clone() * 0.0, |f| f.solve(&phi));
        let mut step = -(J.transpose() * multipliers);
        let longest = step.amax();
        if longest > LONGEST_STEP {
            step *= LONGEST_STEP / longest;
        }
        State {
            q: self.model().integrate(state.q.as_slice(), step.as_slice()),
            ..state.clone()
        }
    }

    /// Errors of the rows that are to be closed, zero for springs.
    fn open_errors(&self, state: &State) -> Vec<f64> {
        let rows = self.constraint_rows(state).rows;
        let error = |row: &ConstraintRow<f64>| if row.is_closed() { row.error } else { 0.0 };
        rows.iter().map(error).collect()
    }

    /// J, with rows of zeros for springs.
    fn constraint_jacobian(&self, state: &State) -> DMatrix<f64> {
        let rows = self.constraint_rows(state);
        let mut out = DMatrix::from_row_slice(rows.rows.len(), self.model().nv(), &rows.jacobian);
        for (row, mut entries) in rows.rows.iter().zip(out.row_iter_mut()) {
            if !row.is_closed() {
                entries.fill(0.0);
            }
        }
        out
    }

    fn project_velocity(&self, state: &mut State) {
        let J = self.constraint_jacobian(state);
        let M = mass_matrix(self.model(), state.q.as_slice());
        let factor = MassMatrixFactor::new(self.model(), &M);
        let mut response = J.transpose();
        for mut column in response.column_iter_mut() {
            factor.solve(column.as_mut_slice());
        }
        let (G, violation) = (&J * &response, &J * &state.v);
        let Some((values, axes)) = symmetric_eigen(G) else {
            return;
        };
        let smallest = REDUNDANT * values.amax();
        let along = axes.tr_mul(&violation);
        let solved = along.zip_map(
            &values,
            |x, value| {
                if value > smallest { x / value } else { 0.0 }
            },
        );
        state.v -= response * (axes * solved);
    }
}

/// The row with the largest error, and its size; NaN counts as largest.
fn largest(errors: &[f64]) -> (usize, f64) {
    let sizes = errors.iter().map(|error| error.abs()).enumerate();
    sizes.fold((0, 0.0), |best, next| {
        if next.1 > best.1 || next.1.is_nan() {
            next
        } else {
            best
        }
    })
}

fn square(errors: &[f64]) -> f64 {
    errors.iter().map(|error| error * error).sum()
}
