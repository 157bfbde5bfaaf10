//! The states of a batch.

use super::{BATCH_WIDTH, BatchScalar};
use crate::model::Structure;
use crate::scalar::Scalar;
use crate::sim::rollout::{RolloutStatus, SolverFailure};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::step::StepScratch;

/// Many states, side by side in lanes, each with its status. Made by [`BatchSimulator::states`](super::BatchSimulator::states).
#[derive(Clone, Debug)]
pub struct BatchStates {
    pub(super) len: usize,
    /// Structure of the robot that they are of.
    pub(super) robot: Structure,
    pub(super) groups: Vec<Group>,
    /// Steps taken so far.
    pub(super) steps: usize,
}

/// The states in the lanes of one scalar.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) state: State<BatchScalar>,
    status: [RolloutStatus; BATCH_WIDTH],
    solver_failures: [Option<SolverFailure>; BATCH_WIDTH],
    all_run: bool,
}

impl BatchStates {
    pub(super) fn new(simulator: &Simulator, states: &[State]) -> Self {
        states.iter().for_each(|state| simulator.check(state));
        let n = states.len();
        let mut out = Self {
            len: n,
            robot: simulator.model().structure(),
            groups: vec![Group::new(simulator); n.div_ceil(BATCH_WIDTH)],
            steps: 0,
        };
        let padded = out.groups.len() * BATCH_WIDTH;
        for i in 0..padded {
            out.groups[i / BATCH_WIDTH].set(i % BATCH_WIDTH, &states[i.min(n - 1)]);
        }
        out
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.len
    }

    /// `true` if there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// A state: after the last step that did not diverge, see [`status`](Self::status). Allocates.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn state(&self, i: usize) -> State {
        let (group, lane) = self.at(i);
        group.lane(lane)
    }

    /// All states, as [`state`](Self::state) gives them. Allocates.
    pub fn to_vec(&self) -> Vec<State> {
        (0..self.len).map(|i| self.state(i)).collect()
    }

    /// `Completed` while all steps were taken; else why and at which step a state stopped. The index of a step counts from 0, from
    /// the making of the batch. Stopped states stay where they are until they are [`set`](Self::set).
    ///
    /// # Panics
    /// If there is no such state.
    pub fn status(&self, i: usize) -> RolloutStatus {
        let (group, lane) = self.at(i);
        group.status[lane]
    }

    /// The first step of a state in which the solver of the forces of contact and constraints failed, counted as in
    /// [`status`](Self::status); `None` if it never did since the state was [`set`](Self::set).
    ///
    /// # Panics
    /// If there is no such state.
    pub fn solver_failure(&self, i: usize) -> Option<SolverFailure> {
        let (group, lane) = self.at(i);
        group.solver_failures[lane]
    }

    /// Sets one state, which runs again if it had stopped. Does not allocate.
    ///
    /// # Panics
    /// If there is no such state, or if it has the wrong length.
    pub fn set(&mut self, i: usize, state: &State) {
        assert!(i < self.len, "there are {} states, none {i}", self.len);
        self.groups[i / BATCH_WIDTH].set(i % BATCH_WIDTH, state);
    }

    /// The lanes of each group, with all coordinates: for control laws over [`BatchScalar`]. Lanes past the last state repeat it.
    pub fn groups(&self) -> impl ExactSizeIterator<Item = &State<BatchScalar>> {
        self.groups.iter().map(|group| &group.state)
    }

    fn at(&self, i: usize) -> (&Group, usize) {
        assert!(i < self.len, "there are {} states, none {i}", self.len);
        (&self.groups[i / BATCH_WIDTH], i % BATCH_WIDTH)
    }
}

impl Group {
    fn new(simulator: &Simulator) -> Self {
        Self {
            state: simulator.neutral_state(),
            status: [RolloutStatus::Completed; BATCH_WIDTH],
            solver_failures: [None; BATCH_WIDTH],
            all_run: true,
        }
    }

