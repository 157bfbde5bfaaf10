//! The solution of differential dynamic programming: a trajectory with a feedback policy.

use nalgebra::{DMatrix, DVector};

use crate::trajopt::problem::Problem;
use crate::trajopt::solution::Solution;

/// A trajectory with its feedback policy u = ū − K (x ⊖ x̄).
pub type DdpSolution = Solution<Policy>;

/// The feedback policy u = ū − K (x ⊖ x̄) along a trajectory.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Policy {
    /// K of each stage, `nu` × `ndx`; rows of inputs at a bound are zero if the trajectory satisfies the dynamics.
    pub gains: Vec<DMatrix<f64>>,
}

impl Policy {
    pub(super) fn zeros(problem: &Problem) -> Self {
        let (ndx, nu) = (problem.dynamics().ndx(), problem.dynamics().nu());
        Self {
            gains: vec![DMatrix::zeros(nu, ndx); problem.horizon()],
        }
    }
}

impl Solution<Policy> {
    /// Computes the input ū − K (x ⊖ x̄) of a stage, clamped to the bounds of the problem. Allocates.
    ///
    /// * `x` – state, length `nx`
    ///
    /// # Panics
    /// If there is no such stage, or if `x` has the wrong length.
    pub fn control(&self, problem: &Problem, stage: usize, x: &[f64]) -> DVector<f64> {
        let mut dx = DVector::zeros(problem.dynamics().ndx());
        let planned = self.trajectory.states[stage].as_slice();
        problem.dynamics().difference(planned, x, dx.as_mut_slice());
        let mut u = &self.trajectory.inputs[stage] - &self.gains[stage] * dx;
        problem.clamp_input(u.as_mut_slice());
        u
    }
}
