//! Actuators that act on attachment frames instead of joints.

use nalgebra::Vector3;

use super::{AXES, check_finite, each_place, unit_forces};
use crate::constraint::{Anchor, FrameAxis};
use crate::numbers::{Each, Numbers, numbers};
use crate::scalar::{Dual, Over, Scalar};
use crate::sim::actuation::{Actuator, OfActuator, Servo};
use crate::spatial::{Force, Motion, Representation, Transform};

/// A wrench at an attachment frame, scaled by one entry of the input: a thruster, a rotor, a push.
///
/// It needs no joint, so it can act on a floating base or any other link. Its input follows those of the joints, see
/// [`Simulator::with_frame_actuators`](crate::Simulator::with_frame_actuators).
///
/// # Examples
/// ```
/// use dualbody::{Simulator, constraint::Anchor, model::{LinkSpec, ModelBuilder}, sim::FrameActuator};
///
/// let mut builder = ModelBuilder::new("drone");
/// builder.add_link(LinkSpec::new("body").with_mass(0.5, [0.0; 3], [0.02; 3]));
/// let model = builder.build()?;
/// // A rotor 0.2 m in front, which pushes up and turns the body by 0.01 N·m for each N.
/// let front = Anchor::frame(&model, "body")?.moved([0.2, 0.0, 0.0]);
/// let rotor = FrameActuator::thruster("front", front, [0.0, 0.0, 1.0], 0.01).with_limits(0.0, 4.0);
/// let drone = Simulator::new(model).with_frame_actuators(vec![rotor]);
/// assert_eq!((drone.nu(), drone.input_names()), (1, vec!["front".to_owned()]));
/// let step = drone.linearize(&drone.neutral_state(), &[1.0]);
/// // Δt / m, −Δt x / I_yy, Δt κ / I_zz; velocities are along axes that have turned by 10⁻⁵ rad
/// for (row, expected) in [(8, 2e-3), (10, -1e-2), (11, 5e-4)] {
///     assert!((step.b[(row, 0)] - expected).abs() < 1e-11);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FrameActuator<P = f64> {
    name: String,
    place: Anchor<P>,
    representation: Representation,
    /// Per unit of input.
    wrench: Force<P>,
    lower: Option<P>,
    upper: Option<P>,
    servo: Option<Servo<P>>,
    /// Pose in the world of the frame from which the position of a servo counts; `None` for the world.
    origin: Option<Transform<f64>>,
}

numbers! { pub struct FrameActuator {
    name: kept(), place: part(Anchor), representation: kept(), wrench: part(Force),
    lower: Anything("lower limit"),
    upper: Anything("upper limit"),
    servo: part(Servo),
    origin: kept(),
} }

impl FrameActuator<f64> {
    /// A wrench at an attachment frame, scaled by the input.
    ///
    /// * `wrench` – force and moment per unit of input (N and N·m per unit)
    /// * `representation` – *body* for a device mounted on the robot, *mixed* for a push along world axes; see
    ///   [`ExternalForce`](super::ExternalForce)
    ///
    /// # Panics
    /// If an entry is not finite, or the wrench is zero.
    pub fn new(
        name: impl Into<String>,
        place: Anchor,
        wrench: Force<f64>,
        representation: Representation,
    ) -> Self {
        let name = name.into();
        check_finite(&format!("the wrench of \"{name}\""), &wrench);
        assert!(
            wrench != Force::zero(),
            "\"{name}\" has no wrench to act with"
        );
        Self {
            name,
            place,
            representation,
            wrench,
            lower: None,
            upper: None,
            servo: None,
            origin: None,
        }
    }

