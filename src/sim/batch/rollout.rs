//! Trajectories of a batch.

use nalgebra::DVector;

use super::group::Group;
use super::simulator::BatchSimulator;
use super::{BATCH_WIDTH, BatchMoment, BatchScalar};
use crate::memory;
use crate::model::Structure;
use crate::sim::state::State;
use crate::sim::status::{RolloutStatus, SolverFailure};

/// The trajectories of a batch. Each ends at its last finite state. The default has no trajectories.
#[derive(Clone, Debug, Default)]
pub struct BatchRollout {
    /// Time between two states, s.
    pub time_step: f64,
    len: usize,
    /// Requested steps.
    steps: usize,
    nq: usize,
    nv: usize,
    n_contact: usize,
    n_activation: usize,
    n_sleep: usize,
    /// Structure of the robot that they are of.
    robot: Structure,
    groups: Vec<Group<BatchScalar, BATCH_WIDTH>>,
    /// One trajectory after the other, those of the lanes that fill up the last group too: (q, v, state of contact) after each step.
    numbers: Vec<f64>,
}

/// The trajectories of one group while they grow.
struct Trajectories<'a> {
    group: &'a mut Group<BatchScalar, BATCH_WIDTH>,
    numbers: &'a mut [f64],
}

impl BatchSimulator {
    /// Takes `steps` steps from each of the initial states; `control(moment, states, u)` sets the input of the states in the lanes of one
    /// group (u starts at zero). Several threads call it, and a thread finishes all steps of a group before the next group.
    ///
    /// A trajectory stops at the first input or state that is not finite, or exceeds the [divergence bound](crate::Simulator::with_divergence_bound),
    /// and its status reports this; the other trajectories continue. If all states together would need more memory than the [limit](crate::memory),
    /// all trajectories stop before the first step.
    ///
    /// # Panics
    /// If the states are not as many as the simulator was made for, or if one has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, sim::BatchSimulator};
    ///
    /// let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.01);
    /// let starts: Vec<State> = (0..100).map(|k| State::new(&[0.01 * k as f64], &[0.0])).collect();
    /// let mut batch = BatchSimulator::new(pendulum, starts.len());
    /// // Damped by hand: u = −0.5 v
    /// let rollout = batch.rollout(&starts, 1000, |_, states, u| u[0] = states.v[0] * -0.5);
    /// assert!((0..100).all(|i| rollout.last(i).q[0].abs() < 1e-2));
    /// ```
    pub fn rollout(
        &mut self,
        initial: &[State],
        steps: usize,
        control: impl Fn(&BatchMoment, &State<BatchScalar>, &mut [BatchScalar]) + Sync,
    ) -> BatchRollout {
        let mut out = BatchRollout::default();
        self.rollout_into(initial, steps, control, &mut out);
        out
    }

    /// [`rollout`](Self::rollout) into the memory of an earlier rollout, which is reused if the numbers of states and steps are equal. The first
    /// write to new memory takes longer than a step of a small robot.
    ///
    /// # Panics
    /// If the states are not as many as the simulator was made for, or if one has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, sim::{BatchRollout, BatchSimulator}};
    ///
    /// let mut batch = BatchSimulator::new(Simulator::new(samples::pendulum()), 1);
    /// let mut rollout = BatchRollout::default();
    /// for angle in [0.0, 0.1] {
    ///     batch.rollout_into(&[State::new(&[angle], &[0.0])], 10, |_, _, _| {}, &mut rollout);
    ///     assert_eq!((rollout.q(0, 0)[0], rollout.n_states(0)), (angle, 11));
    /// }
    /// ```
    pub fn rollout_into(
        &mut self,
        initial: &[State],
        steps: usize,
        control: impl Fn(&BatchMoment, &State<BatchScalar>, &mut [BatchScalar]) + Sync,
        out: &mut BatchRollout,
    ) {
        let fits = out.start(self, self.states(initial).groups.all, steps);
        let steps = if fits { steps } else { 0 };
        let (len, time_step) = (self.len(), out.time_step);
        self.for_each(&mut out.trajectories(), |stepper, k, own| {
            let moment = BatchMoment::new(k, len);
            own.record(0, steps);
            for step in 0..steps {
                let moment = moment.at(step, time_step);
                stepper.set_input(own.group, |state, u| control(&moment, state, u));
                stepper.step(step, own.group);
                if own.group.all_stopped() {
                    break;
                }
                own.record(step + 1, steps);
            }
            if !fits {
                own.group.stop(RolloutStatus::OutOfMemory { step: 0 });
            }
        });
    }

