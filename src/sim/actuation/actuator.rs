//! The actuator of one velocity coordinate.

use super::coulomb_friction::{CoulombFriction, FrictionLaw};
use super::interval::Interval;
use super::position_limits::PositionLimits;
use super::servo::Servo;
use super::torque_speed::TorqueSpeed;
use super::velocity_limit::VelocityLimit;
use crate::numbers::{Numbers, numbers};
use crate::scalar::{Dual, Over, Scalar};

/// Motor, friction and limits along one velocity coordinate. Each part is optional.
///
/// # Examples
/// ```
/// use dualbody::sim::{Actuator, TorqueSpeed};
///
/// let curve = TorqueSpeed { torque: 8.0, threshold: 10.0, maximum: 20.0 };
/// let motor = Actuator { torque_speed: Some(curve), ..Actuator::default() };
/// assert_eq!(motor.force(0.0, 5.0, 100.0), 8.0);
/// assert_eq!(motor.force(0.0, -15.0, 100.0), 4.0); // half way down, whichever way it turns
/// assert_eq!(motor.force(0.0, 25.0, 100.0), 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuator<P = f64> {
    /// A servo. Its target is the input; without a servo the input is the motor force.
    pub servo: Option<Servo<P>>,
    /// The motor's torque–speed curve.
    pub torque_speed: Option<TorqueSpeed<P>>,
    /// Largest force of the motor, N·m or N.
    pub effort: Option<P>,
    /// Dry friction.
    pub friction: Option<CoulombFriction<P>>,
    /// Least and largest position; for joints of one degree of freedom.
    pub position: Option<PositionLimits<P>>,
    /// Largest speed.
    pub velocity: Option<VelocityLimit<P>>,
}

numbers! { pub struct Actuator {
    servo: part(Servo),
    torque_speed: part(TorqueSpeed),
    effort: NotNegativeOrInfinite("effort limit"),
    friction: part(CoulombFriction),
    position: part(PositionLimits),
    velocity: part(VelocityLimit),
} }

/// A motor without curve and limits on a joint without friction and stops. A derived implementation would require a default of the scalar.
impl<P> Default for Actuator<P> {
    fn default() -> Self {
        Self {
            servo: None,
            torque_speed: None,
            effort: None,
            friction: None,
            position: None,
            velocity: None,
        }
    }
}

impl<P: Scalar> Actuator<P> {
    /// # Panics
    /// If a parameter is out of its domain, with its name.
    pub(crate) fn check(&self) {
        self.check_numbers();
        if let Some(curve) = &self.torque_speed {
            curve.check_order();
        }
        if let Some(limits) = &self.position {
            limits.check_order();
        }
        if let Some(servo) = &self.servo {
            servo.check_order();
        }
        let has_loop = self.servo.as_ref().is_some_and(Servo::has_loop);
        assert!(
            self.torque_speed.is_none() || !has_loop,
            "a servo with gains has a torque–speed curve: its effort limit bounds its force, a curve does not"
        );
    }

    /// Computes the force on the coordinate at position `q`, velocity `v` and input `u`, with the smoothed friction law.
    pub fn force<T: Over<P>>(&self, q: T, v: T, u: T) -> T {
        let mut tau = self.motor(Some(q), v, u);
        self.add_brakes(self.friction.as_ref(), v, &mut tau);
        tau + self.stop(q, v)
    }

    /// Friction that a step finds as a force that holds.
    pub(crate) fn exact_friction(&self) -> Option<&CoulombFriction<P>> {
        let friction = self.friction.as_ref();
        friction.filter(|own| own.law == FrictionLaw::Exact)
    }

    /// Friction that a step takes by its smoothed law.
    pub(crate) fn smoothed_friction(&self) -> Option<&CoulombFriction<P>> {
        let friction = self.friction.as_ref();
        friction.filter(|own| own.law == FrictionLaw::Smoothed)
    }

    /// A servo that follows the motion over a step. Beside a torque–speed curve it has no gains to do so; without gains its force over a step is known before.
    fn following_servo(&self) -> Option<&Servo<P>> {
        let servo = self.servo.as_ref().filter(|servo| servo.may_follow());
        servo.filter(|_| self.torque_speed.is_none())
    }

