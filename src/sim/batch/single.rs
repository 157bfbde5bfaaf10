//! A batch in single precision.
//!
//! Functions that step are marked `#[inline]`: only programs that use them compile the physics for this scalar.

use super::groups::Groups;
use super::worker::Worker;
use crate::parallel::{available_threads, for_each_part};
use crate::scalar::{BATCH_WIDTH, Scalar, SingleLanes};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::status::{RolloutStatus, SolverFailure};

/// Number of states in a group in single precision: twice that of double precision, in the same registers.
pub const SINGLE_WIDTH: usize = 2 * BATCH_WIDTH;

/// The scalar of a batch in single precision.
pub type SingleScalar = SingleLanes<SINGLE_WIDTH>;

/// Steps many states of one robot at once in single precision, with the same [`Simulator::step_into`] as in double precision.
///
/// For work that needs many steps and few digits: sampling, reinforcement learning, initial guesses. [`BatchSimulator`](super::BatchSimulator) has
/// double precision, trajectories and variants of a robot.
///
/// # Accuracy
/// At equal states, the errors of joint forces and accelerations of an arm, a quadruped and a humanoid are within 6e-7 of the largest
/// value. The table shows motions with steps of 1 ms: the largest difference from [`Simulator`] in any coordinate (rad or m, rad/s or m/s), relative
/// to the largest coordinate at that time, or to one. The test `single_precision` measures these values and bounds them at three to seven times as
/// much:
///
/// | motion | after one step | within 1,000 steps |
/// |---|---|---|
/// | 7-joint arm, held by springs and dampers of its motors | 2e-7 | 4e-6 |
/// | the same without motors, falling and rotating fast | 3e-8 | 0.07 |
/// | quadruped in the air | 3e-8 | 9e-6 |
/// | box that slides on regularised rigid ground and stops | 3e-9 | 5e-7 |
/// | the same on soft ground | 3e-9 | 1e-6 |
/// | the same on rigid ground | 2e-8 | 2e-5 |
///
/// Chaotic motions, such as that of the falling arm, diverge after some time in any precision, and sooner in single precision.
///
/// The depth of a contact is a difference of heights: at 1 m above the origin its rounding error is 1e-7 m, multiplied by the stiffness of the contact.
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
    groups: Groups<SingleScalar, SINGLE_WIDTH>,
    workers: Vec<Worker<SingleScalar>>,
}

#[expect(
    clippy::len_without_is_empty,
    reason = "a count, none of which is rare"
)]
impl SingleBatch {
    /// A batch of some states, rounded to single precision, on all cores.
    ///
    /// # Panics
    /// If a state has the wrong length.
    #[inline]
    pub fn new(simulator: Simulator, states: &[State]) -> Self {
        let out = Self {
            workers: vec![Worker::new(&simulator)],
            groups: Groups::new(&simulator, states),
            simulator,
        };
        out.with_threads(available_threads())
    }

    /// Uses at most this many threads, the calling one and others of rayon's pool. Results do not depend on it.
    ///
    /// # Panics
    /// If it is zero.
    #[inline]
    #[must_use]
    pub fn with_threads(mut self, threads: usize) -> Self {
        assert!(threads > 0, "at least one thread is needed");
        let worker = self.workers[0].clone();
        self.workers = vec![worker; threads.min(self.groups.all.len()).max(1)];
        self
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.groups.len
    }

    /// The simulator.
    pub fn simulator(&self) -> &Simulator {
        &self.simulator
    }

    /// Advances all states by one time step, each with its own input held constant. A state whose input or next state is not finite, or whose next
    /// state is faster than the [bound](Simulator::with_divergence_bound), stops at its last state, see [`status`](Self::status); the other states continue.
    ///
    /// * `inputs` – the input of one state after the other, length `len` × `nu` (N·m or N)
    ///
    /// # Panics
    /// If there are not as many inputs.
    #[inline]
    pub fn step(&mut self, inputs: &[f64]) {
        let Groups { len, all, steps } = &mut self.groups;
        let (nu, len, step) = (self.simulator.nu(), *len, *steps);
        assert_eq!(inputs.len(), len * nu, "len × nu inputs");
        *steps += 1;
        let simulator = &self.simulator;
        for_each_part(&mut self.workers, all, |worker, k, group| {
            let of = |lane: usize| (k * SINGLE_WIDTH + lane).min(len - 1) * nu;
            worker.set_input(group, |_, u| {
                for (j, u) in u.iter_mut().enumerate() {
                    *u = SingleScalar::from_values(|lane| inputs[of(lane) + j]);
                }
            });
            worker.step(simulator, step, group);
        });
    }

    /// A state, after the last step that did not diverge. Allocates.
    ///
    /// # Panics
    /// If there is no such state.
    #[inline]
    pub fn state(&self, i: usize) -> State {
        let (group, lane) = self.groups.at(i);
        group.lane(lane)
    }

    /// `Completed` if all steps were taken; otherwise the reason and the step at which the state stopped, counted from 0 since the batch was made.
    ///
    /// # Panics
    /// If there is no such state.
    #[inline]
    pub fn status(&self, i: usize) -> RolloutStatus {
        let (group, lane) = self.groups.at(i);
        group.status()[lane]
    }

    /// The first step of a state in which the solver of the forces of contact and constraints failed; `None` if it never did since the state was
    /// [`set`](Self::set).
    ///
    /// # Panics
    /// If there is no such state.
    #[inline]
    pub fn solver_failure(&self, i: usize) -> Option<SolverFailure> {
        let (group, lane) = self.groups.at(i);
        group.solver_failures()[lane]
    }

    /// Sets one state, which runs again if it had stopped. Does not allocate.
    ///
    /// # Panics
    /// If there is no such state, or if it has the wrong length.
    #[inline]
    pub fn set(&mut self, i: usize, state: &State) {
        self.groups.set(i, state);
    }
}
