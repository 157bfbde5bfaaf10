//! Actuation between the input and the force on a joint: the motor, friction, limits.
//!
//! For each velocity coordinate, with the input u (0 for a coordinate without input), in this order:
//!
//! > τ = E(C(G(q, v, u), v)) + F(v) + L(q, v) + S(v)  and, from the model, −k (q − rest) − d v.
//!
//! | part | meaning |
//! |---|---|
//! | G | the input itself, or the servo force n (g u + b − `k_p` n q − `k_v` n v) with u within its range |
//! | C | the motor's torque–speed curve: the input within ±`τ_max` up to the speed `ω_th`, from there linearly to 0 at `ω_max` |
//! | E | the effort limit and the range of the servo's motor: within ±`τ_limit` and n times that range |
//! | F | dry friction: stick and slip, at most f; or smoothed, −f v / √(v² + `v_s²`): −f v / `v_s` at rest, −f against fast motion |
//! | L | position limits: a spring and damper beyond each end, which push back only |
//! | S | the velocity limit: a damper for the speed beyond it |
//!
//! Torque–speed curve and effort limit bound the motor force only, not friction or joint limits. All parts are differentiable in q, v, u and in their
//! parameters; exactly at a limit, the derivative is that of the inner side.

mod actuator;
mod coulomb_friction;
mod interval;
mod position_limits;
mod servo;
mod tendon_servo;
mod torque_speed;
mod velocity_limit;

use crate::contact::HuntCrossley;
use crate::dynamics::mass_matrix_inverse;
use crate::error::UnknownName;
use crate::joint::JointKind;
use crate::model::manifold::v_range;
use crate::model::{Body, Model, Structure};
use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};

pub use actuator::Actuator;
pub(crate) use actuator::OfActuator;
pub use coulomb_friction::{CoulombFriction, FrictionLaw};
pub use interval::Interval;
pub(crate) use position_limits::End;
pub use position_limits::PositionLimits;
pub use servo::Servo;
pub(crate) use tendon_servo::Pulled;
pub use tendon_servo::TendonServo;
pub use torque_speed::TorqueSpeed;
pub use velocity_limit::VelocityLimit;

/// The actuators of a robot, one for each velocity coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuation<P = f64> {
    pub(super) actuators: Vec<Actuator<P>>,
    /// Of the robot that they are for.
    structure: Structure,
}

numbers! { pub struct Actuation { actuators: part(Actuator), structure: kept() } }

/// Response time of a stop or a speed limit where the file gives only its place, s: a joint that hits a stop at speed v goes about
/// v times this beyond it. Runge–Kutta steps of twice this and longer are unstable.
const DEFAULT_RESPONSE_TIME: f64 = 0.01;

impl Actuation<f64> {
    /// Ideal motors without friction and limits: τ = u.
    pub fn ideal(model: &Model) -> Self {
        Self {
            actuators: vec![Actuator::default(); model.nv()],
            structure: model.structure(),
        }
    }

    /// The actuation in the robot description of each joint: limits of effort, position and velocity, and Coulomb friction.
    ///
    /// Descriptions do not give the stiffness of joint limits. Joint and speed limits are critically damped here, with a response time of 10 ms for
    /// the inertia that the joint feels at the neutral configuration while the other joints are free. Friction is [exact](FrictionLaw::Exact), and
    /// smoothed for planar and floating joints; the slip velocity is 0.01 rad/s or m/s. [`with_actuator`](Self::with_actuator) replaces these values.
    /// On light links they are far stiffer than a step resolves. This matters only for [`RungeKutta4`](crate::Integrator::RungeKutta4): the other
    /// integrators evaluate these forces at the end of the step.
    pub fn from_model(model: &Model) -> Self {
        let mut out = Self::ideal(model);
        let inverse = mass_matrix_inverse(model, model.neutral().as_slice());
        for joint in model.joint_parts() {
            let body = model.body(joint.body);
            if body.coupling.is_some() {
                continue;
            }
            for k in v_range(body) {
                let rate = 1.0 / (inverse[(k, k)] * DEFAULT_RESPONSE_TIME);
                let (lower, upper) = (joint.limits.lower, joint.limits.upper);
                let is_bounded = body.joint.nq() == 1 && lower.or(upper).is_some();
                let stop = HuntCrossley::linear(rate / DEFAULT_RESPONSE_TIME, 2.0 * rate);
                out.actuators[k] = Actuator {
                    effort: joint.limits.effort,
                    friction: (joint.friction != 0.0).then(|| friction_of(body, joint.friction)),
                    position: is_bounded.then_some(PositionLimits { lower, upper, stop }),
                    velocity: joint.limits.velocity.map(|speed| VelocityLimit {
                        speed,
                        damping: rate,
                    }),
                    ..Actuator::default()
                };
            }
        }
        out
    }

