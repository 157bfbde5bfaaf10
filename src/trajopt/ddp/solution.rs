//! Solution of differential dynamic programming, and its progress.

use nalgebra::{DMatrix, DVector};

use crate::trajopt::dynamics::Dynamics;
use crate::trajopt::problem::Problem;
use crate::trajopt::status::Status;
use crate::trajopt::trajectory::Trajectory;

/// One iteration, for a callback.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// The iteration, from 1.
    pub iteration: usize,
    /// Cost of the trajectory, without penalties.
    pub cost: f64,
    /// The share of the step that was taken; zero if none was.
    pub step: f64,
    /// The change that was expected of the whole step; negative is better.
    pub expected: f64,
    /// Regularisation of the input Hessian.
    pub regularization: f64,
    /// Largest gap between a step's end and the next state.
    pub gap: f64,
    /// Largest violation of a constraint.
    pub violation: f64,
}

/// A trajectory with the policy along it:  u = ū − K (x ⊖ x̄).
#[derive(Clone, Debug)]
pub struct DdpSolution {
    /// Termination status.
    pub status: Status,
    /// x̄ and ū. Inputs are within their bounds.
    pub trajectory: Trajectory,
    /// K of every stage, `nu` × `ndx`; rows of inputs at a bound are zero if the trajectory obeys the dynamics.
    pub gains: Vec<DMatrix<f64>>,
    /// Number of steps taken or tried.
    pub iterations: usize,
    /// Cost of the trajectory, without penalties.
    pub cost: f64,
    /// Cost of the guess, then after each iteration.
    pub cost_history: Vec<f64>,
    /// Largest violation of a constraint; zero without constraints.
    pub violation: f64,
    /// Largest gap between a step's end and the next state; zero if the trajectory obeys the dynamics.
    pub gap: f64,
}

impl DdpSolution {
    pub(super) fn new<D: Dynamics>(problem: &Problem<D>, max_iterations: usize) -> Self {
        let (n, ndx, nu) = (
            problem.horizon(),
            problem.dynamics().ndx(),
            problem.dynamics().nu(),
        );
        Self {
            status: Status::IterationLimit,
            trajectory: Trajectory::resting(problem),
            gains: vec![DMatrix::zeros(nu, ndx); n],
            iterations: 0,
            cost: 0.0,
            cost_history: Vec::with_capacity(max_iterations + 1),
            violation: 0.0,
            gap: 0.0,
        }
    }

    /// Whether it converged.
    pub fn is_converged(&self) -> bool {
        self.status == Status::Converged
    }

    /// The input  ū − K (x ⊖ x̄)  of a stage within the problem's bounds: feedback around the trajectory. Allocates.
    ///
    /// * `x` – state, length `nx`
    ///
    /// # Panics
    /// If there is no such stage, or if `x` has the wrong length.
    pub fn control<D: Dynamics>(
        &self,
        problem: &Problem<D>,
        stage: usize,
        x: &[f64],
    ) -> DVector<f64> {
        let mut dx = DVector::zeros(problem.dynamics().ndx());
        let planned = self.trajectory.states[stage].as_slice();
        problem.dynamics().difference(planned, x, dx.as_mut_slice());
        let mut u = &self.trajectory.inputs[stage] - &self.gains[stage] * dx;
        problem.clamp_input(u.as_mut_slice());
        u
    }
}
