//! Runs a task on many states.

use super::environment::Environment;
use super::episodes::Episodes;
use super::memory::Memory;
use super::rules::{AutoReset, Rules};
use super::transitions::{Rows, Transitions};
use crate::scalar::from_each;
use crate::sim::batch::{BATCH_WIDTH, BatchSimulator, BatchStates};
use crate::sim::state::State;

/// Episodes of a task on the states of a batch.
///
/// Each state has its own random numbers, so its episodes depend on its seed and its actions, not on threads or the number of states.
///
/// # Examples
/// ```
/// use dualbody::sim::{BATCH_WIDTH, BatchScalar, BatchSimulator, Environment, Environments, Episode};
/// use dualbody::{Simulator, State, model::samples};
/// use rand::{Rng, RngExt};
///
/// /// A pendulum is kept hanging.
/// struct Hang;
///
/// impl Environment for Hang {
///     fn n_actions(&self) -> usize { 1 }
///     fn n_observations(&self) -> usize { 2 }
///     fn start(&self, rng: &mut dyn Rng, state: &mut State, _: &mut [f64]) {
///         state.q[0] = rng.random_range(-0.1..0.1);
///     }
///     fn observe(&self, now: &Episode<'_>, out: &mut [BatchScalar]) {
///         out.copy_from_slice(&[now.state.q[0], now.state.v[0]]);
///     }
///     fn is_over(&self, now: &Episode<'_>) -> [bool; BATCH_WIDTH] {
///         now.state.q[0].0.map(|q| q.abs() > 0.5)
///     }
/// }
///
/// let batch = BatchSimulator::new(Simulator::new(samples::pendulum()), 20);
/// let mut all = Environments::new(Hang, batch, 7).with_decimation(10).with_max_length(5);
/// let mut next = all.transitions();
/// all.reset(&mut next.observations);
/// (0..5).for_each(|_| all.step(&[0.0; 20], &mut next));
/// assert_eq!((next.rewards[3], next.truncated[3], next.terminated[3]), (1.0, true, false));
/// ```
#[derive(Debug)]
pub struct Environments<E> {
    environment: E,
    batch: BatchSimulator,
    states: BatchStates,
    episodes: Vec<Episodes>,
    /// Of each thread, and one at least.
    memories: Vec<Memory>,
    neutral: State,
    decimation: usize,
    max_length: usize,
    auto_reset: AutoReset,
}

impl<E: Environment> Environments<E> {
    /// Starts episodes of a task on all states of a batch: of any length, with one time step for each action.
    ///
    /// * `seed` – seed of the first state; state i has `seed` + i
    pub fn new(environment: E, batch: BatchSimulator, seed: u64) -> Self {
        let neutral = batch.template().neutral_state();
        let states = batch.states(&vec![neutral.clone(); batch.len()]);
        let last = batch.len().saturating_sub(1);
        let of_lane = |group: usize, lane: usize| (group * BATCH_WIDTH + lane).min(last) as u64;
        let seeds = |group| from_each(|lane| seed.wrapping_add(of_lane(group, lane)));
        let groups = 0..batch.len().div_ceil(BATCH_WIDTH);
        let episodes = groups.map(|k| Episodes::new(&environment, seeds(k)));
        let mut out = Self {
            episodes: episodes.collect(),
            memories: vec![Memory::new(&environment, &neutral)],
            environment,
            batch,
            states,
            neutral,
            decimation: 1,
            max_length: usize::MAX,
            auto_reset: AutoReset::default(),
        };
        out.begin_where(|_| true);
        out
    }

    /// Sets the number of time steps for each action; 1 by default.
    ///
    /// # Panics
    /// If it is zero.
    #[must_use]
    pub fn with_decimation(mut self, steps: usize) -> Self {
        assert!(
            steps > 0,
            "an action takes no time step, expected one at least"
        );
        self.decimation = steps;
        self
    }

    /// Sets the maximum number of actions of an episode, after which it is truncated; none by default.
    ///
    /// # Panics
    /// If it is zero.
    #[must_use]
    pub fn with_max_length(mut self, actions: usize) -> Self {
        assert!(
            actions > 0,
            "an episode has no action, expected one at least"
        );
        self.max_length = actions;
        self
    }

    /// Sets the time at which a new episode starts after the end of one; by default the next step.
    #[must_use]
    pub fn with_auto_reset(mut self, auto_reset: AutoReset) -> Self {
        self.auto_reset = auto_reset;
        self
    }

    /// Uses at most this many threads, see [`BatchSimulator::with_threads`].
    ///
    /// # Panics
    /// If it is zero.
    #[must_use]
    pub fn with_threads(mut self, threads: usize) -> Self {
        self.batch = self.batch.with_threads(threads);
        self
    }

    /// The task.
    pub fn environment(&self) -> &E {
        &self.environment
    }

    /// The simulator.
    pub fn simulator(&self) -> &BatchSimulator {
        &self.batch
    }

    /// The states.
    pub fn states(&self) -> &BatchStates {
        &self.states
    }

