//! Solutions: results of all solvers, and those of one solver.

use std::ops::Deref;

use nalgebra::DVector;

use super::lagrangian::no_multipliers;
use super::problem::Problem;
use super::trajectory::Trajectory;
use crate::minimize::Status;

/// The best trajectory found, with the specific results `S` of its solver, which are accessible as fields of the solution: `solution.gains` of
/// [`Ddp`](super::Ddp), `solution.variables` of [`SingleShooting`](super::SingleShooting), `solution.curve` of `Transcription`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Solution<S> {
    /// Termination status.
    pub status: Status,
    /// States and inputs at the nodes; inputs are within their bounds.
    pub trajectory: Trajectory,
    /// Number of iterations.
    pub iterations: usize,
    /// Cost of the trajectory, without penalties.
    pub cost: f64,
    /// Cost of the guess, then after each iteration; for single shooting the best cost after each iteration, with the penalties of constraints at the
    /// current multipliers.
    pub cost_history: Vec<f64>,
    /// Largest violation of a constraint; zero without constraints.
    pub violation: f64,
    /// Largest gap between the end of a step and the next state, for direct collocation the largest defect, an error of the rate ẋ; zero if the
    /// trajectory satisfies the dynamics.
    pub gap: f64,
    /// Multipliers λ of the constraints, stage by stage, and last those of the final state. λ is positive at an active upper bound, and −λ is the
    /// derivative of the optimal cost in that bound. For direct collocation they are those of the bounded entries at each point of the mesh.
    pub multipliers: Vec<DVector<f64>>,
    /// Results of this solver only.
    pub own: S,
}

impl<S> Solution<S> {
    /// Makes a solution of nothing yet: the zero-input guess, and room for the costs of all iterations.
    pub(super) fn new(problem: &Problem, max_iterations: usize, own: S) -> Self {
        let stages = (0..=problem.horizon()).map(|stage| no_multipliers(problem, stage));
        Self {
            status: Status::IterationLimit,
            trajectory: Trajectory::zero_input(problem),
            iterations: 0,
            cost: 0.0,
            cost_history: Vec::with_capacity(max_iterations + 1),
            violation: 0.0,
            gap: 0.0,
            multipliers: stages.map(DVector::from_vec).collect(),
            own,
        }
    }

    /// Whether the status is [`Status::Converged`].
    pub fn is_converged(&self) -> bool {
        self.status == Status::Converged
    }
}

impl<S> Deref for Solution<S> {
    type Target = S;

    fn deref(&self) -> &S {
        &self.own
    }
}
