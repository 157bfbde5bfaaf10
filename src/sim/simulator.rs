//! The simulator: a model, how it is actuated, and how time passes.

use super::integrator::{Integrator, StepScratch};
use super::state::State;
use nalgebra::DVector;

use super::actuation::{Actuation, End};
use super::constrained::Question;
use crate::constraint::Constraint;
use crate::contact::{ContactLaw, Contacts};
use crate::dynamics::{add_passive_forces, each_resistance, forward_dynamics_into};
use crate::error::UnknownName;
use crate::model::Model;
use crate::scalar::{Over, Scalar};

/// Time step where nothing else is said, s.
const DEFAULT_TIME_STEP: f64 = 1e-3;

/// Steps a robot through time.
///
/// The equation of motion is  M(q) v̇ + h(q, v) = A(q, v, S u) − k (q − rest) − d v + Σ Jᵢᵀ fᵢ  with the input u on the actuated
/// joints, their motors, friction and limits A ([`Actuation`]), springs and viscous damping of the model, and forces f of contact
/// ([`Contacts`]) and kinematic constraints ([`Constraint`]). Without these, A is the input itself and there is no f. Joints that follow others have no input of their own. The input is constant over a step.
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
    /// `None` for ideal motors without friction and limits.
    actuation: Option<Actuation<P>>,
    contacts: Option<Contacts<P>>,
    constraints: Vec<Constraint<P>>,
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
            actuation: None,
            contacts: None,
            constraints: Vec::new(),
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
    ///
    /// # Panics
    /// If there is contact that it cannot simulate: rigid contact acts over a step and needs semi-implicit Euler or implicit velocity.
    #[must_use]
    pub fn with_integrator(mut self, integrator: Integrator) -> Self {
        self.integrator = integrator;
        self.check_integrator();
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

    /// Puts motors, friction and limits between the input and the joints; without this call motors are ideal, and nothing limits or
    /// brakes a joint but the model's springs and damping. [`Actuation::from_model`] is what the description says.
    ///
    /// # Panics
    /// If it is that of another robot.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, sim::Actuation};
    ///
    /// let model = samples::cartpole(); // its rail ends at 2.4 m
    /// let actuation = Actuation::from_model(&model);
    /// let simulator = Simulator::new(model).with_actuation(actuation);
    /// let pushed = simulator.rollout(&State::new(&[2.0, 0.0], &[0.0, 0.0]), 2000, |_, _, u| u[0] = 10.0);
    /// assert!(pushed.last().q[0] < 2.41);
    /// ```
    #[must_use]
    pub fn with_actuation(mut self, actuation: Actuation<P>) -> Self {
        actuation.check(&self.model);
        self.actuation = Some(actuation);
        self
    }

    /// Puts the robot on a ground; without this call it touches nothing.
    ///
    /// # Panics
    /// If the integrator cannot simulate it: rigid contact acts over a step and needs semi-implicit Euler or implicit velocity. If the
    /// contacts are those of another robot, or a point is on a link or body that there is not.
    #[must_use]
    pub fn with_contacts(mut self, contacts: Contacts<P>) -> Self {
        contacts.check(&self.model);
        self.contacts = Some(contacts).filter(|contacts| !contacts.points().is_empty());
        self.check_integrator();
        self
    }

    /// Holds places of the robot together, or to the world; without this call nothing does but its joints. Start from a state that obeys them:
    /// [`assemble`](Self::assemble) finds one.
    ///
    /// # Panics
    /// If a constraint belongs to another model: joints are compared as a whole, frames by their number. If a number of an anchor is not finite.
    #[must_use]
    pub fn with_constraints(mut self, constraints: Vec<Constraint<P>>) -> Self {
        constraints.iter().for_each(|c| c.check(&self.model));
        self.constraints = constraints;
        self
    }

    fn check_integrator(&self) {
        let laws = self.contacts.iter().flat_map(Contacts::laws);
        let mut rigid = laws.filter(|law| matches!(law, ContactLaw::Rigid(_)));
        assert!(
            self.integrator != Integrator::RungeKutta4 || rigid.next().is_none(),
            "rigid contact acts over a step and needs semi-implicit Euler or implicit velocity, not {:?}",
            self.integrator
        );
    }

    /// Whether a solver finds some of the forces in a step.
    pub(super) fn needs_solver(&self) -> bool {
        self.has_solved_forces() || self.integrator == Integrator::ImplicitVelocity
    }

    /// Whether a solver finds some of the forces at a moment.
    fn has_solved_forces(&self) -> bool {
        let solved = self.contacts.as_ref().is_some_and(|c| !c.are_soft());
        solved || !self.constraints.is_empty()
    }

    /// What is between the input and the joints; `None` for ideal motors.
    pub fn actuation(&self) -> Option<&Actuation<P>> {
        self.actuation.as_ref()
    }

    /// Where the robot can touch the ground; `None` if nowhere.
    pub fn contacts(&self) -> Option<&Contacts<P>> {
        self.contacts.as_ref()
    }

    /// What holds places of the robot together.
    pub fn constraints(&self) -> &[Constraint<P>] {
        &self.constraints
    }

    /// How many numbers the state of contact has.
    pub fn n_contact(&self) -> usize {
        self.contacts.as_ref().map_or(0, Contacts::n_states)
    }

    /// Dimension of the tangent space of the state, 2 `nv` and the state of contact: rows and columns of A.
    pub fn n_tangent(&self) -> usize {
        2 * self.model.nv() + self.n_contact()
    }

    /// A state of this simulator whose bristles are straight. Allocates.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn state<T: Scalar>(&self, q: &[T], v: &[T]) -> State<T> {
        self.model.check_q(q);
        self.model.check_v(v);
        State::new(q, v).with_contact(DVector::zeros(self.n_contact()))
    }

    /// The neutral configuration at rest, with straight bristles. Allocates.
    pub fn neutral_state<T: Scalar>(&self) -> State<T> {
        State::neutral(&self.model).with_contact(DVector::zeros(self.n_contact()))
    }

    /// Checks the length of a state.
    pub(crate) fn check<T: Scalar>(&self, state: &State<T>) {
        self.model.check_q(state.q.as_slice());
        self.model.check_v(state.v.as_slice());
        assert_eq!(
            state.contact.len(),
            self.n_contact(),
            "the state of contact of \"{}\" has {} entries; Simulator::state makes a state with them",
            self.model.name(),
            self.n_contact()
        );
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

    /// The same simulator with a variant of the model, of the same structure.
    pub(super) fn with_model<Q: Over<P>>(&self, model: Model<Q>) -> Simulator<Q> {
        Simulator {
            model,
            time_step: self.time_step,
            integrator: self.integrator,
            actuated: self.actuated.clone(),
            actuation: self.actuation.as_ref().map(Actuation::cast),
            contacts: self.contacts.as_ref().map(Contacts::cast),
            constraints: self.constraints.iter().map(Constraint::cast).collect(),
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
        self.step_into(state, u, &mut StepScratch::new(self), &mut next);
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
        self.check(state);
        self.integrator.advance(self, state, u, scratch, next);
    }

    /// The acceleration v̇ of a state under the input `u`: forward dynamics with actuation, springs and damping, which every step
    /// integrates; one that is implicit in velocity starts from it. No allocation.
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
        self.check_input(u);
        self.check(state);
        self.accelerate(state, u, scratch);
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

    /// v̇ and the rates of contact at a state with input u, left in the scratch.
    pub(super) fn accelerate<T: Over<P>>(
        &self,
        state: &State<T>,
        u: &[T],
        scratch: &mut StepScratch<T>,
    ) {
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        self.joint_forces_into(q, v, u, &mut scratch.tau);
        if self.has_solved_forces() {
            return self.find_forces(state, false, scratch);
        }
        let contact = &mut scratch.contact;
        if let Some(contacts) = &self.contacts {
            contact.press(&self.model, contacts, state);
        }
        forward_dynamics_into(
            &self.model,
            q,
            v,
            &scratch.tau,
            &scratch.contact.external,
            &mut scratch.aba,
            &mut scratch.a,
        );
    }

    /// The v̇ with which the integrator steps, and the rates of contact, left in the scratch: those at the state, or over the step where it
    /// is implicit in velocity.
    pub(super) fn accelerate_for_step<T: Over<P>>(
        &self,
        state: &State<T>,
        u: &[T],
        scratch: &mut StepScratch<T>,
    ) {
        if self.integrator != Integrator::ImplicitVelocity {
            return self.accelerate(state, u, scratch);
        }
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        self.driving_forces_into(q, v, u, &mut scratch.tau);
        self.find_forces(state, true, scratch);
    }

    fn find_forces<T: Over<P>>(
        &self,
        state: &State<T>,
        implicit: bool,
        scratch: &mut StepScratch<T>,
    ) {
        let StepScratch {
            constrained,
            contact,
            tau,
            a,
            ..
        } = scratch;
        let question = Question {
            simulator: self,
            state,
            tau,
            implicit,
        };
        let constrained = constrained.as_mut();
        constrained
            .expect("scratch of a simulator with the same parts")
            .solve(&question, contact, a);
    }

    /// τ = A(q, v, S u) − k (q − rest) − d v, with the actuators A.
    pub(crate) fn joint_forces_into<T: Over<P>>(&self, q: &[T], v: &[T], u: &[T], tau: &mut [T]) {
        self.driving_forces_into(q, v, u, tau);
        if let Some(actuation) = &self.actuation {
            actuation.stop(&self.model, q, v, tau);
        }
    }

    /// The same without stops.
    pub(crate) fn driving_forces_into<T: Over<P>>(&self, q: &[T], v: &[T], u: &[T], tau: &mut [T]) {
        tau.fill(T::zero());
        for (&k, &u) in self.actuated.iter().zip(u) {
            tau[k] = u;
        }
        if let Some(actuation) = &self.actuation {
            actuation.drive(v, tau);
        }
        add_passive_forces(&self.model, q, v, tau);
    }

    /// Hands what every coordinate loses of its force by a velocity and by a displacement that grow to `each(coordinate, c, k)`, at the
    /// velocity `v`.
    pub(crate) fn each_resistance<T: Over<P>>(&self, v: &[T], mut each: impl FnMut(usize, T, T)) {
        each_resistance(&self.model, |k, damping, stiffness| {
            let own = self.actuation.as_ref();
            let own = own.map_or(T::zero(), |actuation| actuation.damping(k, v[k]));
            each(k, own + damping, stiffness.into());
        });
    }

    /// Hands every end of every joint that has a stop to `each(coordinate, end)`, at the configuration `q`.
    pub(crate) fn each_end<T: Over<P>>(&self, q: &[T], each: impl FnMut(usize, &End<'_, P, T>)) {
        if let Some(actuation) = &self.actuation {
            actuation.each_end(&self.model, q, each);
        }
    }
}