    /// A thruster. Its input is the thrust, N: a force along an axis fixed to the attachment frame, and the reaction torque of its rotor about that axis.
    ///
    /// The lever arm follows from the origin of the attachment frame: [`Anchor::moved`] offsets it from a link or frame.
    ///
    /// * `direction` – of the force on the robot, in the axes of the attachment frame; any length except zero
    /// * `torque_ratio` – moment on the robot about the direction per thrust, N·m/N: positive for a rotor that turns left-handed about it, 0 for
    ///   a nozzle
    ///
    /// # Panics
    /// If the direction is zero, or an argument is not finite.
    pub fn thruster(
        name: impl Into<String>,
        place: Anchor,
        direction: [f64; 3],
        torque_ratio: f64,
    ) -> Self {
        let (name, given) = (name.into(), direction);
        let direction = Vector3::from(direction);
        let length = direction.norm();
        assert!(
            length > 0.0 && length.is_finite(),
            "the direction {given:?} of \"{name}\" has no length"
        );
        let along = direction / length;
        let wrench = Force::new(along, along * torque_ratio);
        Self::new(name, place, wrench, Representation::Body)
    }

    /// Six actuators, one for each coordinate of a wrench at an attachment frame (N; N·m): an arbitrary push that changes with time.
    ///
    /// They are called `<name>.fx`, `.fy`, `.fz`, `.nx`, `.ny`, `.nz`. The closure of a rollout sets them like all inputs. To keep a controller from
    /// using them, design it on a simulator without them.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, constraint::Anchor, model::samples, sim::FrameActuator, spatial::Representation};
    ///
    /// // A gust from the side pushes the pole of a cart-pole for a tenth of a second.
    /// let model = samples::cartpole();
    /// let tip = Anchor::frame(&model, "pole")?;
    /// let gust = FrameActuator::wrench("gust", tip, Representation::Mixed);
    /// let plant = Simulator::new(model).with_frame_actuators(gust.to_vec());
    /// assert_eq!(plant.input_names()[2..4], ["gust.fx", "gust.fy"]);
    /// let start = plant.neutral_state();
    /// let pushed = plant.rollout(&start, 200, |time, _, u| u[3] = if time < 0.1 { 2.0 } else { 0.0 });
    /// assert!(pushed.last().v[1] != 0.0);
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn wrench(name: &str, place: Anchor, representation: Representation) -> [Self; 6] {
        std::array::from_fn(|k| {
            let unit: [f64; 6] = std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
            let name = format!("{name}.{}", AXES.as_flattened()[k]);
            Self::new(name, place, Force::from_array(unit), representation)
        })
    }

    /// Limits the input. Steps and their derivatives clamp it to the limits; at a limit the derivatives are those of the inner side.
    /// [`Simulator::effort_bounds`](crate::Simulator::effort_bounds) returns the limits for an optimiser.
    ///
    /// * `lower`, `upper` – in the unit of the input; infinite for none
    ///
    /// # Panics
    /// If the lower limit is not below the upper one.
    #[must_use]
    pub fn with_limits(mut self, lower: f64, upper: f64) -> Self {
        let name = &self.name;
        assert!(
            lower < upper,
            "the limits {lower} and {upper} of \"{name}\" are not in order"
        );
        self.lower = Some(lower);
        self.upper = Some(upper);
        self
    }
}

