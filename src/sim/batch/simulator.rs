//! The simulator of a batch.

use std::sync::Arc;

use super::group::Group;
use super::one_by_one::OneByOne;
use super::states::BatchStates;
use super::worker::Worker;
use super::{BATCH_WIDTH, BatchMoment, BatchScalar};
use crate::contact::Contacts;
use crate::error::StructureMismatch;
use crate::model::Model;
use crate::nested::IntoNested;
use crate::parallel::{available_threads, for_each_part};
use crate::scalar::{Lanes, from_each, has_lanes};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// Steps many states of one robot, or of variants of it, at once. All start from [`states`](Self::states).
///
/// # Examples
/// ```
/// use dualbody::{Simulator, State, model::samples, sim::{BatchSimulator, RolloutStatus}};
///
/// let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.01);
/// let starts: Vec<State> = (0..100).map(|k| State::new(&[0.01 * k as f64], &[0.0])).collect();
/// let mut batch = BatchSimulator::new(pendulum.clone(), starts.len());
/// let mut states = batch.states(&starts);
/// batch.step(&mut states, &[0.1; 100]);
/// assert_eq!(states.state(42), pendulum.step(&starts[42], &[0.1]));
/// assert_eq!(states.status(42), RolloutStatus::Completed);
/// ```
#[derive(Debug)]
pub struct BatchSimulator {
    /// Simulator with the time step, integrator, actuation and structure of all states.
    simulator: Simulator,
    /// Shared with clones: nothing changes them.
    variants: Option<Arc<Variants>>,
    len: usize,
    /// Whether states go through lanes.
    side_by_side: bool,
    workers: Vec<BatchWorker>,
}

/// Working memory of a thread.
#[derive(Debug)]
pub(super) enum BatchWorker {
    SideBySide(Box<Worker<BatchScalar>>),
    OneByOne(Box<OneByOne>),
}

impl BatchWorker {
    fn new(simulator: &Simulator, side_by_side: bool) -> Self {
        match side_by_side {
            true => Self::SideBySide(Box::new(Worker::new(simulator))),
            false => Self::OneByOne(Box::new(OneByOne::new(simulator))),
        }
    }
}

/// A simulator for each state, and the same in groups.
#[derive(Debug)]
pub(super) struct Variants {
    singles: Vec<Simulator>,
    groups: Vec<Simulator<BatchScalar>>,
    step: StepGroup,
}

impl Variants {
    /// The simulators of the groups.
    pub(super) fn groups(&self) -> &[Simulator<BatchScalar>] {
        &self.groups
    }

    /// The simulator of a lane of a group. Lanes that are left over repeat the last state.
    pub(super) fn of_lane(&self, group: usize, lane: usize) -> &Simulator {
        let i = group * BATCH_WIDTH + lane;
        &self.singles[i.min(self.singles.len() - 1)]
    }
}

/// A step of a group of variants: behind a pointer, so that programs that have variants compile the physics over their numbers, and others do not.
type StepGroup = fn(
    &mut Worker<BatchScalar>,
    &Simulator<BatchScalar>,
    usize,
    &mut Group<BatchScalar, BATCH_WIDTH>,
);

#[expect(
    clippy::len_without_is_empty,
    reason = "a count, none of which is rare"
)]
impl BatchSimulator {
    /// Makes a simulator of `len` states of one robot, on all cores.
    pub fn new(simulator: Simulator, len: usize) -> Self {
        Self::of(simulator, None, len)
    }

