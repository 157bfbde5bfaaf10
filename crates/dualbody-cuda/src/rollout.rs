//! Motions of a batch, on the host.

use dualbody::State;

use crate::error::CudaError;
use crate::numbers::Numbers;
use crate::real::Real;
use crate::states::{CudaStates, Ending, state};

/// The motions of a batch: the stored states, and the last ones.
#[derive(Clone, Debug)]
pub struct CudaRollout {
    /// Time from one stored state to the next, s; by the time step of the simulator, even if states have different time steps.
    pub interval: f64,
    every: usize,
    initial: Vec<State>,
    /// Those that are kept of one state after the other.
    kept: Vec<State>,
    n_kept: usize,
    last: Vec<State>,
    endings: Vec<Ending>,
    taken: Vec<u32>,
}

/// Results of a rollout on the device.
pub(crate) struct Left<'a, R> {
    pub(crate) states: &'a CudaStates<R>,
    pub(crate) kept: &'a Numbers<R>,
    pub(crate) n_kept: usize,
    pub(crate) every: usize,
    pub(crate) interval: f64,
}

impl CudaRollout {
    /// Fetches a rollout from the device.
    pub(crate) fn fetch<R: Real>(initial: &[State], left: &Left<'_, R>) -> Result<Self, CudaError> {
        let (states, rows) = (left.states, left.states.numbers.rows());
        let kept = left.kept.download_states()?;
        let of_row = |row: &[R]| state(row, &states.like);
        Ok(Self {
            interval: left.interval,
            every: left.every,
            initial: initial.to_vec(),
            kept: kept.chunks_exact(rows.max(1)).map(of_row).collect(),
            n_kept: left.n_kept,
            last: states.to_vec()?,
            endings: states.endings()?,
            taken: states.status.taken()?,
        })
    }

    /// Number of motions.
    pub fn len(&self) -> usize {
        self.initial.len()
    }

    /// `false`, as a batch has at least one state.
    pub fn is_empty(&self) -> bool {
        self.initial.is_empty()
    }

    /// Ending of a motion.
    ///
    /// # Panics
    /// If there is no such motion.
    pub fn ending(&self, i: usize) -> Ending {
        self.endings[i]
    }

    /// Steps that a motion has taken.
    ///
    /// # Panics
    /// If there is no such motion.
    pub fn steps(&self, i: usize) -> usize {
        self.taken[i] as usize
    }

    /// Number of stored states of a motion, including the first one.
    ///
    /// # Panics
    /// If there is no such motion.
    pub fn n_states(&self, i: usize) -> usize {
        1 + self.steps(i).checked_div(self.every).unwrap_or(0)
    }

    /// Stored state `k` of motion `i`; 0 is the first state.
    ///
    /// # Panics
    /// If there is no such motion, or if it has fewer.
    pub fn state(&self, i: usize, k: usize) -> &State {
        assert!(k < self.n_states(i), "motion {i} has no state {k}");
        match k.checked_sub(1) {
            None => &self.initial[i],
            Some(k) => &self.kept[i * self.n_kept + k],
        }
    }

    /// The last state of a motion, stored or not.
    ///
    /// # Panics
    /// If there is no such motion.
    pub fn last(&self, i: usize) -> &State {
        &self.last[i]
    }
}
