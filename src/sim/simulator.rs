//! The simulator: a model, its actuation, contacts and constraints, and an integrator.

use std::collections::HashSet;

use nalgebra::DVector;

use super::activation::PlacedActivation;
use super::actuation::{Actuation, TendonServo};
use super::force::FrameTerms;
use super::integrator::Integrator;
use super::sleeping::{Sleeping, n_sleep};
use super::state::State;
use crate::constraint::Constraint;
use crate::contact::Contacts;
use crate::dynamics::each_passive;
use crate::error::{StructureMismatch, UnknownName};
use crate::memory;
use crate::model::manifold::v_range;
use crate::model::{JointPart, Model};
use crate::nested::IntoNested;
use crate::numbers::{Domain, Numbers};
use crate::scalar::{Cast, Over, Scalar, is_more_than_values};

/// Default time step, s.
const DEFAULT_TIME_STEP: f64 = 1e-3;

/// Default divergence threshold, rad/s or m/s: ten million turns a minute, and three thousand times the
/// speed of sound. The fastest rotors of all reach a fiftieth of it, and forces of such motion are still far from overflow.
const DEFAULT_DIVERGENCE_BOUND: f64 = 1e6;

/// Steps a robot through time.
///
/// The equation of motion is  M(q) v̇ + h(q, v) = A(q, v, S u) − k (q − rest) − d v + Σ Jᵢᵀ Fᵢ  with the input u on the actuated
/// joints, their motors, friction and limits A ([`Actuation`]), springs and viscous damping of the model, and forces F of contacts ([`Contacts`]),
/// kinematic constraints ([`Constraint`]), external forces ([`ExternalForce`](super::ExternalForce)) and actuators that are not at joints
/// ([`FrameActuator`](super::FrameActuator)), whose inputs are the last entries of u. Without these, A is the input itself and F is zero. Mimic
/// joints have no input. The input is constant over a step.
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
    pub(super) model: Model<P>,
    /// s.
    pub(super) time_step: P,
    /// Largest speed of a coordinate in a rollout, rad/s or m/s.
    divergence_bound: f64,
    integrator: Integrator,
    /// The velocity coordinates on which the entries of u act.
    actuated: Vec<usize>,
    /// `None` for ideal motors without friction and limits.
    pub(super) actuation: Option<Actuation<P>>,
    pub(super) contacts: Option<Contacts<P>>,
    pub(super) constraints: Vec<Constraint<P>>,
    /// External forces, and actuators on frames.
    pub(super) frames: FrameTerms<P>,
    pub(super) tendons: Vec<TendonServo<P>>,
    /// Of inputs.
    pub(super) activations: Vec<PlacedActivation<P>>,
    /// Whether joints have dampers, springs, friction, speed limits or joint limits.
    resists: bool,
    /// `None` where nothing sleeps.
    sleeping: Option<Sleeping>,
    /// Numbers of a state that say what sleeps.
    n_sleep: usize,
}

impl<P: Scalar> Simulator<P> {
    /// Makes a simulator with a time step of 1 ms and semi-implicit Euler. All named joints are actuated that are not
    /// [passive](crate::model::JointSpec::passive). The joint of a floating base has no name: for thrusters use
    /// [`with_frame_actuators`](Self::with_frame_actuators).
    ///
    /// # Panics
    /// If the mass matrix is singular: the message names the links without inertia and the remedies. [`Model::check_mass_matrix`] checks this beforehand.
    pub fn new(model: Model<P>) -> Self {
        model.assert_mass_matrix();
        let driven = |part: &JointPart<'_>| !model.joints()[part.id.0].is_passive;
        let parts = model.joint_parts().filter(driven);
        let actuated = parts
            .map(|part| model.body(part.body))
            .filter(|body| body.coupling.is_none())
            .nested(v_range);
        let actuated = actuated.collect();
        Self {
            model,
            time_step: P::constant(DEFAULT_TIME_STEP),
            divergence_bound: DEFAULT_DIVERGENCE_BOUND,
            integrator: Integrator::default(),
            actuated,
            actuation: None,
            contacts: None,
            constraints: Vec::new(),
            frames: FrameTerms::default(),
            tendons: Vec::new(),
            activations: Vec::new(),
            resists: false,
            sleeping: None,
            n_sleep: 0,
        }
        .with_resistance_found()
    }

