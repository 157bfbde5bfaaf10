//! Solution of single shooting, and its progress.

use crate::trajopt::status::Status;
use crate::trajopt::trajectory::Trajectory;

/// One iteration, for a callback.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShootingProgress {
    /// The iteration, from 1.
    pub iteration: usize,
    /// The best cost so far, with the penalties of constraints.
    pub cost: f64,
    /// Largest entry of the gradient there.
    pub gradient: f64,
    /// Length of the step that the best variables made, zero if the iteration found none better.
    pub step: f64,
    /// Largest violation of a constraint when the multipliers were last updated; zero without constraints.
    pub violation: f64,
}

/// The best trajectory that was found.
#[derive(Clone, Debug)]
pub struct ShootingSolution {
    /// Termination status.
    pub status: Status,
    /// States and inputs. They obey the dynamics, and the inputs are within their bounds.
    pub trajectory: Trajectory,
    /// The variables that give it; a start for further runs.
    pub variables: Vec<f64>,
    /// Number of iterations.
    pub iterations: usize,
    /// Cost of the trajectory, without penalties.
    pub cost: f64,
    /// Cost of the guess, then the best after each iteration, with the penalties of constraints at the multipliers of the time.
    pub cost_history: Vec<f64>,
    /// Largest violation of a constraint; zero without constraints.
    pub violation: f64,
}

impl ShootingSolution {
    /// Whether it converged.
    pub fn is_converged(&self) -> bool {
        self.status == Status::Converged
    }
}
