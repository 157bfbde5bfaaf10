//! Solution of direct transcription.

use super::curve::Curve;
use crate::trajopt::status::Status;
use crate::trajopt::trajectory::Trajectory;

/// The best trajectory that was found, at the nodes and as a function of time.
#[derive(Clone, Debug)]
pub struct TranscriptionSolution {
    /// Termination status.
    pub status: Status,
    /// States at the nodes, and the inputs there but for the last. Inputs are within their bounds.
    pub trajectory: Trajectory,
    /// States and inputs at all times; a start for further runs.
    pub curve: Curve,
    /// Number of steps taken or tried.
    pub iterations: usize,
    /// The integral of the costs by Simpson's rule, and the final cost.
    pub cost: f64,
    /// Cost of the guess, then after each iteration.
    pub cost_history: Vec<f64>,
    /// Largest violation of a constraint at nodes and middles; zero without constraints.
    pub violation: f64,
    /// Largest defect, an error of the rate ẋ: how far the curve is from obeying the dynamics at nodes and middles.
    pub gap: f64,
}

impl TranscriptionSolution {
    /// Whether it converged.
    pub fn is_converged(&self) -> bool {
        self.status == Status::Converged
    }
}
