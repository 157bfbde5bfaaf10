//! A batch in single precision.
//!
//! Functions that step are marked to be inlined, so that programs that use them compile the physics on this scalar, and others do not.

use super::parallel::{available_threads, for_each_part};
use crate::scalar::{BATCH_WIDTH, Scalar, SingleLanes};
use crate::sim::rollout::RolloutStatus;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::step::StepScratch;

/// States that a batch in single precision steps side by side: twice as many as one in double precision, in the same registers.
pub const SINGLE_WIDTH: usize = 2 * BATCH_WIDTH;

/// The scalar of a batch in single precision.
pub type SingleScalar = SingleLanes<SINGLE_WIDTH>;

/// Steps many states of one robot at once in single precision, with the very [`Simulator::step_into`] that steps one in double.
///
/// For work that takes many steps and few digits: sampling, reinforcement learning, first guesses. [`BatchSimulator`](super::BatchSimulator) has all
/// digits, trajectories and variants of a robot.
///
/// # How far off states are
/// The largest difference from [`Simulator`] in any coordinate (rad or m, rad/s or m/s), beside the largest size that it has on the way, as the test
/// `single_precision` bounds it; chaotic motions, as those of a robot that falls over, part after a while in any precision:
///
/// | motion | after one step | after 1,000 steps |
/// |---|---|---|
/// | 7-joint arm, swinging, steps of 1 ms | 1e-6 | 2e-3 |
/// | quadruped in the air, 1 ms | 1e-6 | 2e-3 |
/// | box that slides on relaxed rigid ground and stops, 1 ms | 1e-4 | 2e-3 |
/// | box that lies on soft ground, 1 ms | 1e-4 | 2e-3 |
///
/// The depth of a contact is a difference of heights: at 1 m above the origin it has a rounding of 1e-7 m, against a stiff spring.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, State, model::samples, sim::SingleBatch};
///
/// let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.01);
/// let starts: Vec<State> = (0..100).map(|k| State::new(&[0.01 * f64::from(k)], &[0.0])).collect();
/// let mut batch = SingleBatch::new(pendulum.clone(), &starts);
/// batch.step(&[0.1; 100]);
/// let exact = pendulum.step(&starts[42], &[0.1]);
/// assert!((batch.state(42).q[0] - exact.q[0]).abs() < 1e-6);
/// ```
#[derive(Clone, Debug)]
pub struct SingleBatch {
    simulator: Simulator,
    len: usize,
    /// Steps taken so far.
    steps: usize,
    groups: Vec<Group>,
    workers: Vec<Worker>,
}

/// The states in the lanes of one number.
#[derive(Clone, Debug)]
struct Group {
    state: State<SingleScalar>,
    status: [RolloutStatus; SINGLE_WIDTH],
}

/// Working memory of a thread.
#[derive(Clone, Debug)]
struct Worker {
    scratch: StepScratch<SingleScalar>,
    next: State<SingleScalar>,
    u: Vec<SingleScalar>,
}

impl SingleBatch {
    /// A batch of some states, rounded to single precision, on all cores.
    ///
    /// # Panics
    /// If a state has the wrong length.
    #[inline]
    pub fn new(simulator: Simulator, states: &[State]) -> Self {
        states.iter().for_each(|state| simulator.check(state));
        let empty = Group {
            state: simulator.neutral_state(),
            status: [RolloutStatus::Completed; SINGLE_WIDTH],
        };
        let worker = Worker {
            scratch: StepScratch::new(&simulator),
            next: simulator.neutral_state(),
            u: vec![SingleScalar::constant(0.0); simulator.nu()],
        };
        let mut out = Self {
            groups: vec![empty; states.len().div_ceil(SINGLE_WIDTH)],
            simulator,
            len: states.len(),
            steps: 0,
            workers: vec![worker],
        };
        for at in 0..out.groups.len() * SINGLE_WIDTH {
            // The last group is filled up with the last state.
            out.groups[at / SINGLE_WIDTH].set(at % SINGLE_WIDTH, &states[at.min(states.len() - 1)]);
        }
        out.with_threads(available_threads())
    }