    /// Sets the actuator of a joint's coordinates.
    ///
    /// # Errors
    /// If the model has no joint of that name.
    ///
    /// # Panics
    /// If the actuators belong to another robot, or the joint is a mimic joint. If a joint of several degrees of freedom gets position limits or a
    /// position gain, or a planar or floating joint gets exact friction. If a parameter is negative or not finite (an effort limit may be infinite),
    /// a slip velocity is 0, a maximum speed is not above its threshold, or the lower end of a limit or range is above the upper end. If a
    /// torque–speed curve is combined with a servo that has gains.
    pub fn with_actuator(
        mut self,
        model: &Model,
        joint: &str,
        actuator: Actuator,
    ) -> Result<Self, UnknownName> {
        self.check(model);
        let id = model.find_joint(joint)?;
        let body = model.body(model.joint_body(id));
        assert!(
            body.coupling.is_none(),
            "\"{joint}\" mimics another joint: actuate that joint"
        );
        assert!(
            actuator.position.is_none() || body.joint.nq() == 1,
            "\"{joint}\" has several degrees of freedom, its position has no two ends"
        );
        assert!(
            body.joint.nq() == 1
                || actuator
                    .servo
                    .is_none_or(|servo| servo.position_gain == 0.0),
            "\"{joint}\" has several degrees of freedom: a servo has no position of it to hold"
        );
        assert!(
            actuator.exact_friction().is_none() || has_fixed_axes(body),
            "\"{joint}\" is planar or floating, its axes turn: exact friction does not hold it, smoothed friction brakes it"
        );
        actuator.check();
        self.actuators[model.joint_v(id)].fill(actuator);
        Ok(self)
    }
}

impl<P: Scalar> Actuation<P> {
    /// The actuators, one for each velocity coordinate.
    pub fn actuators(&self) -> &[Actuator<P>] {
        &self.actuators
    }

    /// The same actuation with other parameters: over dual numbers, for derivatives in the parameters.
    ///
    /// # Panics
    /// If the number of actuators is wrong, or a parameter is out of range as in [`with_actuator`](Self::with_actuator).
    pub fn with_actuators<Q: Over<P>>(&self, actuators: &[Actuator<Q>]) -> Actuation<Q> {
        assert_eq!(
            actuators.len(),
            self.actuators.len(),
            "an actuator for each velocity coordinate"
        );
        actuators.iter().for_each(Actuator::check);
        Actuation {
            actuators: actuators.to_vec(),
            structure: self.structure,
        }
    }

    /// # Panics
    /// If they belong to another robot.
    pub(super) fn check(&self, model: &Model<P>) {
        self.structure.check(model, "the actuators");
    }

    /// Hands every end of every joint to `each(coordinate, end)`.
    pub(super) fn each_end<T: Over<P>>(
        &self,
        model: &Model<P>,
        q: &[T],
        mut each: impl FnMut(usize, &End<'_, P, T>),
    ) {
        for body in single(model) {
            if let Some(limits) = &self.actuators[body.v].position {
                limits.each_end(q[body.q], |end| each(body.v, end));
            }
        }
    }

    /// Whether a joint has a servo, friction, a speed limit or a stop.
    pub(super) fn resists(&self) -> bool {
        let resists = |a: &Actuator<P>| {
            a.servo.is_some()
                || a.friction.is_some()
                || a.velocity.is_some()
                || a.position.is_some()
        };
        self.actuators.iter().any(resists)
    }
}

impl<P: Scalar> Actuation<P> {
    /// Number of forces that are bounded over a step.
    pub(super) fn bounded_forces(&self) -> usize {
        let each = self.actuators.iter();
        each.map(|own| {
            let friction = own.exact_friction().is_some();
            usize::from(friction) + usize::from(own.bounded_servo().is_some())
        })
        .sum()
    }

    /// The coordinates with exact friction, and that.
    pub(super) fn exact_frictions(&self) -> impl Iterator<Item = (usize, &CoulombFriction<P>)> {
        let each = self.actuators.iter().enumerate();
        each.filter_map(|(k, actuator)| Some((k, actuator.exact_friction()?)))
    }
}

impl Actuation<f64> {
    /// Hands every end of every joint with its derivatives in the parameters of its actuator to `each(coordinate, end)`.
    pub(super) fn each_seeded_end<T: Scalar>(
        &self,
        model: &Model,
        q: &[T],
        mut each: impl FnMut(usize, &End<'_, OfActuator<T>, OfActuator<T>>),
    ) {
        for body in single(model) {
            if let Some(limits) = self.actuators[body.v].seeded().position {
                let q = OfActuator::constant_of(q[body.q]);
                limits.each_end(q, |end| each(body.v, end));
            }
        }
    }
}

/// The bodies whose joints have a position, which is where limits of it are.
fn single<P: Scalar>(model: &Model<P>) -> impl Iterator<Item = &Body<P>> {
    model.independent().filter(|body| body.joint.nq() == 1)
}

/// Friction of a joint whose description says its force.
fn friction_of(body: &Body<f64>, force: f64) -> CoulombFriction {
    let law = match has_fixed_axes(body) {
        true => FrictionLaw::Exact,
        false => FrictionLaw::Smoothed,
    };
    CoulombFriction {
        law,
        ..CoulombFriction::exact(force)
    }
}

/// Whether the velocity of a joint after a step is v + Δt v̇: that of planar and floating joints is along axes that turn.
fn has_fixed_axes<P: Scalar>(body: &Body<P>) -> bool {
    !matches!(body.joint, JointKind::Planar | JointKind::Floating)
}
