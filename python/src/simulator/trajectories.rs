//! Results of rollouts.

use dualbody::sim::{Rollout, RolloutStatus, SolverFailure};

use crate::prelude::*;

pub(crate) type Status = (&'static str, Option<usize>);

pub(crate) fn status_of(status: RolloutStatus) -> Status {
    match status {
        RolloutStatus::NonFiniteInput { step } => ("non_finite_input", Some(step)),
        RolloutStatus::Diverged { step } => ("diverged", Some(step)),
        RolloutStatus::OutOfMemory { step } => ("out_of_memory", Some(step)),
        _ => ("completed", None),
    }
}

/// Results of a rollout: numbers of the states, inputs, status and failure of the solver of each trajectory.
pub(super) struct Trajectories {
    /// (trajectories, steps + 1, width) numbers.
    pub(super) states: Vec<f64>,
    /// Trajectories for which there is memory; those past the batch mean nothing.
    pub(super) padded: usize,
    /// Those that did not come to their end.
    pub(super) stopped: Vec<(usize, Status)>,
    /// Those in which the solver of forces failed first at a step, and how.
    pub(super) failures: Vec<(usize, (usize, String))>,
}

/// How a trajectory ended.
pub(super) struct End {
    pub(super) status: RolloutStatus,
    pub(super) failure: Option<SolverFailure>,
}

impl Trajectories {
    /// Trajectories from their numbers, as many as there is memory for, and their ends.
    pub(super) fn new(
        states: Vec<f64>,
        padded: usize,
        ends: impl ExactSizeIterator<Item = End>,
    ) -> Self {
        let mut out = Self {
            states,
            padded,
            stopped: Vec::new(),
            failures: Vec::new(),
        };
        for (k, end) in ends.enumerate() {
            if !matches!(end.status, RolloutStatus::Completed) {
                out.stopped.push((k, status_of(end.status)));
            }
            out.failures.extend(
                end.failure
                    .map(|failure| (k, (failure.step, snake(failure.status)))),
            );
        }
        out
    }

    /// That of one state.
    pub(super) fn single(rollout: &Rollout, steps: usize) -> Self {
        let end = End {
            status: rollout.status,
            failure: rollout.solver_failure,
        };
        Self::new(rows_of(rollout, steps), 1, [end].into_iter())
    }
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