    /// A servo whose force is bounded while it follows the motion.
    pub(crate) fn bounded_servo(&self) -> Option<&Servo<P>> {
        let servo = self.following_servo();
        servo.filter(|servo| self.effort.is_some() || servo.force_range.is_some())
    }

    /// Least and largest force of the motor on the joint; `None` where it has no limit.
    fn limits<T: Over<P>>(&self) -> Option<Interval<T>> {
        let effort = self.effort.map(|x| Interval::symmetric(T::from(x)));
        let range = self.servo.as_ref().and_then(Servo::joint_range);
        match (effort, range) {
            (Some(effort), Some(range)) => Some(range.within(&effort)),
            (effort, range) => effort.or(range),
        }
    }

    /// A force within the limits of the motor.
    pub(crate) fn limited<T: Over<P>>(&self, tau: T) -> T {
        match self.limits() {
            Some(limits) => limits.nearest(tau),
            None => tau,
        }
    }

    /// The middle of the limits of a servo's force, and how far it goes from there: that of one with an effort limit alone is 0.
    pub(crate) fn band<T: Over<P>>(&self) -> (T, T) {
        let Some(Interval { lower, upper }) = self.limits() else {
            return (T::zero(), T::constant(f64::INFINITY));
        };
        match self.servo.as_ref().and_then(|servo| servo.force_range) {
            Some(_) => ((lower + upper) * 0.5, (upper - lower) * 0.5),
            None => (T::zero(), upper),
        }
    }

    /// The force of the motor, within its limits.
    pub(crate) fn motor<T: Over<P>>(&self, q: Option<T>, v: T, u: T) -> T {
        let servo = self.servo.as_ref();
        let mut tau = servo.map_or(u, |servo| servo.force(q, v, u));
        if let Some(curve) = &self.torque_speed {
            tau = Interval::symmetric(curve.available(v)).nearest(tau);
        }
        self.limited(tau)
    }

    /// The force of the motor at the end of a step, as  p − r a  for the acceleration a over it: p and r. That of a servo with gains is not limited.
    pub(crate) fn motor_over_step<T: Over<P>>(&self, q: Option<T>, v: T, u: T, dt: T) -> (T, T) {
        match self.following_servo() {
            Some(servo) => servo.over_step(q, v, u, dt),
            None => (self.motor(q, v, u), T::zero()),
        }
    }

    /// Adds the forces of friction and of the speed limit.
    ///
    /// * `friction` – that of its own which acts by the smoothed law
    pub(crate) fn add_brakes<T: Over<P>>(
        &self,
        friction: Option<&CoulombFriction<P>>,
        v: T,
        tau: &mut T,
    ) {
        if let Some(friction) = friction {
            *tau += friction.force(v);
        }
        if let Some(limit) = &self.velocity {
            *tau += limit.force(v);
        }
    }

    pub(super) fn stop<T: Over<P>>(&self, q: T, v: T) -> T {
        let limits = self.position.as_ref();
        limits.map_or(T::zero(), |limits| limits.force(q, v))
    }

    /// Damping coefficient of friction and the speed limit together, at the velocity `v`: the sum of c ≥ 0 in the force −c v of the one and
    /// in −c (v − limit) of the other.
    ///
    /// * `friction` – that of its own which acts by the smoothed law
    pub(crate) fn damping<T: Over<P>>(&self, friction: Option<&CoulombFriction<P>>, v: T) -> T {
        let mut damping = T::zero();
        if let Some(friction) = friction {
            damping += friction.damping(v);
        }
        if let Some(limit) = &self.velocity {
            damping += limit.damping(v);
        }
        damping
    }
}

/// The most numbers that an actuator has.
const ACTUATOR_NUMBERS: usize = <Actuator as Numbers<f64>>::COUNT;

/// A number with its derivatives in those of an actuator, in their order.
pub(crate) type OfActuator<T> = Dual<T, ACTUATOR_NUMBERS>;

impl Actuator<f64> {
    /// The actuator with the derivative of each of its numbers in itself.
    pub(crate) fn seeded<T: Scalar>(&self) -> Actuator<OfActuator<T>> {
        self.seed(0)
    }
}