    /// Makes a simulator of one state per variant of a robot (domain randomisation). Variants have the same structure and other masses, lengths,
    /// damping, gravity and so on. Time step, integrator, actuation, contact models and points, terrain and constraints are those of `simulator`. All
    /// models must have the structure of its model.
    ///
    /// # Errors
    /// If the structure of a model differs from that of the simulator's model; the error names the model and the first difference.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, model::samples, sim::BatchSimulator};
    ///
    /// let simulator = Simulator::new(samples::cartpole());
    /// let damped = |k: u32| samples::cartpole().with_damping(1, 0.1 * f64::from(k));
    /// let batch = BatchSimulator::of_variants(&simulator, (0..10).map(damped).collect())?;
    /// assert_eq!((batch.len(), batch.simulator(3).model().damping()[1]), (10, 0.1 * 3.0));
    /// # Ok::<(), dualbody::StructureMismatch>(())
    /// ```
    #[inline]
    pub fn of_variants(
        simulator: &Simulator,
        models: Vec<Model>,
    ) -> Result<Self, StructureMismatch> {
        for (index, model) in models.iter().enumerate() {
            simulator.model().check_structure(model, index)?;
        }
        let groups = models.chunks(BATCH_WIDTH).map(|models| {
            let lanes = from_each(|lane| &models[lane.min(models.len() - 1)]);
            Ok(simulator.with_variant(Model::side_by_side(lanes)?))
        });
        let groups = groups.collect::<Result<_, StructureMismatch>>()?;
        let singles = models
            .into_iter()
            .map(|model| simulator.with_variant(model));
        let singles = singles.collect();
        Ok(Self::of_groups(simulator, singles, groups))
    }