    /// Finds out whether joints resist; where numbers may be more than their values, they always may.
    pub(super) fn with_resistance_found(mut self) -> Self {
        let mut resists =
            is_more_than_values::<P>() || self.actuation.as_ref().is_some_and(Actuation::resists);
        each_passive(&self.model, |_, q, passive| {
            let has_spring = q.is_some() && is_anything(passive.stiffness);
            resists |= is_anything(passive.damping) || has_spring;
        });
        self.resists = resists || self.has_following_servos();
        self
    }

    /// Sets the time step, s. It is one of the [parameters](Self::parameters), the last one: over dual numbers, [`with_parameters`](Self::with_parameters)
    /// gives it derivatives.
    ///
    /// # Panics
    /// If it is not positive and finite.
    #[must_use]
    pub fn with_time_step(mut self, time_step: f64) -> Self {
        Domain::Positive.hold(format_args!("a time step of {time_step} s"), time_step);
        self.time_step = P::constant(time_step);
        self
    }

    /// Sets the speed of a coordinate above which a rollout has [diverged](crate::sim::RolloutStatus::Diverged), rad/s or m/s; 10⁶ by default. With
    /// infinity a rollout runs until a value is not finite. Single steps ignore it.
    ///
    /// # Panics
    /// If it is not positive.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, sim::RolloutStatus};
    ///
    /// // Free fall of a cart along its rail would take it past 5 m/s in half a second.
    /// let simulator = Simulator::new(samples::cartpole()).with_time_step(0.1).with_divergence_bound(5.0);
    /// let pushed = simulator.rollout(&State::new(&[0.0; 2], &[0.0; 2]), 100, |_, _, u| u[0] = 100.0);
    /// assert!(matches!(pushed.status, RolloutStatus::Diverged { .. }));
    /// assert!(pushed.states.iter().all(|state| state.v.amax() <= 5.0));
    /// ```
    #[must_use]
    pub fn with_divergence_bound(mut self, speed: f64) -> Self {
        assert!(
            speed > 0.0,
            "a speed of {speed} rad/s or m/s at which a rollout diverges is not positive"
        );
        self.divergence_bound = speed;
        self
    }

