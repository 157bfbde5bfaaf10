//! One step of time.

use castaway::cast;
use nalgebra::DVector;

use super::evaluation_point::EvaluationPoint;
use super::integrators::{AccelerationScratch, Step, StepMemory};
use super::signals::Signals;
use super::simulator::Simulator;
use super::sleep::Sleeper;
use super::state::State;
use crate::cone::Status;
use crate::dynamics::Calls;
use crate::scalar::{Opaque, Over, Scalar, compiled_over_f64, same};

/// Working memory of [`Simulator::step_into`]. It belongs to the model that it was made for and to clones of it; after a change of masses,
/// placements or armature a new one is needed.
#[derive(Clone, Debug)]
pub struct StepScratch<T: Scalar>(Opaque<Memory<T>>);

#[derive(Clone)]
struct Memory<T: Scalar> {
    acceleration: AccelerationScratch<T>,
    method: StepMemory<T>,
    /// Where an acceleration is found without a step.
    signals: Signals<T>,
    /// From the first step on whose simulator lets islands sleep.
    sleeper: Option<Box<Sleeper>>,
    /// Whether steps ignore what sleeps.
    awake: bool,
}

impl<T: Scalar> Memory<T> {
    fn new<P: Scalar>(simulator: &Simulator<P>, calls: Calls) -> Opaque<Self> {
        Opaque::new(Self {
            acceleration: AccelerationScratch::new(simulator, calls),
            method: StepMemory::new(simulator),
            signals: Signals::default(),
            sleeper: None,
            awake: false,
        })
    }
}

impl<T: Scalar> StepScratch<T> {
    /// Makes memory for a simulator.
    pub fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        Self::for_calls(simulator, Calls::Many)
    }

    /// Memory for a simulator that takes so many steps.
    pub(crate) fn for_calls<P: Scalar>(simulator: &Simulator<P>, calls: Calls) -> Self {
        Self(compiled_over_f64!(
            [P, T] Memory::new, simulator: &Simulator, calls: Calls => Opaque<Memory<f64>> as Opaque<Memory<T>>
        ))
    }

    /// Memory for steps that are differentiated: nothing sleeps in them, nor after them.
    pub(crate) fn awake<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let mut own = Self::new(simulator);
        own.0.get_mut().awake = true;
        own
    }

    /// Whether something slept in the last step, of whose forces and acceleration nothing is known.
    pub(crate) fn has_slept(&self) -> bool {
        let sleeper = self.0.get().sleeper.as_ref();
        sleeper.is_some_and(|sleeper| sleeper.some_sleep())
    }

    /// Acceleration and forces of the last step.
    pub(crate) fn acceleration(&self) -> &AccelerationScratch<T> {
        &self.0.get().acceleration
    }

    /// Starts the solver of contact forces from the forces of the last step with this memory, a *warm start*. This is a few times faster for piles that
    /// hardly move. Each step then also depends on this memory: forces may differ in their last digits, and redundant contacts may share a load
    /// differently. See [`SolverOptions::warm_start`](crate::contact::SolverOptions::warm_start) for rollouts.
    #[must_use]
    pub fn with_warm_start(mut self) -> Self {
        let acceleration = &mut self.0.get_mut().acceleration;
        acceleration.terms.contact.keep_for_next_step();
        self
    }

    /// Status of the solver of the forces of contact and constraints, or of the search of an [implicit midpoint](super::Integrator::ImplicitMidpoint), in
    /// the last step, in a lane: the worst of all evaluations, and [`Converged`](Status::Converged) if none was needed. See
    /// [`ContactReport::certificate`](super::ContactReport) for its meaning.
    ///
    /// # Panics
    /// If there is no such lane.
    pub fn solver_status(&self, lane: usize) -> Status {
        assert!(
            lane < T::LANES,
            "there are {} lanes, got lane {lane}",
            T::LANES
        );
        let memory = self.0.get();
        if memory.sleeper.as_ref().is_some_and(|own| own.all_sleep()) {
            return Status::Converged;
        }
        let balance = memory.acceleration.balance.as_ref();
        let of_rows = balance.map_or(Status::Converged, |balance| balance.status(lane));
        of_rows.max(memory.method.status(lane))
    }
}

impl Simulator {
    /// A step in which sleeping islands stay as they are.
    fn step_some(&self, state: &State, u: &[f64], memory: &mut Memory<f64>, next: &mut State) {
        let sleeper = memory.sleeper.take();
        let mut sleeper = sleeper.unwrap_or_else(|| Box::new(Sleeper::new(self)));
        sleeper.find(self, state);
        if next.sleep.len() != self.n_sleep() {
            next.sleep = DVector::zeros(self.n_sleep());
        }
        if sleeper.all_sleep() && self.activations().is_empty() {
            next.copy_from(state);
        } else {
            let contact = &mut memory.acceleration.terms.contact;
            contact.leave_out(sleeper.bodies());
            self.step_all(state, u, memory, next);
            sleeper.settle(self, state, &memory.acceleration.terms.contact, next);
        }
        memory.sleeper = Some(sleeper);
    }
}

