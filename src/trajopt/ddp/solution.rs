//! The solution of differential dynamic programming: a trajectory with feedback along it.

use nalgebra::{DMatrix, DVector};

use crate::trajopt::problem::Problem;
use crate::trajopt::solution::Solution;

/// A trajectory with the policy along it:  u = ū − K (x ⊖ x̄).
pub type DdpSolution = Solution<Policy>;

/// The feedback along a trajectory,  u = ū − K (x ⊖ x̄).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Policy {
    /// K of every stage, `nu` × `ndx`; rows of inputs at a bound are zero if the trajectory obeys the dynamics.
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
    /// The input  ū − K (x ⊖ x̄)  of a stage within the problem's bounds: feedback around the trajectory. Allocates.
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