    /// [`rollout`](Self::rollout) with given inputs.
    ///
    /// * `inputs` – inputs of all steps of the first state, then of the next state, and so on, length `len` × `steps` × `nu` (N·m or N)
    ///
    /// # Panics
    /// If the number of states or inputs is wrong.
    pub fn rollout_inputs(
        &mut self,
        initial: &[State],
        steps: usize,
        inputs: &[f64],
    ) -> BatchRollout {
        let nu = self.nu();
        let expected = self.len().checked_mul(steps);
        let expected = expected.and_then(|n| n.checked_mul(nu));
        assert_eq!(Some(inputs.len()), expected, "len × steps × nu inputs");
        self.rollout(initial, steps, |moment, _, u| {
            for (j, u) in u.iter_mut().enumerate() {
                *u = moment.gather(|i| inputs[(i * steps + moment.step) * nu + j]);
            }
        })
    }
}

impl Trajectories<'_> {
    /// Writes down the state after `step` of `steps` steps.
    fn record(&mut self, step: usize, steps: usize) {
        let state = &self.group.state;
        let width = state.len();
        for lane in 0..BATCH_WIDTH {
            let start = (lane * (steps + 1) + step) * width;
            let row = &mut self.numbers[start..start + width];
            row.iter_mut()
                .zip(state.numbers())
                .for_each(|(x, y)| *x = y.0[lane]);
        }
    }
}

#[expect(
    clippy::len_without_is_empty,
    reason = "a count, none of which is rare"
)]
impl BatchRollout {
    /// Makes room for trajectories of a simulator; where there is not enough, for their first states, and returns `false`.
    fn start(
        &mut self,
        simulator: &BatchSimulator,
        groups: Vec<Group<BatchScalar, BATCH_WIDTH>>,
        steps: usize,
    ) -> bool {
        let (template, len) = (simulator.template(), simulator.len());
        let (model, n_contact) = (template.model(), template.n_contact());
        let (n_activation, n_sleep) = (template.n_activation(), template.n_sleep());
        let n_beside = n_contact + n_activation + n_sleep;
        let (nq, nv, time_step) = (model.nq(), model.nv(), template.time_step());
        let mut numbers = std::mem::take(&mut self.numbers);
        let length = |steps| length(steps, nq + nv + n_beside, groups.len());
        if Some(numbers.len()) != length(steps) {
            numbers = length(steps).and_then(zeros).unwrap_or_default();
        }
        let fits = Some(numbers.len()) == length(steps);
        if !fits {
            numbers = vec![0.0; length(0).unwrap_or_default()];
        }
        let steps = if fits { steps } else { 0 };
        *self = Self {
            time_step,
            len,
            steps,
            nq,
            nv,
            n_contact,
            n_activation,
            n_sleep,
            robot: model.structure(),
            groups,
            numbers,
        };
        fits
    }