    /// Makes a simulator of one state per variant of a simulation: the same robot, motors, contacts and forces with other parameters. Each state has its
    /// own row of [parameters](Simulator::parameters): masses, joint friction, gains and limits of motors, contact models, ground (each height of a
    /// grid), external forces and time step.
    ///
    /// * `parameters` – the rows of all states, one after the other, each as long as [`Simulator::parameters`]
    ///
    /// # Panics
    /// If the length is not a multiple of the number of parameters, or a value is outside of its domain: the message names it, as in
    /// [`Simulator::with_parameters`].
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, model::samples, sim::{Actuation, BatchSimulator}};
    ///
    /// let model = samples::cartpole(); // its rail ends at 2.4 m
    /// let actuation = Actuation::from_model(&model);
    /// let simulator = Simulator::new(model).with_actuation(actuation);
    /// let end = simulator.parameter_layout().find("linear: upper limit")?;
    /// let mut rows = vec![simulator.parameters(); 10];
    /// rows.iter_mut().enumerate().for_each(|(k, row)| row[end] = 0.1 + k as f64);
    /// let rows: Vec<f64> = rows.iter().flatten().copied().collect();
    /// let batch = BatchSimulator::of_parameters(&simulator, &rows);
    /// assert_eq!((batch.len(), batch.simulator(3).parameters()[end]), (10, 3.1));
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    #[inline]
    pub fn of_parameters(simulator: &Simulator, parameters: &[f64]) -> Self {
        let width = simulator.parameters().len();
        assert!(
            parameters.len().is_multiple_of(width),
            "{} numbers are not whole rows of the {width} parameters of \"{}\"",
            parameters.len(),
            simulator.model().name(),
        );
        let rows: Vec<&[f64]> = parameters.chunks_exact(width).collect();
        let singles = rows.iter().map(|row| simulator.with_parameters(row));
        let singles = singles.collect();
        let groups = rows.chunks(BATCH_WIDTH).map(|rows| {
            let of_lane = |j: usize, lane: usize| rows[lane.min(rows.len() - 1)][j];
            let number = |j| Lanes(from_each(|lane| of_lane(j, lane)));
            let lanes: Vec<BatchScalar> = (0..width).map(number).collect();
            simulator.with_parameters(&lanes)
        });
        let groups = groups.collect();
        Self::of_groups(simulator, singles, groups)
    }

    /// * `singles` – the simulator of each state
    /// * `groups` – the same in lanes
    #[inline]
    fn of_groups(
        simulator: &Simulator,
        singles: Vec<Simulator>,
        groups: Vec<Simulator<BatchScalar>>,
    ) -> Self {
        let len = singles.len();
        let step: StepGroup = Worker::step;
        let variants = Variants {
            singles,
            groups,
            step,
        };
        Self::of(simulator.clone(), Some(Arc::new(variants)), len)
    }

    fn of(simulator: Simulator, variants: Option<Arc<Variants>>, len: usize) -> Self {
        let singles = variants.iter().nested(|all| &all.singles);
        let may_bounce = simulator.may_bounce() || singles.into_iter().any(Simulator::may_bounce);
        let out = Self {
            variants,
            len,
            // The features that touch, the time of an impact, and what sleeps, differ from state to state.
            side_by_side: has_lanes()
                && !simulator.contacts().is_some_and(Contacts::have_pairs)
                && !may_bounce
                && simulator.sleeping().is_none(),
            workers: Vec::new(),
            simulator,
        };
        out.with_threads(available_threads())
    }

    /// Uses at most this many threads: the calling one, and others of rayon's pool. Without the feature `parallel` there is always one thread. Results
    /// do not depend on the number of threads. With debug assertions the calling thread, whose stack may be too small, only waits for the pool.
    ///
    /// Unless the program has made rayon's global pool, its threads get stacks of 8 MiB, or of the size in the variable `RUST_MIN_STACK`. In builds
    /// without optimisation, steps of batches may need more than the 2 MiB that other threads have by default, including those of pools that the
    /// program makes.
    ///
    /// # Panics
    /// If it is zero.
    #[must_use]
    pub fn with_threads(mut self, threads: usize) -> Self {
        assert!(threads > 0, "at least one thread is needed");
        let groups = self.len.div_ceil(BATCH_WIDTH);
        self.workers.clear();
        self.add_workers(threads.min(groups).max(1));
        self
    }

    /// Steps the states one by one with the code for a single state. This is automatic on a CPU without [registers for
    /// lanes](crate::Lanes::is_supported). Results do not depend on it.
    #[doc(hidden)]
    #[must_use]
    pub fn with_states_one_by_one(mut self) -> Self {
        self.side_by_side = false;
        let threads = self.threads();
        self.with_threads(threads)
    }

    fn add_workers(&mut self, n: usize) {
        let worker = || BatchWorker::new(&self.simulator, self.side_by_side);
        self.workers.extend(std::iter::repeat_with(worker).take(n));
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.len
    }

    /// The maximum number of threads.
    pub fn threads(&self) -> usize {
        self.workers.len()
    }

    /// The simulator of one state.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn simulator(&self, i: usize) -> &Simulator {
        assert!(i < self.len, "there are {} states, got state {i}", self.len);
        let own = self.variants.as_ref().map(|variants| &variants.singles[i]);
        own.unwrap_or(&self.simulator)
    }

    /// The simulator whose time step, integrator, actuation and structure all have.
    pub(crate) fn template(&self) -> &Simulator {
        &self.simulator
    }

    /// Number of inputs of one state.
    pub(crate) fn nu(&self) -> usize {
        self.simulator.nu()
    }

    /// Packs states into lanes. Allocates. [Check](State::check) states from outside the program first.
    ///
    /// # Panics
    /// If there are not as many as the simulator was made for, or if one has the wrong length.
    pub fn states(&self, states: &[State]) -> BatchStates {
        assert_eq!(states.len(), self.len, "the number of states");
        BatchStates::new(&self.simulator, states)
    }

    /// Advances all states by one time step, each with its own input held constant. With one thread it does not allocate; with several threads rayon may.
    ///
    /// A state whose input or next state is not finite, or whose next state exceeds the [divergence bound](Simulator::with_divergence_bound), stops,
    /// and [`BatchStates::status`] reports this; the other states continue.
    ///
    /// * `inputs` – the input of one state after the other, length `len` × `nu` (N·m or N)
    ///
    /// # Panics
    /// If the states belong to another robot, or the number of states or inputs is wrong.
    pub fn step(&mut self, states: &mut BatchStates, inputs: &[f64]) {
        self.step_times(states, inputs, 1);
    }

    /// Advances all states by several time steps with the same input, for a policy that acts less often than the simulator steps. Bit-identical to as many calls of
    /// [`step`](Self::step), in less time.
    ///
    /// * `times` – number of time steps
    ///
    /// # Panics
    /// As [`step`](Self::step).
    pub fn step_times(&mut self, states: &mut BatchStates, inputs: &[f64], times: usize) {
        let (step, nu) = (states.groups.steps, self.nu());
        self.check_step(states, inputs);
        states.groups.steps += times;
        let len = self.len;
        self.for_each(&mut states.groups.all, |stepper, k, group| {
            let moment = BatchMoment::new(k, len);
            for step in step..step + times {
                stepper.set_input(group, |_, u| {
                    for (j, u) in u.iter_mut().enumerate() {
                        *u = moment.gather(|i| inputs[i * nu + j]);
                    }
                });
                stepper.step(step, group);
            }
        });
    }

    /// Refuses states of another robot or number, and inputs of another length.
    pub(super) fn check_step(&self, states: &BatchStates, inputs: &[f64]) {
        assert_eq!(states.len(), self.len, "the number of states");
        let is_own = states.robot == self.simulator.model().structure();
        assert!(is_own, "the states are of another robot");
        assert_eq!(inputs.len(), self.len * self.nu(), "len × nu inputs");
    }

    /// The simulator, its variants, and the working memory of threads.
    pub(super) fn parts(&mut self) -> (&Simulator, Option<&Variants>, &mut [BatchWorker]) {
        (&self.simulator, self.variants.as_deref(), &mut self.workers)
    }

    /// Passes each item to a thread, with the worker that steps the group of the same index.
    pub(super) fn for_each<I: Send>(
        &mut self,
        items: &mut [I],
        work: impl Fn(&mut Stepper<'_>, usize, &mut I) + Sync,
    ) {
        let (simulator, variants) = (&self.simulator, &self.variants);
        for_each_part(&mut self.workers, items, |worker, k, item| {
            let variants = variants.as_deref();
            let mut stepper = Stepper {
                simulator,
                variants,
                group: k,
                worker,
            };
            work(&mut stepper, k, item);
        });
    }
}