impl<P: Scalar> Simulator<P> {
    /// Advances by one time step with the input `u` (length `nu`; N·m or N) held constant. Allocates.
    ///
    /// # Panics
    /// If state or input have the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples};
    ///
    /// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    /// let next = simulator.step(&State::new(&[std::f64::consts::FRAC_PI_2], &[0.0]), &[0.0]);
    /// assert!((next.v[0] + 0.01 * 1.5 * 9.81).abs() < 1e-12); // v̇ = −3 g / 2 l, held for a step
    /// ```
    pub fn step<T: Over<P>>(&self, state: &State<T>, u: &[T]) -> State<T> {
        let mut next = state.clone();
        let mut scratch = StepScratch::for_calls(self, Calls::One);
        self.step_into(state, u, &mut scratch, &mut next);
        next
    }

    /// [`step`](Self::step) without allocation, except the first semi-implicit Euler step with fast rotation, see [`Integrator`](super::Integrator).
    ///
    /// # Panics
    /// If state, input or output have the wrong length.
    pub fn step_into<T: Over<P>>(
        &self,
        state: &State<T>,
        u: &[T],
        scratch: &mut StepScratch<T>,
        next: &mut State<T>,
    ) {
        let (simulator, memory) = (self, &mut scratch.0);
        compiled_over_f64!(
            [P, T] Simulator::step_with, simulator: &Simulator, state: &State, u: &[f64], memory: &mut Opaque<Memory<f64>>, next: &mut State
        );
    }

    fn step_with<T: Over<P>>(
        &self,
        state: &State<T>,
        u: &[T],
        memory: &mut Opaque<Memory<T>>,
        next: &mut State<T>,
    ) {
        self.check_input(u);
        self.check(state);
        let memory = memory.get_mut();
        if const { P::IS_F64 && T::IS_F64 } && self.n_sleep() > 0 && !memory.awake {
            let simulator = same(cast!(self, &Simulator));
            let (state, u) = (same(cast!(state, &State)), same(cast!(u, &[f64])));
            let memory = same(cast!(memory, &mut Memory<f64>));
            return simulator.step_some(state, u, memory, same(cast!(next, &mut State)));
        }
        assert!(
            T::HAS_VALUES || self.n_sleep() == 0,
            "the steps of \"{}\" decide on values, since islands sleep: record them with_sleeping(None)",
            self.model().name(),
        );
        next.sleep.fill(T::zero());
        self.step_all(state, u, memory, next);
    }

    /// A step in which nothing sleeps.
    fn step_all<T: Over<P>>(
        &self,
        state: &State<T>,
        u: &[T],
        memory: &mut Memory<T>,
        next: &mut State<T>,
    ) {
        let Memory {
            acceleration,
            method,
            ..
        } = memory;
        if let Some(balance) = &mut acceleration.balance {
            balance.forget();
        }
        if !method.is_of(self.integrator()) {
            *method = StepMemory::new(self);
        }
        method.step(self, state, u, acceleration, next);
    }

    /// The acceleration v̇ of a state under the input `u` (length `nu`; N·m or N), length `nv` (rad/s² or m/s²):
    /// [`acceleration_into`](Self::acceleration_into) with memory of its own. Allocates.
    ///
    /// # Panics
    /// If state or input have the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples};
    ///
    /// let pendulum = Simulator::new(samples::pendulum());
    /// let a = pendulum.acceleration(&State::new(&[0.0], &[0.0]), &[2.0]);
    /// assert!((a[0] - 6.0).abs() < 1e-14); // 3 u / (m l²)
    /// ```
    pub fn acceleration<T: Over<P>>(&self, state: &State<T>, u: &[T]) -> DVector<T> {
        let mut scratch = StepScratch::for_calls(self, Calls::One);
        DVector::from_column_slice(self.acceleration_into(state, u, &mut scratch))
    }

    /// The acceleration v̇ of a state under the input `u`: forward dynamics with actuation, springs and damping at that state. A Runge–Kutta step
    /// integrates this acceleration. The acceleration of an Euler step differs: it contains some forces at the end of the step, see
    /// [`Integrator`](super::Integrator). Does not allocate.
    ///
    /// * `u` – input, length `nu` (N·m or N)
    ///
    /// Returns v̇, length `nv` (rad/s² or m/s²), a slice of the working memory.
    ///
    /// # Panics
    /// If state or input have the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, sim::StepScratch};
    ///
    /// // v̇ = 3 u / (m l²) − (3 g / 2 l) sin q with 1 kg and 1 m
    /// let pendulum = Simulator::new(samples::pendulum());
    /// let mut scratch = StepScratch::new(&pendulum);
    /// let a = pendulum.acceleration_into(&State::new(&[0.0], &[0.0]), &[2.0], &mut scratch);
    /// assert!((a[0] - 6.0).abs() < 1e-14);
    /// ```
    pub fn acceleration_into<'s, T: Over<P>>(
        &self,
        state: &State<T>,
        u: &[T],
        scratch: &'s mut StepScratch<T>,
    ) -> &'s [T] {
        let (simulator, memory) = (self, &mut scratch.0);
        compiled_over_f64!(
            [P, T] Simulator::accelerate_with, simulator: &Simulator, state: &State, u: &[f64], memory: &mut Opaque<Memory<f64>>
        );
        &scratch.0.get().acceleration.a
    }

    fn accelerate_with<T: Over<P>>(
        &self,
        state: &State<T>,
        u: &[T],
        memory: &mut Opaque<Memory<T>>,
    ) {
        let memory = memory.get_mut();
        self.check_input(u);
        self.check(state);
        let signal = memory.signals.find(self, state, u);
        self.accelerate(
            &EvaluationPoint::instant(self, state, signal),
            &mut memory.acceleration,
        );
    }
}