    fn set(&mut self, lane: usize, state: &State) {
        let (own, given) = (&mut self.state, state);
        assert_eq!(
            (own.q.len(), own.v.len(), own.contact.len()),
            (given.q.len(), given.v.len(), given.contact.len()),
            "nq, nv and the length of the state of contact"
        );
        let numbers = own.numbers_mut().zip(given.numbers());
        numbers.for_each(|(own, &given)| own.0[lane] = given);
        self.status[lane] = RolloutStatus::Completed;
        self.solver_failures[lane] = None;
        self.all_run = self.status.map(is_running) == ALL;
    }

    fn lane(&self, lane: usize) -> State {
        State {
            q: self.state.q.map(|x| x.0[lane]),
            v: self.state.v.map(|x| x.0[lane]),
            contact: self.state.contact.map(|x| x.0[lane]),
        }
    }

    pub(super) fn all_stopped(&self) -> bool {
        !self.all_run && !self.status.iter().any(|&status| is_running(status))
    }

    pub(super) fn status(&self) -> &[RolloutStatus; BATCH_WIDTH] {
        &self.status
    }

    pub(super) fn solver_failures(&self) -> &[Option<SolverFailure>; BATCH_WIDTH] {
        &self.solver_failures
    }

    /// Notes where a solver has failed for the first time in a step that has just been taken.
    #[inline]
    pub(super) fn watch_solver(&mut self, step: usize, scratch: &StepScratch<BatchScalar>) {
        for (lane, failure) in self.solver_failures.iter_mut().enumerate() {
            if failure.is_none() && is_running(self.status[lane]) {
                *failure = SolverFailure::of(step, scratch.solver_status(lane));
            }
        }
    }

    /// Takes over the lanes of the next state; a lane that came of an input that is not finite, or is not finite itself or faster than the
    /// bound, stops where it is.
    #[inline]
    pub(super) fn accept(
        &mut self,
        step: usize,
        u: &[BatchScalar],
        next: &mut State<BatchScalar>,
        bound: f64,
    ) {
        let finite_input = finite_lanes(u.iter());
        let finite_state = finite_lanes(next.numbers());
        let slow = slow_lanes(next, bound);
        let finite_state = std::array::from_fn(|lane| finite_state[lane] && slow[lane]);
        if self.all_run && (finite_input, finite_state) == (ALL, ALL) {
            std::mem::swap(&mut self.state, next);
        } else {
            self.accept_some(step, finite_input, finite_state, next);
        }
    }

    #[cold]
    fn accept_some(
        &mut self,
        step: usize,
        finite_input: [bool; BATCH_WIDTH],
        finite_state: [bool; BATCH_WIDTH],
        next: &State<BatchScalar>,
    ) {
        for (lane, status) in self.status.iter_mut().enumerate() {
            if !is_running(*status) {
                continue;
            }
            if !finite_input[lane] {
                *status = RolloutStatus::NonFiniteInput { step };
            } else if !finite_state[lane] {
                *status = RolloutStatus::Diverged { step };
            }
        }
        let running = self.status.map(is_running);
        for (own, next) in self.state.numbers_mut().zip(next.numbers()) {
            for lane in (0..BATCH_WIDTH).filter(|&lane| running[lane]) {
                own.0[lane] = next.0[lane];
            }
        }
        self.all_run = running == ALL;
    }
}

const ALL: [bool; BATCH_WIDTH] = [true; BATCH_WIDTH];

fn is_running(status: RolloutStatus) -> bool {
    status == RolloutStatus::Completed
}

/// In which lanes no coordinate is faster than a bound.
#[inline]
fn slow_lanes(state: &State<BatchScalar>, bound: f64) -> [bool; BATCH_WIDTH] {
    let mut slow = ALL;
    for v in &state.v {
        for (slow, v) in slow.iter_mut().zip(v.0) {
            *slow &= v.abs() <= bound;
        }
    }
    slow
}

/// In which lanes all numbers are finite: a product with zero is zero but for what is not finite.
#[inline]
fn finite_lanes<'a>(numbers: impl Iterator<Item = &'a BatchScalar>) -> [bool; BATCH_WIDTH] {
    let sum = numbers.fold(BatchScalar::constant(0.0), |sum, &x| sum + x * 0.0);
    sum.0.map(|x| x == 0.0)
}
