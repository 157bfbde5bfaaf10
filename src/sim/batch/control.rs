//! Context of a batch controller: the step, the time and the states in its lanes.

use super::{BATCH_WIDTH, BatchScalar};
use crate::scalar::{Lanes, MapEach, from_each};

/// The step and the states for which an input is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchMoment {
    /// Index of the step, from 0.
    pub step: usize,
    /// Time at its start, s.
    pub time: f64,
    /// Index of the state in each lane. Unused lanes of the last group repeat the last index.
    pub indices: [usize; BATCH_WIDTH],
}

impl BatchMoment {
    pub(super) fn new(group: usize, n: usize) -> Self {
        Self {
            step: 0,
            time: 0.0,
            indices: from_each(|lane| (group * BATCH_WIDTH + lane).min(n - 1)),
        }
    }

    pub(super) fn at(self, step: usize, time_step: f64) -> Self {
        Self {
            step,
            time: step as f64 * time_step,
            ..self
        }
    }

    /// Fills each lane with a number that depends on the index of its state.
    ///
    /// # Examples
    /// ```
    /// use dualbody::sim::{BATCH_WIDTH, BatchMoment};
    ///
    /// let moment = BatchMoment { step: 0, time: 0.0, indices: [1; BATCH_WIDTH] };
    /// assert_eq!(moment.gather(|i| [0.5, 2.5][i]).0, [2.5; BATCH_WIDTH]);
    /// ```
    #[inline]
    pub fn gather(&self, number: impl Fn(usize) -> f64) -> BatchScalar {
        Lanes(self.indices.map_each(number))
    }
}
