//! Episodes of the states of a group.

use std::array::from_fn;

use num_traits::Zero;
use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

use super::environment::{Environment, Episode};
use super::memory::Memory;
use super::rules::{AutoReset, Rules};
use super::transitions::Rows;
use crate::scalar::MapEach;
use crate::sim::batch::group::Group;
use crate::sim::batch::simulator::Stepper;
use crate::sim::batch::{BATCH_WIDTH, BatchScalar};
use crate::sim::state::State;

/// The states of a group.
pub(super) type OwnGroup = Group<BatchScalar, BATCH_WIDTH>;

/// Whether something is so, in each lane.
type Flags = [bool; BATCH_WIDTH];

const NONE: Flags = [false; BATCH_WIDTH];
const ALL: Flags = [true; BATCH_WIDTH];

/// Episodes in the lanes of a group. Lanes past the last state go through what the last state goes through.
#[derive(Clone, Debug)]
pub(super) struct Episodes {
    rngs: [Xoshiro256PlusPlus; BATCH_WIDTH],
    /// Actions since the start.
    pub(super) lengths: [usize; BATCH_WIDTH],
    /// Since the start, s.
    time: BatchScalar,
    /// Whether an episode is over, and the next one has not begun.
    pub(super) ended: Flags,
    drawn: Vec<BatchScalar>,
}

impl Episodes {
    pub(super) fn new(environment: &impl Environment, seeds: [u64; BATCH_WIDTH]) -> Self {
        Self {
            rngs: seeds.map(Xoshiro256PlusPlus::seed_from_u64),
            lengths: [0; BATCH_WIDTH],
            time: BatchScalar::zero(),
            ended: NONE,
            drawn: vec![BatchScalar::zero(); environment.n_drawn()],
        }
    }

    pub(super) fn seed(&mut self, lane: usize, seed: u64) {
        self.rngs[lane] = Xoshiro256PlusPlus::seed_from_u64(seed);
    }

    /// Begins an episode in a lane.
    pub(super) fn begin(
        &mut self,
        environment: &impl Environment,
        lane: usize,
        group: &mut OwnGroup,
        memory: &mut Memory,
    ) {
        memory.begin(environment, &mut self.rngs[lane]);
        group.set(lane, &memory.start);
        let drawn = self.drawn.iter_mut().zip(&memory.start_drawn);
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
        memory: &mut Memory,
    ) {
        let (environment, again) = (rules.environment, self.ended);
        memory.read_actions(rows.actions);
        self.take_steps(rules, stepper, group, &memory.action);
        self.judge(rules, group, again, rows, &memory.action);
        let begins = match rules.auto_reset {
            AutoReset::SameStep => self.ended,
            AutoReset::NextStep | AutoReset::Never => again,
        };
        if begins != NONE {
            if rules.auto_reset == AutoReset::SameStep {
                let last = &mut *rows.final_observations;
                memory.observe(environment, &self.at(&group.state), last, begins);
            }
            for lane in (0..BATCH_WIDTH).filter(|&lane| begins[lane]) {
                self.begin(environment, lane, group, memory);
            }
        }
        self.observe(environment, group, rows.observations, memory);
    }

    /// Steps with the actions.
    fn take_steps<E: Environment>(
        &mut self,
        rules: &Rules<'_, E>,
        stepper: &mut Stepper<'_>,
        group: &mut OwnGroup,
        action: &[BatchScalar],
    ) {
        let time_step = stepper.time_step();
        for k in 0..rules.decimation {
            stepper.set_input(group, |state, u| {
                rules.environment.act(&self.at(state), action, u);
            });
            stepper.step(rules.step + k, group);
            self.time += time_step;
        }
        self.lengths.iter_mut().for_each(|length| *length += 1);
    }

    /// Writes rewards and ends, without a branch for each lane.
    ///
    /// * `again` – whether the episode of a lane begins in this step, so that its action was for nothing
    fn judge<E: Environment>(
        &mut self,
        rules: &Rules<'_, E>,
        group: &OwnGroup,
        again: Flags,
        rows: &mut Rows<'_>,
        action: &[BatchScalar],
    ) {
        let episode = self.at(&group.state);
        let reward = rules.environment.reward(&episode, action).0;
        let (over, runs) = (rules.environment.is_over(&episode), group.runs());
        let is_long = self.lengths.map_each(|length| length >= rules.max_length);
        let over: Flags = from_fn(|k| (over[k] | !runs[k]) & !again[k]);
        let cut: Flags = from_fn(|k| is_long[k] & !again[k] & !over[k]);
        let reward: [f64; BATCH_WIDTH] = from_fn(|k| if again[k] { 0.0 } else { reward[k] });
        self.ended = from_fn(|k| over[k] | cut[k]);
        let n = rows.rewards.len();
        rows.rewards.copy_from_slice(&reward[..n]);
        rows.terminated.copy_from_slice(&over[..n]);
        rows.truncated.copy_from_slice(&cut[..n]);
    }

    /// Writes the observations of the states.
    pub(super) fn observe(
        &self,
        environment: &impl Environment,
        group: &OwnGroup,
        rows: &mut [f64],
        memory: &mut Memory,
    ) {
        memory.observe(environment, &self.at(&group.state), rows, ALL);
    }

    fn at<'a>(&'a self, state: &'a State<BatchScalar>) -> Episode<'a> {
        let (time, drawn) = (self.time, self.drawn.as_slice());
        Episode { state, time, drawn }
    }
}