impl FrameActuator<f64> {
    /// Makes it a servo along its wrench w: the force is w times the force of the servo, and the input is its target.
    ///
    /// In [`Mixed`](Representation::Mixed) representation the position of the servo is w · (p; θ), with the origin p (m) and the rotation vector θ (rad) of
    /// the attachment frame in the world, and the velocity is its rate: the servo holds the frame in the axes of the world. In the other representations
    /// the axes or the origin move with the frame, and the servo has a velocity only, as on a site of `MuJoCo`. Euler steps use the force at the end of
    /// the step, which the solver computes as a row, so all gains are stable. A and B are those of this step.
    ///
    /// # Panics
    /// If a parameter of the servo is out of range as in [`Actuation::with_actuator`](crate::sim::Actuation::with_actuator).
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, constraint::Anchor, model::samples, sim::{FrameActuator, Servo}};
    /// use dualbody::spatial::{Force, Representation};
    ///
    /// // A spring of 10⁴ N/m along x pulls the tip of a double pendulum, in steps of 10 ms.
    /// let model = samples::double_pendulum().with_gravity([0.0; 3].into());
    /// let tip = Anchor::frame(&model, "lower")?.moved([0.0, 0.0, -1.0]);
    /// let along = Force::from_array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    /// let spring = FrameActuator::new("y", tip, along, Representation::Mixed).with_servo(Servo::position(1e4, 100.0));
    /// let simulator = Simulator::new(model).with_actuated_joints(&[])?.with_frame_actuators(vec![spring]).with_time_step(0.01);
    /// let reached = simulator.rollout(&simulator.state(&[0.3, 0.2], &[0.0; 2]), 1000, |_, _, u| u[0] = 0.5);
    /// let end = reached.last();
    /// let tip = tip.pose_in_world(simulator.model(), end.q.as_slice());
    /// assert!((tip.translation.y - 0.5).abs() < 1e-2);
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    #[must_use]
    pub fn with_servo(mut self, servo: Servo) -> Self {
        self.servo = Some(servo);
        self.check();
        self
    }

    /// The same, with the position of its servo from a frame that is fixed to the world: w · (p − p₀; R₀ log(R₀ᵀ R)).
    pub(crate) fn with_origin(mut self, origin: Transform<f64>) -> Self {
        self.origin = Some(origin);
        self
    }
}

/// State at which an actuator is differentiated, in its representation.
pub(super) struct ServoAt<'a, T> {
    pub(super) pose: &'a Transform<T>,
    pub(super) velocity: &'a Motion<T>,
    pub(super) u: T,
}

impl FrameActuator<f64> {
    /// Passes the derivative of the [force](Self::force_at) in each of its own numbers to `each`.
    ///
    /// * `found` – the middle of the limits of a servo that is a row, which alone acts here
    pub(super) fn each_derivative<T: Scalar>(
        &self,
        at: &ServoAt<'_, T>,
        found: Option<T>,
        each: &mut dyn FnMut(Force<T>),
    ) {
        match (&self.servo, found) {
            (None, _) => self.each_plain_derivative(at.u, each),
            (Some(_), Some(force)) => {
                for unit in unit_forces::<T>() {
                    each(unit.scaled(force));
                }
                self.limit_shares(at.u).for_each(|_: T| each(Force::zero()));
                let middle = self.actuator().seeded::<T>().band::<OfActuator<T>>().0;
                let slopes = middle.eps[..self.servo_numbers()].iter();
                slopes.for_each(|&slope| each(self.wrench.lift::<T>().scaled(slope)));
            }
            (Some(_), None) => self.each_servo_derivative(at, each),
        }
    }

    /// Those of a servo whose force follows from the state.
    fn each_servo_derivative<T: Scalar>(
        &self,
        at: &ServoAt<'_, T>,
        each: &mut dyn FnMut(Force<T>),
    ) {
        /// Length, rate and input.
        type Local<T> = Dual<T, 3>;
        let (pose, velocity, w) = (at.pose, at.velocity, self.wrench.lift::<T>());
        let (length, rate) = (self.axis::<T>().length(pose), velocity.power(&w));
        let u: Local<T> = self.bounded(Dual::variable(at.u, 2));
        let x = length.map(|x| Local::variable(x, 0));
        let force = self.actuator().motor(x, Dual::variable(rate, 1), u);
        for unit in unit_forces::<T>() {
            let axis = FrameAxis {
                wrench: unit,
                representation: self.representation,
                origin: self.origin,
            };
            let longer = axis.length(pose).unwrap_or_else(T::zero);
            let slope = force.eps[0] * longer + force.eps[1] * velocity.power(&unit);
            each(unit.scaled(force.re) + w.scaled(slope));
        }
        for share in self.limit_shares(at.u) {
            // Beyond a limit the input has no slope of its own.
            let inner: Local<T> = Dual::variable(self.bounded(at.u), 2);
            let force = self.actuator().motor(x, Dual::variable(rate, 1), inner);
            each(w.scaled(force.eps[2] * share));
        }
        let fixed = OfActuator::<T>::constant_of;
        let seeded = self.actuator().seeded::<T>();
        let force = seeded.motor(length.map(fixed), fixed(rate), fixed(self.bounded(at.u)));
        let own = self.servo_numbers();
        force.eps[..own]
            .iter()
            .for_each(|&slope| each(w.scaled(slope)));
    }

