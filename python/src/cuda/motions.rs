//! Rollouts of a GPU as numbers of arrays.

use dualbody_cuda::{CudaRollout, Ending};

use crate::simulator::{Status, status_of};

/// The states that were kept, the last ones, and how each motion ended.
pub(super) struct Motions {
    /// (motions, kept, width) numbers; what a motion did not reach is not a number.
    pub(super) kept: Vec<f64>,
    /// (motions, width) numbers.
    pub(super) last: Vec<f64>,
    pub(super) interval: f64,
    /// Those that did not come to their end.
    pub(super) stopped: Vec<(usize, Status)>,
}

impl Motions {
    /// * `kept` – states that a motion keeps if it comes to its end, the first one among them
    pub(super) fn new(rollout: &CudaRollout, kept: usize) -> Self {
        let count = rollout.len();
        let width = (0..count).next().map_or(0, |i| rollout.last(i).len());
        let mut out = Self {
            kept: vec![f64::NAN; count * kept * width],
            last: vec![0.0; count * width],
            interval: rollout.interval,
            stopped: Vec::new(),
        };
        for i in 0..count {
            let own = &mut out.kept[i * kept * width..(i + 1) * kept * width];
            let rows = own.chunks_mut(width.max(1)).take(rollout.n_states(i));
            rows.enumerate()
                .for_each(|(k, row)| rollout.state(i, k).copy_to_slice(row));
            let own = &mut out.last[i * width..(i + 1) * width];
            rollout.last(i).copy_to_slice(own);
            let status = ending_of(rollout.ending(i));
            out.stopped.extend(status.map(|status| (i, status)));
        }
        out
    }
}

/// How a motion ended before its end; `None` if it is complete.
pub(super) fn ending_of(ending: Ending) -> Option<Status> {
    let status = match ending {
        Ending::Rollout(status) => status_of(status),
        Ending::BrokenCondition { step, .. } => ("broken_condition", Some(step)),
    };
    Some(status).filter(|(_, step)| step.is_some())
}
