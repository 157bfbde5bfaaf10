//! What a rollout gives.

use dualbody::sim::{Rollout, RolloutStatus, SolverFailure};

pub(crate) type Status = (&'static str, Option<usize>);

pub(super) fn status_of(status: RolloutStatus) -> Status {
    match status {
        RolloutStatus::NonFiniteInput { step } => ("non_finite_input", Some(step)),
        RolloutStatus::Diverged { step } => ("diverged", Some(step)),
        _ => ("completed", None),
    }
}

pub(super) fn failure_of(failure: Option<SolverFailure>) -> Option<(usize, String)> {
    failure.map(|failure| (failure.step, format!("{:?}", failure.status)))
}

/// What a rollout gives: numbers of the states, inputs, status and failure of the solver of each trajectory.
pub(crate) struct Trajectories {
    /// (trajectories, steps + 1, width) numbers.
    pub(crate) states: Vec<f64>,
    /// Trajectories for which there is memory; those past the batch mean nothing.
    pub(crate) padded: usize,
    pub(crate) statuses: Vec<Status>,
    pub(crate) failures: Vec<Option<(usize, String)>>,
}

/// Copies a trajectory of the library into rows; what it did not reach is not a number.
fn rows_of(rollout: &Rollout, steps: usize) -> Vec<f64> {
    let width = rollout.states[0].len();
    let mut out = vec![f64::NAN; (steps + 1) * width];
    for (row, state) in out.chunks_mut(width.max(1)).zip(&rollout.states) {
        state.copy_to_slice(row);
    }
    out
}

pub(super) fn single(rollout: &Rollout, steps: usize) -> Trajectories {
    Trajectories {
        states: rows_of(rollout, steps),
        padded: 1,
        statuses: vec![status_of(rollout.status)],
        failures: vec![failure_of(rollout.solver_failure)],
    }
}
