//! Progress of a solver.

/// Progress of a solver at an iteration, for a callback. All solvers report the same fields; those that one does not
/// know are `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// The iteration, from 1.
    pub iteration: usize,
    /// Cost of the trajectory: without penalties, but for [`SingleShooting`](super::SingleShooting), whose cost is the
    /// best so far with the penalties of constraints.
    pub cost: f64,
    /// Largest violation of a constraint, for single shooting when the multipliers were last updated; zero without
    /// constraints.
    pub violation: f64,
    /// Largest gap between a step's end and the next state, of transcription the largest defect; zero where
    /// trajectories obey the dynamics.
    pub gap: f64,
    /// The share of the step that was taken, of single shooting the length of the step in its variables; zero if none
    /// was.
    pub step: f64,
    /// Reduction of the merit that the model predicts for the whole step; of transcription that of its slope. Negative
    /// where closing gaps is expected to cost.
    pub predicted_reduction: Option<f64>,
    /// Largest entry of the gradient.
    pub gradient: Option<f64>,
    /// Regularisation of the Hessian.
    pub regularization: Option<f64>,
}

impl Progress {
    /// Progress of a trajectory that obeys dynamics and constraints, without a step.
    pub(super) fn new(iteration: usize, cost: f64) -> Self {
        Self {
            iteration,
            cost,
            violation: 0.0,
            gap: 0.0,
            step: 0.0,
            predicted_reduction: None,
            gradient: None,
            regularization: None,
        }
    }
}
