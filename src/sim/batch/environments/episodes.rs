//! Episodes of the states of a group.

use num_traits::Zero;
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

use super::environment::{Environment, Episode};
use super::rules::{AutoReset, Rules};
use super::transitions::Rows;
use crate::scalar::Lanes;
use crate::sim::batch::group::Group;
use crate::sim::batch::simulator::Stepper;
use crate::sim::batch::{BATCH_WIDTH, BatchScalar};
use crate::sim::state::State;
use crate::sim::status::RolloutStatus;

/// The states of a group.
pub(super) type OwnGroup = Group<BatchScalar, BATCH_WIDTH>;

/// Episodes in the lanes of a group. Lanes past the last state go through what the last state goes through.
#[derive(Clone, Debug)]
pub(super) struct Episodes {
    rngs: [Xoshiro256PlusPlus; BATCH_WIDTH],
    /// Actions since the start.
    pub(super) lengths: [usize; BATCH_WIDTH],
    /// Since the start, s.
    time: BatchScalar,
    /// Whether an episode is over, and the next one has not begun.
    pub(super) ended: [bool; BATCH_WIDTH],
    drawn: Vec<BatchScalar>,
    action: Vec<BatchScalar>,
    observation: Vec<BatchScalar>,
    /// A state that starts, and what it draws.
    start: State,
    start_drawn: Vec<f64>,
}

impl Episodes {
    pub(super) fn new(
        environment: &impl Environment,
        neutral: &State,
        seeds: [u64; BATCH_WIDTH],
    ) -> Self {
        let zeros = |n: usize| vec![BatchScalar::zero(); n];
        Self {
            rngs: seeds.map(Xoshiro256PlusPlus::seed_from_u64),
            lengths: [0; BATCH_WIDTH],
            time: BatchScalar::zero(),
            ended: [false; BATCH_WIDTH],
            drawn: zeros(environment.n_drawn()),
            action: zeros(environment.n_actions()),
            observation: zeros(environment.n_observations()),
            start: neutral.clone(),
            start_drawn: vec![0.0; environment.n_drawn()],
        }
    }

    pub(super) fn seed(&mut self, lane: usize, seed: u64) {
        self.rngs[lane] = Xoshiro256PlusPlus::seed_from_u64(seed);
    }

    /// Begins an episode in a lane.
    pub(super) fn begin(
        &mut self,
        environment: &impl Environment,
        neutral: &State,
        lane: usize,
        group: &mut OwnGroup,
    ) {
        let numbers = self.start.numbers_mut().zip(neutral.numbers());
        numbers.for_each(|(own, neutral)| *own = *neutral);
        self.start_drawn.fill(0.0);
        environment.start(&mut self.rngs[lane], &mut self.start, &mut self.start_drawn);
        group.set(lane, &self.start);
        let drawn = self.drawn.iter_mut().zip(&self.start_drawn);
        drawn.for_each(|(lanes, own)| lanes.0[lane] = *own);
        (self.lengths[lane], self.time.0[lane], self.ended[lane]) = (0, 0.0, false);
    }

    /// Takes the steps of an action in all lanes, and writes the results.
    pub(super) fn advance<E: Environment>(
        &mut self,
        rules: &Rules<'_, E>,
        stepper: &mut Stepper<'_>,
        group: &mut OwnGroup,
        rows: &mut Rows<'_>,
    ) {
        let again = self.ended;
        self.take_steps(rules, stepper, group, rows.actions);
        self.judge(rules, group, again, rows);
        let begins = match rules.auto_reset {
            AutoReset::SameStep => self.ended,
            AutoReset::NextStep | AutoReset::Never => again,
        };
        if begins != [false; BATCH_WIDTH] {
            if rules.auto_reset == AutoReset::SameStep {
                self.observe(rules.environment, group);
                let begins = |lane: usize| begins[lane];
                write_rows(&self.observation, rows.final_observations, begins);
            }
            for lane in (0..BATCH_WIDTH).filter(|&lane| begins[lane]) {
                self.begin(rules.environment, rules.neutral, lane, group);
            }
        }
        self.observe_into(rules.environment, group, rows.observations);
    }

    /// Steps with the rows of actions.
    fn take_steps<E: Environment>(
        &mut self,
        rules: &Rules<'_, E>,
        stepper: &mut Stepper<'_>,
        group: &mut OwnGroup,
        actions: &[f64],
    ) {
        let (width, last) = (self.action.len(), actions.len());
        for (j, out) in self.action.iter_mut().enumerate() {
            let own = |lane: usize| (lane * width).min(last - width) + j;
            *out = Lanes(std::array::from_fn(|lane| actions[own(lane)]));
        }
        let time_step = stepper.time_step();
        for k in 0..rules.decimation {
            let action = self.action.as_slice();
            stepper.set_input(group, |state, u| {
                rules.environment.act(&self.at(state), action, u);
            });
            stepper.step(rules.step + k, group);
            self.time
                .0
                .iter_mut()
                .zip(time_step.0)
                .for_each(|(t, dt)| *t += dt);
        }
        self.lengths.iter_mut().for_each(|length| *length += 1);
    }

    /// Writes rewards and ends.
    ///
    /// * `again` – whether the episode of a lane begins in this step, so that its action was for nothing
    fn judge<E: Environment>(
        &mut self,
        rules: &Rules<'_, E>,
        group: &OwnGroup,
        again: [bool; BATCH_WIDTH],
        rows: &mut Rows<'_>,
    ) {
        let episode = self.at(&group.state);
        let reward = rules.environment.reward(&episode, &self.action);
        let over = rules.environment.is_over(&episode);
        let runs = group
            .status()
            .map(|status| status == RolloutStatus::Completed);
        let is_over = |lane: usize| (over[lane] || !runs[lane]) && !again[lane];
        let is_cut = |lane: usize| self.lengths[lane] >= rules.max_length && !again[lane];
        self.ended = std::array::from_fn(|lane| is_over(lane) || is_cut(lane));
        for (lane, out) in rows.rewards.iter_mut().enumerate() {
            *out = if again[lane] { 0.0 } else { reward.0[lane] };
            rows.terminated[lane] = is_over(lane);
            rows.truncated[lane] = self.ended[lane] && !is_over(lane);
        }
    }

    /// Writes the observations of the states.
    pub(super) fn observe_into(
        &mut self,
        environment: &impl Environment,
        group: &OwnGroup,
        rows: &mut [f64],
    ) {
        self.observe(environment, group);
        write_rows(&self.observation, rows, |_| true);
    }

    fn observe(&mut self, environment: &impl Environment, group: &OwnGroup) {
        let mut out = std::mem::take(&mut self.observation);
        environment.observe(&self.at(&group.state), &mut out);
        self.observation = out;
    }

    fn at<'a>(&'a self, state: &'a State<BatchScalar>) -> Episode<'a> {
        let (time, drawn) = (self.time, self.drawn.as_slice());
        Episode { state, time, drawn }
    }
}

/// Writes rows of lanes, as many as there are, where they are wanted.
fn write_rows(lanes: &[BatchScalar], rows: &mut [f64], wanted: impl Fn(usize) -> bool) {
    let rows = rows.chunks_exact_mut(lanes.len().max(1)).enumerate();
    for (lane, row) in rows.filter(|(lane, _)| wanted(*lane)) {
        row.iter_mut()
            .zip(lanes)
            .for_each(|(out, x)| *out = x.0[lane]);
    }
}