    /// The groups, each with the memory of its trajectories.
    fn trajectories(&mut self) -> Vec<Trajectories<'_>> {
        let length = BATCH_WIDTH * (self.steps + 1) * self.width();
        let mut rest = self.numbers.as_mut_slice();
        let with_memory = self.groups.iter_mut().map(|group| {
            let (numbers, others) = std::mem::take(&mut rest).split_at_mut(length);
            rest = others;
            Trajectories { group, numbers }
        });
        with_memory.collect()
    }

    /// Number of trajectories.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Status of a trajectory at its end.
    ///
    /// # Panics
    /// If there is no such trajectory.
    pub fn status(&self, i: usize) -> RolloutStatus {
        assert!(
            i < self.len,
            "there are {} trajectories, got trajectory {i}",
            self.len
        );
        self.groups[i / BATCH_WIDTH].status()[i % BATCH_WIDTH]
    }

    /// The first step of a trajectory in which the solver of the forces of contact and constraints failed; `None` if it never did.
    ///
    /// # Panics
    /// If there is no such trajectory.
    pub fn solver_failure(&self, i: usize) -> Option<SolverFailure> {
        assert!(
            i < self.len,
            "there are {} trajectories, got trajectory {i}",
            self.len
        );
        self.groups[i / BATCH_WIDTH].solver_failures()[i % BATCH_WIDTH]
    }

    /// Number of states of a trajectory: one more than its steps.
    ///
    /// # Panics
    /// If there is no such trajectory.
    pub fn n_states(&self, i: usize) -> usize {
        1 + match self.status(i) {
            RolloutStatus::Completed => self.steps,
            RolloutStatus::NonFiniteInput { step }
            | RolloutStatus::Diverged { step }
            | RolloutStatus::OutOfMemory { step } => step,
        }
    }

    /// All states of a trajectory as rows of their numbers (q, v, contact state, activations), one after the other.
    ///
    /// # Panics
    /// If there is no such trajectory.
    pub fn rows(&self, i: usize) -> &[f64] {
        let width = self.width();
        let length = self.n_states(i) * width;
        let start = i * (self.steps + 1) * width;
        &self.numbers[start..start + length]
    }

    /// Returns the memory of all trajectories without a copy. Trajectory `i` begins at `i` × (steps + 1) × (nq + nv +
    /// lengths of the contact state and of activations), and its first [`n_states`](Self::n_states) rows are [`rows`](Self::rows). The rest of each trajectory is
    /// unspecified.
    #[doc(hidden)]
    pub fn into_numbers(self) -> Vec<f64> {
        self.numbers
    }

    /// The configuration of trajectory `i` after `k` steps.
    ///
    /// # Panics
    /// If there is no such trajectory, or if it is shorter.
    pub fn q(&self, i: usize, k: usize) -> &[f64] {
        &self.row(i, k)[..self.nq]
    }

    /// The velocity of trajectory `i` after `k` steps.
    ///
    /// # Panics
    /// If there is no such trajectory, or if it is shorter.
    pub fn v(&self, i: usize, k: usize) -> &[f64] {
        &self.row(i, k)[self.nq..self.nq + self.nv]
    }

    /// The contact state of trajectory `i` after `k` steps.
    ///
    /// # Panics
    /// If there is no such trajectory, or if it is shorter.
    pub(crate) fn contact(&self, i: usize, k: usize) -> &[f64] {
        let first = self.nq + self.nv;
        &self.row(i, k)[first..first + self.n_contact]
    }

    /// The activations of trajectory `i` after `k` steps.
    ///
    /// # Panics
    /// If there is no such trajectory, or if it is shorter.
    pub(crate) fn activation(&self, i: usize, k: usize) -> &[f64] {
        let first = self.nq + self.nv + self.n_contact;
        &self.row(i, k)[first..first + self.n_activation]
    }

    /// Which trees sleep in trajectory `i` after `k` steps, as [`State::sleep`].
    ///
    /// # Panics
    /// If there is no such trajectory, or if it is shorter.
    pub(crate) fn sleep(&self, i: usize, k: usize) -> &[f64] {
        &self.row(i, k)[self.width() - self.n_sleep..]
    }

    /// The state of trajectory `i` after `k` steps. Allocates.
    ///
    /// # Panics
    /// If there is no such trajectory, or if it is shorter.
    pub fn state(&self, i: usize, k: usize) -> State {
        let contact = DVector::from_column_slice(self.contact(i, k));
        let activation = DVector::from_column_slice(self.activation(i, k));
        State {
            contact,
            activation,
            sleep: DVector::from_column_slice(self.sleep(i, k)),
            ..State::new(self.q(i, k), self.v(i, k))
        }
    }

    /// The last state of a trajectory. Allocates.
    ///
    /// # Panics
    /// If there is no such trajectory.
    pub fn last(&self, i: usize) -> State {
        self.state(i, self.n_states(i) - 1)
    }

    /// Checks that it is one of this batch.
    pub(crate) fn check_batch(&self, batch: &BatchSimulator) {
        let model = batch.template().model();
        let own = (self.robot, self.len) == (model.structure(), batch.len());
        let name = model.name();
        assert!(own, "the rollout is not one of this batch of \"{name}\"");
    }

    /// Numbers of a state.
    fn width(&self) -> usize {
        self.nq + self.nv + self.n_contact + self.n_activation + self.n_sleep
    }

    fn row(&self, i: usize, k: usize) -> &[f64] {
        let width = self.width();
        &self.rows(i)[k * width..(k + 1) * width]
    }
}

/// Numbers of the trajectories of so many groups; `None` if they cannot be counted.
fn length(steps: usize, width: usize, groups: usize) -> Option<usize> {
    let rows = steps.checked_add(1)?;
    rows.checked_mul(BATCH_WIDTH * width)?.checked_mul(groups)
}

/// Memory that is zero; `None` where there is not as much.
fn zeros(length: usize) -> Option<Vec<f64>> {
    let bytes = length.saturating_mul(size_of::<f64>());
    // Zeros from the system are not touched before they are used; memory that is reserved and then filled is.
    let fits = memory::check("trajectories", bytes).is_ok()
        && Vec::<f64>::new().try_reserve_exact(length).is_ok();
    fits.then(|| vec![0.0; length])
}