    /// Lets islands of trees that have come to rest [sleep](Sleeping); by default, and with `None`, nothing sleeps.
    ///
    /// # Panics
    /// If a number is negative or not finite.
    ///
    /// # Examples
    /// ```
    /// use dualbody::contact::{ContactLaw, Contacts, Rigid, Terrain};
    /// use dualbody::model::{Mass, Object, World};
    /// use dualbody::spatial::Transform;
    /// use dualbody::{Simulator, sim::Sleeping};
    ///
    /// let mut world = World::default();
    /// let place = Transform::from_translation([0.0, 0.0, 0.1].into());
    /// world.add_box("crate", [0.2; 3], &Object::free(Mass::Kilograms(1.0)).at(place))?;
    /// let model = world.build()?;
    /// let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Rigid(Rigid::default()));
    /// let simulator = Simulator::new(model).with_contacts(contacts).with_sleeping(Sleeping::default());
    /// let rest = simulator.rollout(&simulator.neutral_state(), 600, |_, _, _| {});
    /// assert_eq!(simulator.asleep(rest.last()), ["crate"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_sleeping(mut self, sleeping: impl Into<Option<Sleeping>>) -> Self {
        self.sleeping = sleeping.into();
        if let Some(own) = &self.sleeping {
            own.check();
        }
        self.n_sleep = self.sleeping.map_or(0, |_| n_sleep(&self.model));
        self
    }

    /// When resting islands fall asleep; `None` where nothing sleeps.
    pub fn sleeping(&self) -> Option<&Sleeping> {
        self.sleeping.as_ref()
    }

    /// Sets the integrator.
    ///
    /// # Panics
    /// If it cannot simulate the contacts or constraints: rigid contact needs semi-implicit Euler or implicit velocity; the implicit midpoint rule
    /// has no contact, and no constraints that are springs or have a maximum force.
    #[must_use]
    pub fn with_integrator(mut self, integrator: Integrator) -> Self {
        self.integrator = integrator;
        self.check_integrator();
        self
    }

    /// Sets the actuated joints, in the order of the input. [Frame actuators](Self::with_frame_actuators) keep their inputs; the other joints move freely.
    ///
    /// # Errors
    /// If the model has no joint with this name.
    ///
    /// # Panics
    /// If a joint is named twice, or an input that has an [activation](Self::with_activation) is not among them.
    pub fn with_actuated_joints(mut self, names: &[&str]) -> Result<Self, UnknownName> {
        let mut seen = HashSet::new();
        for name in names {
            assert!(
                seen.insert(name),
                "the actuated joint \"{name}\" is named twice"
            );
        }
        let joints: Vec<_> = names
            .iter()
            .map(|name| self.model.find_joint(name))
            .collect::<Result<_, _>>()?;
        self.actuated = joints
            .into_iter()
            .nested(|joint| self.model.joint_v(joint))
            .collect();
        Ok(self.with_activations_placed())
    }

    /// Sets motors, friction and limits of the joints. Without this call motors are ideal, and only the springs and damping of the model act on
    /// joints. [`Actuation::from_model`] takes them from the description.
    ///
    /// # Panics
    /// If it belongs to another robot.
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
        self.with_resistance_found()
    }

    /// Sets contacts with the ground and between bodies; without this call there is no contact.
    ///
    /// [Soft contact](crate::contact::SoftContact) needs [`Integrator::ImplicitVelocity`]. With semi-implicit Euler, the default, and steps that are
    /// too long for it, bodies on a slope chatter and landing bodies are thrown up. No status reports this; [`remarks`](Self::remarks) does.
    ///
    /// # Panics
    /// If the integrator cannot simulate it: rigid contact needs semi-implicit Euler or implicit velocity. If the contacts belong to another robot,
    /// or a point is on a link or body that does not exist. If there is not enough [memory](Contacts::check_memory).
    #[must_use]
    pub fn with_contacts(mut self, contacts: Contacts<P>) -> Self {
        contacts.check(&self.model);
        memory::granted(contacts.check_memory());
        let touches = !contacts.points().is_empty() || contacts.have_pairs();
        self.contacts = Some(contacts).filter(|_| touches);
        self.check_integrator();
        self
    }

    /// The simulator without ground.
    pub(crate) fn without_contacts(&self) -> Self {
        Self {
            contacts: None,
            ..self.clone()
        }
    }

    /// The simulator of joints, inertia and constraints alone: without motors, limits and dry friction, ground, and forces on frames.
    pub(crate) fn with_inertia_only(&self) -> Self {
        Self {
            actuation: None,
            frames: FrameTerms::default(),
            tendons: Vec::new(),
            activations: Vec::new(),
            ..self.without_contacts()
        }
    }

    /// Sets kinematic constraints between attachment frames of the robot, or with the world; without this call there are none. Start from a state
    /// that satisfies them: [`assemble`](Self::assemble) finds one.
    ///
    /// # Panics
    /// If a constraint belongs to another robot: its joints or [frames](crate::constraint::Anchor::frame) are of a robot with other names, joint
    /// kinds or tree. If a coordinate of an attachment frame is not finite.
    #[must_use]
    pub fn with_constraints(mut self, constraints: Vec<Constraint<P>>) -> Self {
        constraints.iter().for_each(|c| c.check(&self.model));
        self.constraints = constraints;
        self.check_integrator();
        self
    }

    /// Sets servos along tendons, or additional servos on joints. Each has its own input; these are the last entries of u, in this order.
    ///
    /// # Panics
    /// If one is that of another robot, two have the same name, an [activation](Self::with_activation) loses its input, or the integrator is the implicit midpoint rule and one has gains.
    #[must_use]
    pub fn with_tendon_servos(mut self, servos: Vec<TendonServo<P>>) -> Self {
        for (k, servo) in servos.iter().enumerate() {
            servo.check(&self.model);
            let name = servo.name();
            let known = servos[..k].iter().any(|other| other.name() == name);
            assert!(!known, "two servos of tendons are called \"{name}\"");
        }
        self.tendons = servos;
        self.check_integrator();
        self.with_resistance_found().with_activations_placed()
    }

    /// The tendon servos.
    pub fn tendon_servos(&self) -> &[TendonServo<P>] {
        &self.tendons
    }

    /// Place of the input of a servo of a tendon.
    pub(crate) fn tendon_input(&self, k: usize) -> usize {
        self.actuated.len() + self.frames.nu() + k
    }

    /// Whether the force of a servo on a tendon or frame follows the motion over a step.
    pub(crate) fn has_following_servos(&self) -> bool {
        self.tendons.iter().any(TendonServo::follows) || self.frame_servos().next().is_some()
    }

    /// Number of rows of the constraints.
    pub(crate) fn bilateral_rows(&self) -> usize {
        self.constraints.iter().map(Constraint::rows).sum()
    }

    /// Number of blocks of these rows.
    pub(crate) fn held_blocks(&self) -> usize {
        self.constraints.iter().map(Constraint::blocks).sum()
    }

    pub(super) fn check_integrator(&self) {
        let refused = match &self.contacts {
            _ if self.integrator != Integrator::ImplicitMidpoint => None,
            Some(_) => Some("contacts"),
            None if self.has_following_servos() => Some("servos of tendons or frames"),
            None => (self.constraints.iter().any(Constraint::gives_way))
                .then_some("constraints that are springs, regularised or have a largest force"),
        };
        assert!(
            refused.is_none(),
            "\"{}\" has {}, which the implicit midpoint rule does not simulate: use another integrator",
            self.model.name(),
            refused.unwrap_or_default(),
        );
        let law = self.contacts.as_ref().and_then(Contacts::acting_over_step);
        let law = law.filter(|_| self.integrator == Integrator::RungeKutta4);
        assert!(
            law.is_none(),
            "{} contact acts over a step and needs semi-implicit Euler or implicit velocity, not {:?}",
            law.unwrap_or_default(),
            self.integrator
        );
    }

    /// Whether the joints of the robot have forces that a step takes at its end.
    pub(super) fn resists(&self) -> bool {
        self.resists
    }

    /// Actuation between the input and the joints; `None` for ideal motors.
    pub fn actuation(&self) -> Option<&Actuation<P>> {
        self.actuation.as_ref()
    }

    /// Contacts with the ground and between bodies; `None` without.
    pub fn contacts(&self) -> Option<&Contacts<P>> {
        self.contacts.as_ref()
    }

    /// The kinematic constraints.
    pub fn constraints(&self) -> &[Constraint<P>] {
        &self.constraints
    }

    /// Number of entries of the contact state.
    pub fn n_contact(&self) -> usize {
        self.contacts.as_ref().map_or(0, Contacts::n_states)
    }

    /// Dimension of the tangent space of the state, 2 `nv`, the contact state and activations: rows and columns of A.
    pub fn n_tangent(&self) -> usize {
        self.n_motion() + self.n_activation()
    }

    /// The simulator without activations.
    pub(crate) fn n_motion(&self) -> usize {
        2 * self.model.nv() + self.n_contact()
    }

    /// Number of entries of [`State::sleep`].
    pub fn n_sleep(&self) -> usize {
        self.n_sleep
    }

    /// A state of this simulator in which all is awake, whose bristles are straight, and whose activations are 0. Allocates.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn state<T: Scalar>(&self, q: &[T], v: &[T]) -> State<T> {
        self.model.check_q(q);
        self.model.check_v(v);
        self.neutral_beside(State::new(q, v))
    }

    /// The neutral configuration at rest and awake, with straight bristles and activations of 0. Allocates.
    pub fn neutral_state<T: Scalar>(&self) -> State<T> {
        self.neutral_beside(State::neutral(&self.model))
    }

    /// A configuration and velocity with straight bristles, activations of 0, and all awake.
    fn neutral_beside<T: Scalar>(&self, state: State<T>) -> State<T> {
        State {
            contact: DVector::zeros(self.n_contact()),
            activation: DVector::zeros(self.n_activation()),
            sleep: DVector::zeros(self.n_sleep),
            ..state
        }
    }

    /// Checks the length of a state.
    pub(crate) fn check<T: Scalar>(&self, state: &State<T>) {
        self.model.check_q(state.q.as_slice());
        self.model.check_v(state.v.as_slice());
        assert_eq!(
            state.contact.len(),
            self.n_contact(),
            "the contact state of \"{}\" has {} entries; Simulator::state makes a state with them",
            self.model.name(),
            self.n_contact()
        );
        assert_eq!(
            state.activation.len(),
            self.n_activation(),
            "the activations of \"{}\" have {} entries; Simulator::state makes a state with them",
            self.model.name(),
            self.n_activation()
        );
        assert!(
            [0, self.n_sleep].contains(&state.sleep.len()),
            "a state has {} numbers of what sleeps, expected {} or none of \"{}\"; Simulator::state makes a state with them",
            state.sleep.len(),
            self.n_sleep,
            self.model.name(),
        );
    }

    /// The model.
    pub fn model(&self) -> &Model<P> {
        &self.model
    }

    /// The time step, s.
    pub fn time_step(&self) -> P {
        self.time_step
    }

    /// The speed above which a rollout has diverged, rad/s or m/s.
    pub fn divergence_bound(&self) -> f64 {
        self.divergence_bound
    }

    /// The integrator.
    pub fn integrator(&self) -> Integrator {
        self.integrator
    }

    /// Number of inputs: degrees of freedom of the actuated joints, one for each frame actuator, and one for each tendon servo.
    pub fn nu(&self) -> usize {
        self.actuated.len() + self.frames.nu() + self.tendons.len()
    }

    /// The velocity coordinate of each joint input; these are the first entries of u.
    pub fn actuated(&self) -> &[usize] {
        &self.actuated
    }

    /// Converts the model data to another scalar type: the step becomes differentiable in masses, lengths, gravity, damping and the time step.
    pub fn cast<Q: Over<P>>(&self) -> Simulator<Q> {
        self.with_variant(self.model.cast())
    }

    /// Returns the simulator with all its settings for a variant of the robot: the same structure with other parameters. Over dual numbers the step
    /// becomes differentiable in the parameters that are variables.
    ///
    /// Motors, contact models and constraints stay unchanged, even if they were chosen for the inertia of the first robot.
    ///
    /// # Errors
    /// If the structure of the model differs; the error names the difference.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Cast, Simulator, State, model::samples};
    /// use num_dual::Dual64;
    ///
    /// // A pendulum of 1 kg that is damped: v⁺ = v − Δt (d v) / J with J = 1/3 kg·m², to first order in d.
    /// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    /// let damping = Dual64::from_re(0.0).derivative();
    /// let damped = simulator.with_model(samples::pendulum().cast().with_damping(0, damping))?;
    /// let next = damped.step(&State::new(&[0.0], &[2.0]).cast(), &[Dual64::from_re(0.0)]);
    /// assert!((next.v[0].eps + 0.01 * 2.0 * 3.0).abs() < 1e-12);
    /// # Ok::<(), dualbody::StructureMismatch>(())
    /// ```
    pub fn with_model<Q: Over<P>>(
        &self,
        model: Model<Q>,
    ) -> Result<Simulator<Q>, StructureMismatch> {
        self.model.check_structure(&model, 0)?;
        Ok(self.with_variant(model))
    }

    /// Returns the simulator with a variant of the model, of the same structure.
    pub(super) fn with_variant<Q: Over<P>>(&self, model: Model<Q>) -> Simulator<Q> {
        Simulator {
            model,
            time_step: self.time_step.into(),
            divergence_bound: self.divergence_bound,
            integrator: self.integrator,
            actuated: self.actuated.clone(),
            actuation: self.actuation.as_ref().map(Cast::cast),
            contacts: self.contacts.as_ref().map(Cast::cast),
            constraints: self.constraints.lift(),
            frames: self.frames.lift(),
            tendons: self.tendons.lift(),
            activations: self.activations.lift(),
            resists: false,
            sleeping: self.sleeping,
            n_sleep: self.n_sleep,
        }
        .with_resistance_found()
    }

    /// The simulator in the values of its numbers in a lane, without contacts.
    pub(super) fn values(&self, lane: usize) -> Simulator {
        let value = &mut |x: P| x.value(lane);
        Simulator {
            model: self.model.values(lane),
            time_step: value(self.time_step),
            divergence_bound: self.divergence_bound,
            integrator: self.integrator,
            actuated: self.actuated.clone(),
            actuation: self.actuation.as_ref().map(|own| own.map_numbers(value)),
            contacts: None,
            constraints: (self.constraints.iter().map(|c| c.map_numbers(value))).collect(),
            frames: self.frames.map_numbers(value),
            tendons: self.tendons.map_numbers(value),
            activations: self.activations.map_numbers(value),
            resists: self.resists,
            sleeping: self.sleeping,
            n_sleep: self.n_sleep,
        }
    }

    pub(crate) fn check_input<T>(&self, u: &[T]) {
        assert_eq!(
            u.len(),
            self.nu(),
            "the input of \"{}\" has nu = {} entries",
            self.model.name(),
            self.nu()
        );
    }
}

/// Whether a number is not 0 in some lane.
fn is_anything<P: Scalar>(x: P) -> bool {
    !x.has_value() || (0..P::LANES).any(|lane| x.value(lane) != 0.0)
}
