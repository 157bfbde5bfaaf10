//! Runs a task on many states.

use super::environment::Environment;
use super::episodes::{Episodes, OwnGroup};
use super::rules::{AutoReset, Rules};
use super::transitions::{Rows, Transitions};
use crate::sim::batch::{BATCH_WIDTH, BatchSimulator, BatchStates};
use crate::sim::state::State;

/// Episodes of a task on the states of a batch.
///
/// Each state has random numbers of its own, so that its episodes depend on its seed and its actions: neither on threads nor on the number of states.
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
    neutral: State,
    decimation: usize,
    max_length: usize,
    auto_reset: AutoReset,
}

impl<E: Environment> Environments<E> {
    /// Episodes of a task, begun, on all states of a batch: without an end by their length, one time step for each action.
    ///
    /// * `seed` – of the first state; that of state i is `seed` + i
    pub fn new(environment: E, batch: BatchSimulator, seed: u64) -> Self {
        let neutral = batch.template().neutral_state();
        let states = batch.states(&vec![neutral.clone(); batch.len()]);
        let last = batch.len().saturating_sub(1);
        let of_lane = |group: usize, lane: usize| (group * BATCH_WIDTH + lane).min(last) as u64;
        let seeds = |group| std::array::from_fn(|lane| seed.wrapping_add(of_lane(group, lane)));
        let groups = 0..batch.len().div_ceil(BATCH_WIDTH);
        let episodes = groups.map(|k| Episodes::new(&environment, &neutral, seeds(k)));
        let mut out = Self {
            episodes: episodes.collect(),
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

    /// Takes so many time steps for each action.
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

    /// Cuts episodes off after so many actions.
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

    /// Sets when an episode begins after the end of another one; by default in the step after it.
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

    /// Whether an episode is over, and no other one has begun in its place.
    pub fn needs_reset(&self) -> bool {
        self.episodes.iter().any(|own| own.ended.contains(&true))
    }

    /// Memory for the results of [`step`](Self::step).
    pub fn transitions(&self) -> Transitions {
        Transitions::new(&self.environment, self.states.len())
    }

    /// Seeds the random numbers of a state anew, from its next episode on.
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

    /// Begins all episodes anew.
    ///
    /// * `observations` – output: rows of all states
    ///
    /// # Panics
    /// If the output has the wrong length.
    pub fn reset(&mut self, observations: &mut [f64]) {
        self.begin_where(|_| true);
        self.observe(observations);
    }

    /// Begins the episodes of a mask anew.
    ///
    /// * `mask` – length number of states
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
            let (episodes, group) = (&mut self.episodes, &mut self.states.groups.all);
            let k = i / BATCH_WIDTH;
            for lane in lanes_of(i, len) {
                episodes[k].begin(&self.environment, &self.neutral, lane, &mut group[k]);
            }
        }
    }

    /// Writes the observations of all states, row by row.
    ///
    /// # Panics
    /// If the output has the wrong length.
    pub fn observe(&mut self, observations: &mut [f64]) {
        let width = self.environment.n_observations();
        assert_eq!(
            observations.len(),
            self.states.len() * width,
            "rows of observations"
        );
        let rows = observations.chunks_mut((BATCH_WIDTH * width).max(1));
        let groups = self.episodes.iter_mut().zip(&self.states.groups.all);
        for ((episodes, group), rows) in groups.zip(rows) {
            episodes.observe_into(&self.environment, group, rows);
        }
    }

    /// Takes the time steps of an action in all episodes, and begins new ones by the rule of [`AutoReset`]. An episode whose state diverges is over.
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
        let lengths = (
            out.observations.len(),
            out.final_observations.len(),
            out.rewards.len(),
        );
        assert_eq!(
            lengths,
            (len * width, len * width, len),
            "memory of the results"
        );
        let waits = self.auto_reset == AutoReset::Never && self.needs_reset();
        assert!(
            !waits,
            "an episode is over: begin another one by reset_where"
        );
        let rules = Rules {
            environment: &self.environment,
            neutral: &self.neutral,
            step: self.states.groups.steps,
            decimation: self.decimation,
            max_length: self.max_length,
            auto_reset: self.auto_reset,
        };
        self.states.groups.steps += self.decimation;
        let mut items = items(
            &mut self.episodes,
            &mut self.states.groups.all,
            actions,
            out,
        );
        self.batch
            .for_each(&mut items, |stepper, _, (episodes, group, rows)| {
                episodes.advance(&rules, stepper, group, rows);
            });
    }
}

/// The lanes of a state: those that fill up the last group are of the last one.
fn lanes_of(i: usize, len: usize) -> std::ops::Range<usize> {
    let lane = i % BATCH_WIDTH;
    lane..if i + 1 == len { BATCH_WIDTH } else { lane + 1 }
}

/// Episodes of a group, its states, and its rows.
type Item<'a> = (&'a mut Episodes, &'a mut OwnGroup, Rows<'a>);

fn items<'a>(
    episodes: &'a mut [Episodes],
    groups: &'a mut [OwnGroup],
    actions: &'a [f64],
    out: &'a mut Transitions,
) -> Vec<Item<'a>> {
    let len = out.rewards.len();
    let [n_actions, width] = [actions.len(), out.observations.len()].map(|n| n / len.max(1));
    let mut observations = out.observations.chunks_mut((BATCH_WIDTH * width).max(1));
    let mut last = out
        .final_observations
        .chunks_mut((BATCH_WIDTH * width).max(1));
    let mut actions = actions.chunks((BATCH_WIDTH * n_actions).max(1));
    let ends = out
        .terminated
        .chunks_mut(BATCH_WIDTH)
        .zip(out.truncated.chunks_mut(BATCH_WIDTH));
    let each = out.rewards.chunks_mut(BATCH_WIDTH).zip(ends);
    let rows = each.map(|(rewards, (terminated, truncated))| Rows {
        actions: actions.next().unwrap_or_default(),
        observations: observations.next().unwrap_or_default(),
        rewards,
        terminated,
        truncated,
        final_observations: last.next().unwrap_or_default(),
    });
    let own = episodes.iter_mut().zip(groups).zip(rows);
    own.map(|((episodes, group), rows)| (episodes, group, rows))
        .collect()
}