    /// Uses at most this many threads of rayon's pool. Results do not depend on it.
    ///
    /// # Panics
    /// If it is zero.
    #[must_use]
    pub fn with_threads(mut self, threads: usize) -> Self {
        assert!(threads > 0, "at least one thread is needed");
        let worker = self.workers[0].clone();
        self.workers = vec![worker; threads.min(self.groups.len()).max(1)];
        self
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.len
    }

    /// `true` if there are no states.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The simulator.
    pub fn simulator(&self) -> &Simulator {
        &self.simulator
    }

    /// Advances all states by one time step, each with its own input held constant. A state whose next one is not finite, or is faster than the
    /// [bound](Simulator::with_divergence_bound), stops where it is, see [`status`](Self::status).
    ///
    /// * `inputs` – the input of one state after the other, length `len` × `nu` (N·m or N)
    ///
    /// # Panics
    /// If there are not as many inputs.
    #[inline]
    pub fn step(&mut self, inputs: &[f64]) {
        let (nu, len, step) = (self.simulator.nu(), self.len, self.steps);
        assert_eq!(inputs.len(), len * nu, "len × nu inputs");
        self.steps += 1;
        let simulator = &self.simulator;
        for_each_part(&mut self.workers, &mut self.groups, |worker, k, group| {
            let Worker { scratch, next, u } = worker;
            for (j, u) in u.iter_mut().enumerate() {
                let of = |lane: usize| (k * SINGLE_WIDTH + lane).min(len - 1);
                *u = SingleScalar::from_values(|lane| inputs[of(lane) * nu + j]);
            }
            simulator.step_into(&group.state, u, scratch, next);
            group.accept(step, next, simulator.divergence_bound());
        });
    }

    /// A state, after the last step that did not diverge. Allocates.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn state(&self, i: usize) -> State {
        let (group, lane) = self.at(i);
        let own = |x: &SingleScalar| x.value(lane);
        State {
            q: group.state.q.map(|x| own(&x)),
            v: group.state.v.map(|x| own(&x)),
            contact: group.state.contact.map(|x| own(&x)),
        }
    }

    /// `Completed` while all steps were taken; else at which step, from 0, a state stopped.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn status(&self, i: usize) -> RolloutStatus {
        let (group, lane) = self.at(i);
        group.status[lane]
    }

    /// Sets one state, which runs again if it had stopped. Does not allocate.
    ///
    /// # Panics
    /// If there is no such state, or if it has the wrong length.
    pub fn set(&mut self, i: usize, state: &State) {
        self.simulator.check(state);
        let _ = self.at(i);
        self.groups[i / SINGLE_WIDTH].set(i % SINGLE_WIDTH, state);
    }

    fn at(&self, i: usize) -> (&Group, usize) {
        assert!(i < self.len, "there are {} states, none {i}", self.len);
        (&self.groups[i / SINGLE_WIDTH], i % SINGLE_WIDTH)
    }
}

impl Group {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "that is what single precision is"
    )]
    fn set(&mut self, lane: usize, state: &State) {
        let numbers = self.state.numbers_mut().zip(state.numbers());
        numbers.for_each(|(own, &given)| own.0[lane] = given as f32);
        self.status[lane] = RolloutStatus::Completed;
    }

    /// Takes over the lanes of the next state that run, and stops those that have diverged.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "a bound in single precision"
    )]
    fn accept(&mut self, step: usize, next: &mut State<SingleScalar>, bound: f64) {
        let bound = bound as f32;
        let mut good = [true; SINGLE_WIDTH];
        for x in next.numbers() {
            (0..SINGLE_WIDTH).for_each(|lane| good[lane] &= x.0[lane].is_finite());
        }
        for v in &next.v {
            (0..SINGLE_WIDTH).for_each(|lane| good[lane] &= v.0[lane].abs() <= bound);
        }
        let runs = self.status.map(|status| status == RolloutStatus::Completed);
        if good == [true; SINGLE_WIDTH] && runs == good {
            return std::mem::swap(&mut self.state, next);
        }
        for (own, next) in self.state.numbers_mut().zip(next.numbers()) {
            for lane in (0..SINGLE_WIDTH).filter(|&lane| runs[lane] && good[lane]) {
                own.0[lane] = next.0[lane];
            }
        }
        for lane in (0..SINGLE_WIDTH).filter(|&lane| runs[lane] && !good[lane]) {
            self.status[lane] = RolloutStatus::Diverged { step };
        }
    }
}
