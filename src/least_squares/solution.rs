//! Results of the solver.

use std::fmt;

use nalgebra::DMatrix;

/// Termination status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// The gradient is zero to first order, or the cost no longer changes.
    Converged,
    /// All iterations were used; the variables are the best so far.
    IterationLimit,
    /// No step reduces the cost, although the gradient is not zero: the Jacobian is wrong, or residuals are nonsmooth or noisy.
    Stalled,
    /// A [`StopSignal`](crate::StopSignal) was set; the variables are the best so far.
    Stopped,
    /// Residuals or their Jacobian are not finite at the start, or at the last point.
    Diverged,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Converged => "converged",
            Self::IterationLimit => "all iterations used",
            Self::Stalled => "no step lowers the cost",
            Self::Stopped => "stopped by a signal",
            Self::Diverged => "residuals or Jacobian are not finite",
        })
    }
}

/// An iteration, for reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iteration {
    /// Number of the iteration, from 1.
    pub iteration: usize,
    /// ½ Σ ρ(r²) after it.
    pub cost: f64,
    /// Largest cosine between the residuals and a column of their Jacobian, before it.
    pub gradient: f64,
    /// λ of the step.
    pub damping: f64,
}

/// Result of [`solve`](super::solve): the best point found, and the course of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Termination status.
    pub status: Status,
    /// Variables.
    pub x: Vec<f64>,
    /// Residuals there.
    pub residuals: Vec<f64>,
    /// ½ Σ ρ(r²) there.
    pub cost: f64,
    /// Number of iterations.
    pub iterations: usize,
    /// Cost of the start, then after each iteration.
    pub history: Vec<f64>,
    /// Directions with an active bound.
    pub held: Vec<usize>,
    /// Jᵀ W J with the weights of the loss, directions × directions.
    pub normal_matrix: DMatrix<f64>,
}

/// Error of an entry of a matrix of unit diagonal that is a sum of products, for each row: where a direction changes the residuals by next to nothing, as
/// one that only a weak regularisation holds, the matrix may be indefinite by so much, and the direction counts as if it changed them by that.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

impl Solution {
    /// Whether the status is [`Status::Converged`].
    pub fn is_converged(&self) -> bool {
        self.status == Status::Converged
    }

    /// Variance of a residual, 2 cost / (m − n), for m residuals and n directions without an active bound; `None` unless m > n.
    pub fn variance(&self) -> Option<f64> {
        let free = self.normal_matrix.nrows() - self.held.len();
        let redundant = self.residuals.len().checked_sub(free)?;
        (redundant > 0).then(|| 2.0 * self.cost / redundant as f64)
    }

    /// Covariance of the variables, σ² (Jᵀ W J)⁻¹ with the [variance](Self::variance) of the residuals; rows and columns of directions with an active
    /// bound are zero.
    ///
    /// To first order, for residuals with independent errors of equal size. `None` if there are not more residuals than directions, or if some
    /// direction does not change the residuals.
    ///
    /// # References
    /// [Bard 1974, section 7.5].
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        let variance = self.variance()?;
        let n = self.normal_matrix.nrows();
        let free: Vec<usize> = (0..n).filter(|i| !self.held.contains(i)).collect();
        let entry = |i: usize, j: usize| self.normal_matrix[(free[i], free[j])];
        // Of unit diagonal, so that units do not decide what is singular.
        let scale: Vec<f64> = (0..free.len())
            .map(|i| entry(i, i).sqrt().recip())
            .collect();
        let scaled = DMatrix::from_fn(free.len(), free.len(), |i, j| {
            entry(i, j) * scale[i] * scale[j]
        });
        let ridge = ROUNDING * free.len() as f64;
        let softened = || DMatrix::from_diagonal_element(free.len(), free.len(), ridge) + &scaled;
        let factor = scaled.clone().cholesky();
        let inverse = factor.or_else(|| softened().cholesky())?.inverse();
        let mut out = DMatrix::zeros(n, n);
        for (i, &row) in free.iter().enumerate() {
            for (j, &column) in free.iter().enumerate() {
                out[(row, column)] = variance * inverse[(i, j)] * scale[i] * scale[j];
            }
        }
        out.iter().all(|x| x.is_finite()).then_some(out)
    }
}
