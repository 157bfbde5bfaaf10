//! Results of a step of environments.

use super::environment::Environment;

/// Results of the actions of all episodes, row by row. Made by [`Environments::transitions`](super::Environments::transitions).
#[derive(Clone, Debug, PartialEq)]
pub struct Transitions {
    /// Length number of states × entries of an observation. Where a new episode has begun, its first one.
    pub observations: Vec<f64>,
    /// One for each state.
    pub rewards: Vec<f64>,
    /// Whether an episode is over by the rules of its task, or since its state has diverged.
    pub terminated: Vec<bool>,
    /// Whether an episode has reached its greatest length, and is not over otherwise.
    pub truncated: Vec<bool>,
    /// The last observation of episodes that ended in a step in which the next one began; other rows do not change.
    pub final_observations: Vec<f64>,
}

impl Transitions {
    pub(super) fn new(environment: &impl Environment, len: usize) -> Self {
        let width = environment.n_observations();
        Self {
            observations: vec![0.0; len * width],
            rewards: vec![0.0; len],
            terminated: vec![false; len],
            truncated: vec![false; len],
            final_observations: vec![0.0; len * width],
        }
    }
}

/// Rows of the states of one group.
pub(super) struct Rows<'a> {
    pub(super) actions: &'a [f64],
    pub(super) observations: &'a mut [f64],
    pub(super) rewards: &'a mut [f64],
    pub(super) terminated: &'a mut [bool],
    pub(super) truncated: &'a mut [bool],
    pub(super) final_observations: &'a mut [f64],
}
