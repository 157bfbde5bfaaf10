//! The trait of tasks of reinforcement learning.

use num_traits::One;
use rand::Rng;

use crate::sim::batch::{BATCH_WIDTH, BatchScalar};
use crate::sim::state::State;

/// A task of reinforcement learning over lanes: start of an episode, observations, input of the simulator for an action, reward, and end.
/// [`Environments`](super::Environments) runs it.
///
/// Each number contains [`BATCH_WIDTH`] episodes side by side. Decide lane by lane, by [`Scalar::select_lt`](crate::Scalar::select_lt) or over the entries
/// of a [`Lanes`](crate::Lanes).
pub trait Environment: Sync {
    /// Number of entries of an action.
    fn n_actions(&self) -> usize;

    /// Number of entries of an observation.
    fn n_observations(&self) -> usize;

    /// Number of random values that an episode draws in addition to its state, such as a target speed or the time of a push; none by default.
    fn n_drawn(&self) -> usize {
        0
    }

    /// Starts an episode.
    ///
    /// * `rng` – the generator of the state, whose numbers depend on the seed of the state and on its earlier episodes, not on other states
    /// * `state` – on entry the neutral state
    /// * `drawn` – output, the random values of the episode, length [`n_drawn`](Self::n_drawn), zero on entry
    fn start(&self, rng: &mut dyn Rng, state: &mut State, drawn: &mut [f64]);

    /// Writes the input of a time step, length `nu` and zero on entry. It is called before each time step, so servo targets, pushes and periodic motions
    /// can change between two actions. By default the first entries of the input are the action.
    fn act(&self, episode: &Episode<'_>, action: &[BatchScalar], u: &mut [BatchScalar]) {
        let _ = episode;
        u[..action.len()].copy_from_slice(action);
    }

    /// Writes the observation, length [`n_observations`](Self::n_observations).
    fn observe(&self, episode: &Episode<'_>, out: &mut [BatchScalar]);

    /// The reward of an action, after its time steps; by default 1.
    fn reward(&self, episode: &Episode<'_>, action: &[BatchScalar]) -> BatchScalar {
        let _ = (episode, action);
        BatchScalar::one()
    }

    /// Whether an episode is over, in each lane. An episode whose state diverges is over in any case.
    fn is_over(&self, episode: &Episode<'_>) -> [bool; BATCH_WIDTH];
}

/// Episodes in lanes at an instant.
#[derive(Clone, Copy, Debug)]
pub struct Episode<'a> {
    /// Current state.
    pub state: &'a State<BatchScalar>,
    /// Time since the start of the episode, s.
    pub time: BatchScalar,
    /// Random values that the episode drew at its start.
    pub drawn: &'a [BatchScalar],
}
