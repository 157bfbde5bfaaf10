//! Working memory of a thread that runs episodes.

use num_traits::Zero;
use rand::Rng;

use super::environment::{Environment, Episode};
use crate::scalar::from_each;
use crate::sim::batch::{BATCH_WIDTH, BatchScalar};
use crate::sim::state::State;

/// Working memory of a thread: a group after the other goes through it.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    neutral: State,
    /// A state that starts, and what it draws.
    pub(super) start: State,
    pub(super) start_drawn: Vec<f64>,
    pub(super) action: Vec<BatchScalar>,
    observation: Vec<BatchScalar>,
}

impl Memory {
    pub(super) fn new(environment: &impl Environment, neutral: &State) -> Self {
        let zeros = |n: usize| vec![BatchScalar::zero(); n];
        Self {
            neutral: neutral.clone(),
            start: neutral.clone(),
            start_drawn: vec![0.0; environment.n_drawn()],
            action: zeros(environment.n_actions()),
            observation: zeros(environment.n_observations()),
        }
    }

    /// Starts an episode.
    pub(super) fn begin(&mut self, environment: &impl Environment, rng: &mut dyn Rng) {
        self.start.copy_from(&self.neutral);
        self.start_drawn.fill(0.0);
        environment.start(rng, &mut self.start, &mut self.start_drawn);
    }

    /// Reads the rows of actions. Lanes past the last row get what the last one says.
    pub(super) fn read_actions(&mut self, rows: &[f64]) {
        let width = self.action.len();
        for (j, out) in self.action.iter_mut().enumerate() {
            out.0 = from_each(|lane| rows[(lane * width).min(rows.len() - width) + j]);
        }
    }

    /// Writes the wanted rows of observations, as many as there are.
    pub(super) fn observe(
        &mut self,
        environment: &impl Environment,
        episode: &Episode<'_>,
        rows: &mut [f64],
        wanted: [bool; BATCH_WIDTH],
    ) {
        let lanes = &mut self.observation[..];
        environment.observe(episode, lanes);
        let rows = rows.chunks_exact_mut(lanes.len().max(1));
        for ((lane, row), _) in rows.enumerate().zip(wanted).filter(|(_, wanted)| *wanted) {
            let numbers = row.iter_mut().zip(&*lanes);
            numbers.for_each(|(out, x)| *out = x.0[lane]);
        }
    }
}
