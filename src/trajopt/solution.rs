//! Solutions: what every solver gives, and what only one does.

use std::ops::Deref;

use nalgebra::DVector;

use super::lagrangian::no_multipliers;
use super::problem::Problem;
use super::trajectory::Trajectory;
use crate::minimize::Status;

/// The best trajectory that was found, with what only its solver gives, `S`, whose fields are those of the solution
/// too: `solution.gains` of [`Ddp`](super::Ddp), `solution.variables` of [`SingleShooting`](super::SingleShooting),
/// `solution.curve` of `Transcription`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Solution<S> {
    /// Termination status.
    pub status: Status,
    /// States and inputs at the nodes; inputs are within their bounds.
    pub trajectory: Trajectory,
    /// Number of steps taken or tried.
    pub iterations: usize,
    /// Cost of the trajectory, without penalties.
    pub cost: f64,
    /// Cost of the guess, then after each iteration; of single shooting the best after each, with the penalties of
    /// constraints at the multipliers of the time.
    pub cost_history: Vec<f64>,
    /// Largest violation of a constraint; zero without constraints.
    pub violation: f64,
    /// Largest gap between a step's end and the next state, of transcription the largest defect, an error of the rate
    /// ẋ; zero if the trajectory obeys the dynamics.
    pub gap: f64,
    /// Multipliers λ of the constraints of each stage, one after the other, of the last state at the end: positive
    /// where an upper bound holds back, and −λ is the rate at which the cost falls as that bound rises. Of
    /// transcription at each point of its mesh, of the entries that are bounded at all.
    pub multipliers: Vec<DVector<f64>>,
    /// Results that only this solver gives.
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
