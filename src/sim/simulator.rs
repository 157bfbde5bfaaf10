//! The simulator: a model, how it is actuated, and how time passes.

use super::integrator::{Integrator, StepScratch};
use super::state::State;
use crate::dynamics::{forward_dynamics_into, passive_forces_into};
use crate::error::UnknownName;
use crate::model::Model;
use crate::scalar::{Over, Scalar};

/// Time step where nothing else is said, s.
const DEFAULT_TIME_STEP: f64 = 1e-3;

/// Steps a robot through time.
///
/// The equation of motion is  M(q) v̇ + h(q, v) = S u − k (q − rest) − d v  with the input u on the actuated joints, and springs
/// and viscous damping of the model. Joints that follow others have no input of their own. The input is constant over a step.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, State, model::samples};
///
/// let simulator = Simulator::new(samples::cartpole())
///     .with_time_step(0.01)
///     .with_actuated_joints(&["linear"])?;
/// let next = simulator.step(&State::new(&[0.0, 0.0], &[0.0, 0.0]), &[1.0]);
/// assert!(next.v[0] > 0.0);
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
#[derive(Clone, Debug)]
pub struct Simulator<P = f64> {
    model: Model<P>,
    time_step: f64,
    integrator: Integrator,
    /// The velocity coordinates on which the entries of u act.
    actuated: Vec<usize>,
}

impl<P: Scalar> Simulator<P> {
    /// A simulator with a time step of 1 ms, semi-implicit Euler, and every named joint actuated.
    pub fn new(model: Model<P>) -> Self {
        let independent = model
            .joints()
            .iter()
            .filter(|joint| model.body(joint.body).coupling.is_none());
        let actuated = independent.flat_map(|joint| {
            let body = model.body(joint.body);
            body.v..body.v + body.joint.nv()
        });
        let actuated = actuated.collect();
        Self {
            model,
            time_step: DEFAULT_TIME_STEP,
            integrator: Integrator::default(),
            actuated,
        }
    }

    /// Sets the time step, s.
    ///
    /// # Panics
    /// If it is not positive and finite.
    #[must_use]
    pub fn with_time_step(mut self, time_step: f64) -> Self {
        assert!(
            time_step > 0.0 && time_step.is_finite(),
            "a time step of {time_step} s is not positive and finite"
        );
        self.time_step = time_step;
        self
    }

    /// Sets the integrator.
    #[must_use]
    pub fn with_integrator(mut self, integrator: Integrator) -> Self {
        self.integrator = integrator;
        self
    }

    /// Lets the input act on these joints only, in this order; the others move freely.
    ///
    /// # Errors
    /// If the model has no joint of a name.
    pub fn with_actuated_joints(mut self, names: &[&str]) -> Result<Self, UnknownName> {
        let joints: Vec<_> = names
            .iter()
            .map(|name| self.model.find_joint(name))
            .collect::<Result<_, _>>()?;
        self.actuated = joints
            .into_iter()
            .flat_map(|joint| self.model.joint_v(joint))
            .collect();
        Ok(self)
    }

    /// The model.
    pub fn model(&self) -> &Model<P> {
        &self.model
    }

    /// The time step, s.
    pub fn time_step(&self) -> f64 {
        self.time_step
    }

    /// The integrator.
    pub fn integrator(&self) -> Integrator {
        self.integrator
    }

    /// Number of inputs: degrees of freedom of the actuated joints.
    pub fn nu(&self) -> usize {
        self.actuated.len()
    }

    /// The velocity coordinate on which each entry of the input acts, length `nu`.
    pub fn actuated(&self) -> &[usize] {
        &self.actuated
    }

    /// The same simulator over another scalar of model data: the step becomes differentiable in masses, lengths, gravity, damping.
    pub fn cast<Q: Over<P>>(&self) -> Simulator<Q> {
        self.with_model(self.model.cast())
    }

    /// The same time step, integrator and actuation with a variant of the model.
    pub(super) fn with_model<Q: Scalar>(&self, model: Model<Q>) -> Simulator<Q> {
        Simulator {
            model,
            time_step: self.time_step,
            integrator: self.integrator,
            actuated: self.actuated.clone(),
        }
    }

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
        self.step_into(state, u, &mut StepScratch::new(&self.model), &mut next);
        next
    }

    /// [`step`](Self::step) without allocation.
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
        self.check_input(u);
        self.integrator.advance(self, state, u, scratch, next);
    }

    /// The acceleration v̇ of a state under the input `u`: forward dynamics with actuation, springs and damping, which every step
    /// integrates. No allocation.
    ///
    /// * `u` – input, length `nu` (N·m or N)
    ///
    /// Returns v̇, length `nv` (rad/s² or m/s²), which stays in the scratch.
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
    /// let mut scratch = StepScratch::new(pendulum.model());
    /// let a = pendulum.acceleration_into(&State::new(&[0.0], &[0.0]), &[2.0], &mut scratch);
    /// assert!((a[0] - 6.0).abs() < 1e-14);
    /// ```
    pub fn acceleration_into<'s, T: Over<P>>(
        &self,
        state: &State<T>,
        u: &[T],
        scratch: &'s mut StepScratch<T>,
    ) -> &'s [T] {
        self.check_input(u);
        self.accelerate(state.q.as_slice(), state.v.as_slice(), u, scratch);
        &scratch.a
    }

    fn check_input<T>(&self, u: &[T]) {
        assert_eq!(
            u.len(),
            self.nu(),
            "the input of \"{}\" has nu = {} entries",
            self.model.name(),
            self.nu()
        );
    }

    /// v̇ at (q, v, u), left in the scratch.
    pub(super) fn accelerate<T: Over<P>>(
        &self,
        q: &[T],
        v: &[T],
        u: &[T],
        scratch: &mut StepScratch<T>,
    ) {
        // τ = S u − k (q − rest) − d v
        passive_forces_into(&self.model, q, v, &mut scratch.tau);
        for (&k, &u) in self.actuated.iter().zip(u) {
            scratch.tau[k] += u;
        }
        forward_dynamics_into(
            &self.model,
            q,
            v,
            &scratch.tau,
            &[],
            &mut scratch.aba,
            &mut scratch.a,
        );
    }
}