    /// Number of actions in an episode so far.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn length(&self, i: usize) -> usize {
        assert!(
            i < self.states.len(),
            "there are {} states, got state {i}",
            self.states.len()
        );
        self.episodes[i / BATCH_WIDTH].lengths[i % BATCH_WIDTH]
    }

    /// Whether the episode of some state is over and no new one has started, so that [`reset_where`](Self::reset_where) must be called.
    pub fn needs_reset(&self) -> bool {
        self.episodes.iter().any(|own| own.ended.contains(&true))
    }

    /// Memory for the results of [`step`](Self::step).
    pub fn transitions(&self) -> Transitions {
        Transitions::new(&self.environment, self.states.len())
    }

    /// Sets a new seed for the random numbers of a state, from its next episode on.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn seed(&mut self, i: usize, seed: u64) {
        let len = self.states.len();
        assert!(i < len, "there are {len} states, got state {i}");
        for lane in lanes_of(i, len) {
            self.episodes[i / BATCH_WIDTH].seed(lane, seed);
        }
    }

    /// Starts a new episode of every state.
    ///
    /// * `observations` – output: rows of all states
    ///
    /// # Panics
    /// If the output has the wrong length.
    pub fn reset(&mut self, observations: &mut [f64]) {
        self.begin_where(|_| true);
        self.observe(observations);
    }

    /// Starts new episodes of the states that a mask selects.
    ///
    /// * `mask` – one entry for each state
    /// * `observations` – output: rows of all states
    ///
    /// # Panics
    /// If mask or output have the wrong length.
    pub fn reset_where(&mut self, mask: &[bool], observations: &mut [f64]) {
        assert_eq!(mask.len(), self.states.len(), "the length of the mask");
        self.begin_where(|i| mask[i]);
        self.observe(observations);
    }

    fn begin_where(&mut self, begins: impl Fn(usize) -> bool) {
        let len = self.states.len();
        for i in (0..len).filter(|i| begins(*i)) {
            let (k, memory) = (i / BATCH_WIDTH, &mut self.memories[0]);
            let (episodes, group) = (&mut self.episodes[k], &mut self.states.groups.all[k]);
            for lane in lanes_of(i, len) {
                episodes.begin(&self.environment, lane, group, memory);
            }
        }
    }

    /// Writes the observations of all states, row by row.
    ///
    /// # Panics
    /// If the output has the wrong length.
    pub(crate) fn observe(&mut self, observations: &mut [f64]) {
        let width = self.environment.n_observations();
        assert_eq!(
            observations.len(),
            self.states.len() * width,
            "rows of observations"
        );
        let rows = observations.chunks_mut((BATCH_WIDTH * width).max(1));
        let groups = self.episodes.iter().zip(&self.states.groups.all);
        for ((episodes, group), rows) in groups.zip(rows) {
            episodes.observe(&self.environment, group, rows, &mut self.memories[0]);
        }
    }

    /// Takes the time steps of an action in all episodes, and starts new episodes as [`AutoReset`] defines. An episode whose state diverges is over.
    ///
    /// * `actions` – the actions of all states, row by row
    ///
    /// # Panics
    /// If actions or output have the wrong length. Without automatic reset, if an episode is over.
    pub fn step(&mut self, actions: &[f64], out: &mut Transitions) {
        let (n_actions, width) = (
            self.environment.n_actions(),
            self.environment.n_observations(),
        );
        let len = self.states.len();
        assert_eq!(
            actions.len(),
            len * n_actions,
            "states × entries of an action"
        );
        let rows = [out.observations.len(), out.final_observations.len()];
        let ends = [out.terminated.len(), out.truncated.len()];
        let is_own = rows == [len * width; 2] && out.rewards.len() == len && ends == [len; 2];
        assert!(is_own, "memory of results of other environments");
        let waits = self.auto_reset == AutoReset::Never && self.needs_reset();
        assert!(
            !waits,
            "an episode is over: begin another one by reset_where"
        );
        let rules = Rules {
            environment: &self.environment,
            step: self.states.groups.steps,
            decimation: self.decimation,
            max_length: self.max_length,
            auto_reset: self.auto_reset,
        };
        self.states.groups.steps += self.decimation;
        // One for each thread, instead of one for each group.
        let groups = self.episodes.len().div_ceil(self.batch.threads()).max(1);
        let memory = || Memory::new(rules.environment, &self.neutral);
        self.memories.resize_with(self.batch.threads(), memory);
        let mut rows = Rows::all(actions, out);
        let episodes = self.episodes.chunks_mut(groups);
        let own = episodes.zip(self.states.groups.all.chunks_mut(groups));
        let parts = own.zip(&mut self.memories);
        let parts = parts.map(|(own, memory)| (own, rows.take(groups * BATCH_WIDTH), memory));
        let mut parts: Vec<_> = parts.collect();
        self.batch.for_each(
            &mut parts,
            |stepper, part, ((episodes, all), rows, memory)| {
                for (k, (own, group)) in episodes.iter_mut().zip(&mut **all).enumerate() {
                    stepper.group = part * groups + k;
                    own.advance(&rules, stepper, group, &mut rows.take(BATCH_WIDTH), memory);
                }
            },
        );
    }
}

/// The lanes of a state: those that fill up the last group are of the last one.
fn lanes_of(i: usize, len: usize) -> std::ops::Range<usize> {
    let lane = i % BATCH_WIDTH;
    lane..if i + 1 == len { BATCH_WIDTH } else { lane + 1 }
}