/// With working memory of its own.
impl Clone for BatchSimulator {
    fn clone(&self) -> Self {
        let mut out = Self {
            simulator: self.simulator.clone(),
            variants: self.variants.clone(),
            len: self.len,
            side_by_side: self.side_by_side,
            workers: Vec::new(),
        };
        out.add_workers(self.threads());
        out
    }
}

/// Steps one group of states.
pub(super) struct Stepper<'a> {
    simulator: &'a Simulator,
    variants: Option<&'a Variants>,
    /// Index of the group.
    pub(super) group: usize,
    worker: &'a mut BatchWorker,
}

impl Stepper<'_> {
    /// Lets `control` set the input of the next step, which starts at zero.
    #[inline]
    pub(super) fn set_input(
        &mut self,
        group: &Group<BatchScalar, BATCH_WIDTH>,
        control: impl FnOnce(&State<BatchScalar>, &mut [BatchScalar]),
    ) {
        match self.worker {
            BatchWorker::SideBySide(worker) => worker.set_input(group, control),
            BatchWorker::OneByOne(worker) => worker.set_input(group, control),
        }
    }

    /// The time step of each lane, s.
    pub(super) fn time_step(&self) -> BatchScalar {
        let own = self.variants.map(|all| all.groups[self.group].time_step());
        own.unwrap_or_else(|| BatchScalar::from(self.simulator.time_step()))
    }

    /// Takes a step with the input that was set. Not generic, so that programs with control laws of their own do not compile the physics again.
    pub(super) fn step(&mut self, step: usize, group: &mut Group<BatchScalar, BATCH_WIDTH>) {
        match (&mut *self.worker, self.variants) {
            (BatchWorker::SideBySide(worker), None) => worker.step(self.simulator, step, group),
            (BatchWorker::SideBySide(worker), Some(all)) => {
                (all.step)(worker, &all.groups[self.group], step, group);
            }
            (BatchWorker::OneByOne(worker), variants) => {
                let of_lane = |lane: usize| match variants {
                    Some(all) => all.of_lane(self.group, lane),
                    None => self.simulator,
                };
                worker.step(of_lane, step, group);
            }
        }
    }
}