    /// Number of parameters of its servo.
    pub(crate) fn servo_numbers(&self) -> usize {
        self.servo.map_or(0, |servo| servo.to_vec().len())
    }

    /// The derivative of the bounded input in each limit that it has.
    pub(crate) fn limit_shares<T: Scalar>(&self, u: T) -> impl Iterator<Item = T> {
        let limits = [
            self.lower.map(|lower| u.value(0) < lower),
            self.upper.map(|upper| u.value(0) > upper),
        ];
        let share = |reached: bool| if reached { T::one() } else { T::zero() };
        limits.into_iter().flatten().map(share)
    }

    /// Those of a wrench that is scaled by the input.
    fn each_plain_derivative<T: Scalar>(&self, u: T, each: &mut dyn FnMut(Force<T>)) {
        let bounded = self.bounded(u);
        for unit in unit_forces::<T>() {
            each(unit.scaled(bounded));
        }
        for share in self.limit_shares(u) {
            each(self.wrench.lift::<T>().scaled(share));
        }
    }
}

impl<P: Scalar> FrameActuator<P> {
    /// Name of the input.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Attachment frame at which it acts.
    pub(crate) fn place(&self) -> &Anchor<P> {
        &self.place
    }

    /// Representation of the wrench: the axes and point of its coordinates while the attachment frame moves.
    pub(crate) fn representation(&self) -> Representation {
        self.representation
    }

    /// Lower limit of the input; `None` without limits.
    pub(crate) fn lower(&self) -> Option<P> {
        self.lower
    }

    /// Upper limit of the input; `None` without limits.
    pub(crate) fn upper(&self) -> Option<P> {
        self.upper
    }

    /// Passes each parameter with its name to `each`: origin and rotation of its attachment frame, the wrench, limits.
    pub(crate) fn each_placed_number(&mut self, each: &mut Each<'_, P>) {
        each_place(&mut self.place, each);
        Numbers::each_number(self, each);
    }

    /// The servo along its wrench; `None` if the input scales the wrench.
    pub(crate) fn servo(&self) -> Option<&Servo<P>> {
        self.servo.as_ref()
    }

    /// The actuator of its servo.
    pub(crate) fn actuator(&self) -> Actuator<P> {
        Actuator {
            servo: self.servo,
            ..Actuator::default()
        }
    }

    /// # Panics
    /// If a parameter of its servo is out of its domain.
    pub(crate) fn check(&self) {
        self.actuator().check();
    }

    /// Its wrench as the axis of a row.
    pub(crate) fn axis<T: Over<P>>(&self) -> FrameAxis<T> {
        FrameAxis {
            wrench: self.wrench.lift(),
            representation: self.representation,
            origin: self.origin,
        }
    }

    /// The force in its representation.
    ///
    /// * `found` – the force of a servo along the wrench, if that is not the one of the state
    pub(super) fn force_at<T: Over<P>>(
        &self,
        pose: &Transform<T>,
        velocity: &Motion<T>,
        u: T,
        found: Option<T>,
    ) -> Force<T> {
        let axis = self.axis::<T>();
        let scale = match (self.servo, found) {
            (None, _) => self.bounded(u),
            (_, Some(found)) => found,
            (Some(_), None) => {
                let (length, rate) = (axis.length(pose), velocity.power(&axis.wrench));
                self.actuator().motor(length, rate, self.bounded(u))
            }
        };
        axis.wrench.scaled(scale)
    }

    /// The input within the limits.
    pub(crate) fn bounded<T: Over<P>>(&self, u: T) -> T {
        let mut u = u;
        if let Some(lower) = self.lower {
            let lower = T::from(lower);
            u = u.select_lt(lower, lower, u);
        }
        if let Some(upper) = self.upper {
            let upper = T::from(upper);
            u = upper.select_lt(u, upper, u);
        }
        u
    }
}
