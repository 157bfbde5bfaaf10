//! Results of a step of environments.

use super::environment::Environment;
use crate::scalar::MapEach;

/// Results of the actions of all episodes, row by row. Made by [`Environments::transitions`](super::Environments::transitions).
#[derive(Clone, Debug, PartialEq)]
pub struct Transitions {
    /// Observations, a row for each state; the first observation of a new episode if one has started.
    pub observations: Vec<f64>,
    /// Reward of each state.
    pub rewards: Vec<f64>,
    /// Whether the episode of each state is over by the rules of its task, or because its state has diverged.
    pub terminated: Vec<bool>,
    /// Whether the episode of each state has reached its maximum length and is not over otherwise.
    pub truncated: Vec<bool>,
    /// The last observation of episodes that ended in a step in which the next episode started; other rows are unchanged.
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

/// Rows of some states.
#[derive(Default)]
pub(super) struct Rows<'a> {
    pub(super) actions: &'a [f64],
    pub(super) observations: &'a mut [f64],
    pub(super) rewards: &'a mut [f64],
    pub(super) terminated: &'a mut [bool],
    pub(super) truncated: &'a mut [bool],
    pub(super) final_observations: &'a mut [f64],
}

impl<'a> Rows<'a> {
    /// All rows.
    pub(super) fn all(actions: &'a [f64], out: &'a mut Transitions) -> Self {
        Self {
            actions,
            observations: &mut out.observations,
            rewards: &mut out.rewards,
            terminated: &mut out.terminated,
            truncated: &mut out.truncated,
            final_observations: &mut out.final_observations,
        }
    }

    /// Takes off the rows of so many states, or all if there are fewer.
    pub(super) fn take(&mut self, states: usize) -> Self {
        let all = self.rewards.len();
        if states >= all {
            return std::mem::take(self);
        }
        let [n_actions, width] =
            [self.actions.len(), self.observations.len()].map_each(|n| n / all);
        let actions = self.actions.split_off(..states * n_actions);
        let rows =
            |all: &mut &'a mut [f64]| all.split_off_mut(..states * width).unwrap_or_default();
        let flags = |all: &mut &'a mut [bool]| all.split_off_mut(..states).unwrap_or_default();
        Self {
            actions: actions.unwrap_or_default(),
            observations: rows(&mut self.observations),
            rewards: self.rewards.split_off_mut(..states).unwrap_or_default(),
            terminated: flags(&mut self.terminated),
            truncated: flags(&mut self.truncated),
            final_observations: rows(&mut self.final_observations),
        }
    }
}
