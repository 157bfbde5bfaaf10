//! Progress of a solver.

/// Progress of a solver at an iteration, for a callback. All solvers report the same fields; fields that a solver does not compute are `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// The iteration, from 1.
    pub iteration: usize,
    /// Cost of the trajectory, without penalties; for [`SingleShooting`](super::SingleShooting) the best cost so far, with the penalties of constraints.
    pub cost: f64,
    /// Largest violation of a constraint (for single shooting at the last update of the multipliers); zero without constraints.
    pub violation: f64,
    /// Largest gap between the end of a step and the next state, for direct collocation the largest defect; zero if trajectories satisfy the dynamics.
    pub gap: f64,
    /// The line-search factor of the step, for single shooting the length of the step in its variables; zero if no step was taken.
    pub step: f64,
    /// Reduction of the merit function that the model predicts for the full step; for direct collocation by its slope. Negative if closing gaps is
    /// predicted to increase the cost.
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
