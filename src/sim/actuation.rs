//! Actuation between the input and the force on a joint: the motor, friction, limits.
//!
//! For each velocity coordinate, with the input u (0 where there is none), in this order:
//!
//! > τ = E(C(u, v)) + F(v) + L(q, v) + S(v)  and, from the model, −k (q − rest) − d v.
//!
//! | part | what it is |
//! |---|---|
//! | C | the motor's torque–speed curve: the input within ±`τ_max` up to the speed `ω_th`, from there linearly to 0 at `ω_max` |
//! | E | the effort limit: within ±`τ_limit` |
//! | F | Coulomb friction, −f v / √(v² + `v_s²`): −f v / `v_s` at rest, −f against fast motion |
//! | L | position limits: a spring and damper beyond each end, which push back only |
//! | S | the velocity limit: a damper for the speed beyond it |
//!
//! Motor and effort limit what the motor gives, not what friction and stops do. All parts are differentiable in q, v, u and in their
//! own numbers; where a limit is just reached, the derivative is that of the inner side.

use crate::contact::HuntCrossley;
use crate::dynamics::mass_matrix_inverse;
use crate::error::UnknownName;
use crate::given;
use crate::model::manifold::v_range;
use crate::model::{Body, Model, Structure};
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
    /// The motor's torque–speed curve.
    pub torque_speed: Option<TorqueSpeed<P>>,
    /// Largest force of the motor, N·m or N.
    pub effort: Option<P>,
    /// Coulomb friction.
    pub friction: Option<CoulombFriction<P>>,
    /// Least and largest position; for joints of one degree of freedom.
    pub position: Option<PositionLimits<P>>,
    /// Largest speed.
    pub velocity: Option<VelocityLimit<P>>,
}

/// A motor without curve and limits on a joint without friction and stops. Derived, it would ask for a default of the scalar.
impl<P> Default for Actuator<P> {
    fn default() -> Self {
        Self {
            torque_speed: None,
            effort: None,
            friction: None,
            position: None,
            velocity: None,
        }
    }
}

/// Torque–speed curve of a motor: the torque that it has at each speed, symmetric in both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueSpeed<P = f64> {
    /// `τ_max`, N·m or N.
    pub torque: P,
    /// `ω_th`, up to which there is all of it, rad/s or m/s.
    pub threshold: P,
    /// `ω_max`, from which on there is none; larger than `ω_th`.
    pub maximum: P,
}

/// Dry friction, smooth through rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoulombFriction<P = f64> {
    /// f, N·m or N.
    pub force: P,
    /// `v_s`, rad/s or m/s: at this speed 71 % of the force act. Smaller holds better at rest (it creeps at `v_s` τ / f under a force τ) and
    /// makes the joint stiffer against small motion: steps of Runge and Kutta must be shorter than about 2 I `v_s` / f with an inertia I, those
    /// of the other integrators need not.
    pub slip_velocity: P,
}

/// Stops at the ends of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionLimits<P = f64> {
    /// Least position, rad or m.
    pub lower: Option<P>,
    /// Largest position, rad or m.
    pub upper: Option<P>,
    /// The force of a stop, for depth and rate of going beyond it.
    pub stop: HuntCrossley<P>,
}

/// A damper that acts on what is too fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityLimit<P = f64> {
    /// Speed from which on it acts, rad/s or m/s.
    pub speed: P,
    /// Force by excess of speed, N·m·s/rad or N·s/m.
    pub damping: P,
}

impl<P: Scalar> Actuator<P> {
    /// # Panics
    /// If a number makes no sense, with its name.
    fn check(&self) {
        if let Some(curve) = &self.torque_speed {
            curve.check();
        }
        if let Some(effort) = self.effort {
            given::not_negative_or_infinite("effort limit", effort);
        }
        if let Some(friction) = &self.friction {
            given::not_negative("force of Coulomb friction", friction.force);
            given::positive("slip velocity of Coulomb friction", friction.slip_velocity);
        }
        if let Some(limits) = &self.position {
            limits.check();
        }
        if let Some(limit) = &self.velocity {
            given::not_negative("speed limit", limit.speed);
            given::not_negative("damping of a speed limit", limit.damping);
        }
    }

    /// Hands each number that there is with its name to `each`, [`ACTUATOR_NUMBERS`] at most.
    pub(crate) fn each_number(&mut self, each: &mut dyn FnMut(&'static str, &mut P)) {
        if let Some(curve) = &mut self.torque_speed {
            each("motor torque", &mut curve.torque);
            each("motor threshold speed", &mut curve.threshold);
            each("motor largest speed", &mut curve.maximum);
        }
        if let Some(effort) = &mut self.effort {
            each("effort limit", effort);
        }
        if let Some(friction) = &mut self.friction {
            each("Coulomb friction", &mut friction.force);
            each("slip velocity", &mut friction.slip_velocity);
        }
        if let Some(limits) = &mut self.position {
            limits.each_number(each);
        }
        if let Some(limit) = &mut self.velocity {
            each("speed limit", &mut limit.speed);
            each("speed limit damping", &mut limit.damping);
        }
    }

    /// The force on the coordinate at position `q`, velocity `v` and input `u`.
    pub fn force<T: Over<P>>(&self, q: T, v: T, u: T) -> T {
        self.drive(v, u) + self.stop(q, v)
    }

    /// The force but for the stops.
    pub(crate) fn drive<T: Over<P>>(&self, v: T, u: T) -> T {
        let mut tau = u;
        if let Some(curve) = &self.torque_speed {
            tau = within(tau, curve.available(v));
        }
        if let Some(effort) = self.effort {
            tau = within(tau, effort.into());
        }
        if let Some(friction) = &self.friction {
            tau += friction.force(v);
        }
        if let Some(limit) = &self.velocity {
            tau += limit.force(v);
        }
        tau
    }

    fn stop<T: Over<P>>(&self, q: T, v: T) -> T {
        let limits = self.position.as_ref();
        limits.map_or(T::zero(), |limits| limits.force(q, v))
    }

    /// Damping coefficient of friction and the speed limit together, at the velocity `v`: the sum of c ≥ 0 in the force −c v of the one and
    /// in −c (v − limit) of the other.
    pub(crate) fn damping<T: Over<P>>(&self, v: T) -> T {
        let mut damping = T::zero();
        if let Some(friction) = &self.friction {
            damping += friction.damping(v);
        }
        if let Some(limit) = &self.velocity {
            damping += limit.damping(v);
        }
        damping
    }

    /// Converts the actuator to another scalar type.
    pub fn cast<Q: Over<P>>(&self) -> Actuator<Q> {
        let lift = |x: P| Q::from(x);
        Actuator {
            torque_speed: self.torque_speed.map(|curve| TorqueSpeed {
                torque: lift(curve.torque),
                threshold: lift(curve.threshold),
                maximum: lift(curve.maximum),
            }),
            effort: self.effort.map(lift),
            friction: self.friction.map(|friction| CoulombFriction {
                force: lift(friction.force),
                slip_velocity: lift(friction.slip_velocity),
            }),
            position: self.position.map(|limits| PositionLimits {
                lower: limits.lower.map(lift),
                upper: limits.upper.map(lift),
                stop: limits.stop.cast(),
            }),
            velocity: self.velocity.map(|limit| VelocityLimit {
                speed: lift(limit.speed),
                damping: lift(limit.damping),
            }),
        }
    }
}

/// The most numbers that an actuator has.
const ACTUATOR_NUMBERS: usize = 14;

/// A number with its derivatives in those of an actuator, in their order.
pub(crate) type OfActuator = Dual<f64, ACTUATOR_NUMBERS>;

impl Actuator<f64> {
    /// The actuator with the derivative of each of its numbers in itself.
    pub(crate) fn seeded(&self) -> Actuator<OfActuator> {
        let (mut out, mut direction) = (self.cast::<OfActuator>(), 0);
        out.each_number(&mut |_, x| {
            x.eps[direction] = 1.0;
            direction += 1;
        });
        out
    }
}

/// τ within ±limit.
fn within<T: Scalar>(tau: T, limit: T) -> T {
    let upper = limit.select_lt(tau, limit, tau);
    upper.select_lt(-limit, -limit, upper)
}

impl<P: Scalar> TorqueSpeed<P> {
    /// # Panics
    /// If a number makes no sense, with its name.
    fn check(&self) {
        given::not_negative("torque of a motor", self.torque);
        given::not_negative("threshold speed of a motor", self.threshold);
        given::finite("largest speed of a motor", self.maximum);
        for lane in 0..P::LANES {
            let (threshold, maximum) = (self.threshold.value(lane), self.maximum.value(lane));
            let falls = maximum > threshold;
            assert!(
                falls,
                "a largest speed of a motor of {maximum} is not above the threshold of {threshold}"
            );
        }
    }

    /// `τ_max` (`ω_max` − |v|) / (`ω_max` − `ω_th`), within 0 and `τ_max`.
    fn available<T: Over<P>>(&self, v: T) -> T {
        let (zero, torque) = (T::zero(), T::from(self.torque));
        let (threshold, maximum) = (T::from(self.threshold), T::from(self.maximum));
        let speed = v.abs();
        let sloped = torque * (maximum - speed) / (maximum - threshold);
        let falling = speed.select_lt(maximum, sloped, zero);
        threshold.select_lt(speed, falling, torque)
    }
}

impl<P: Scalar> CoulombFriction<P> {
    fn force<T: Over<P>>(&self, v: T) -> T {
        -(v * self.damping(v))
    }

    /// f / √(v² + `v_s²`)
    fn damping<T: Over<P>>(&self, v: T) -> T {
        let slip = T::from(self.slip_velocity);
        T::from(self.force) / (v * v + slip * slip).sqrt()
    }
}

impl<P: Scalar> PositionLimits<P> {
    /// # Panics
    /// If a number makes no sense, with its name.
    fn check(&self) {
        for end in [self.lower, self.upper].into_iter().flatten() {
            given::finite("position limit", end);
        }
        self.stop.check("a stop");
        if let (Some(lower), Some(upper)) = (self.lower, self.upper) {
            for lane in 0..P::LANES {
                let (lower, upper) = (lower.value(lane), upper.value(lane));
                let ordered = lower <= upper;
                assert!(
                    ordered,
                    "a lower position limit of {lower} is above the upper one, {upper}"
                );
            }
        }
    }

    fn each_number(&mut self, each: &mut dyn FnMut(&'static str, &mut P)) {
        if let Some(lower) = &mut self.lower {
            each("lower limit", lower);
        }
        if let Some(upper) = &mut self.upper {
            each("upper limit", upper);
        }
        each("stop stiffness", &mut self.stop.stiffness);
        each("stop damping", &mut self.stop.damping);
        each("stop stiffness exponent", &mut self.stop.stiffness_exponent);
        each("stop damping exponent", &mut self.stop.damping_exponent);
    }

    fn force<T: Over<P>>(&self, q: T, v: T) -> T {
        let mut sum = T::zero();
        self.each_end(q, |end| {
            sum += end.force(v);
        });
        sum
    }

    /// Both ends that there are, at a position.
    fn each_end<T: Over<P>>(&self, q: T, mut each: impl FnMut(&End<'_, P, T>)) {
        let ends = [(self.lower, 1.0), (self.upper, -1.0)];
        for (end, inward) in ends {
            if let Some(end) = end {
                each(&End {
                    depth: (-q + end) * inward,
                    inward,
                    stop: &self.stop,
                });
            }
        }
    }
}

/// An end of a joint.
pub(crate) struct End<'a, P, T> {
    /// Depth of the joint beyond the end, rad or m; negative before it.
    pub(crate) depth: T,
    /// The direction of its push along the coordinate.
    pub(crate) inward: f64,
    pub(crate) stop: &'a HuntCrossley<P>,
}

impl<P: Scalar, T: Over<P>> End<'_, P, T> {
    /// Force along the coordinate, which moves with `v`.
    pub(crate) fn force(&self, v: T) -> T {
        self.stop.force(self.depth, -(v * self.inward)) * self.inward
    }
}

impl<P: Scalar> VelocityLimit<P> {
    /// Force by excess of speed where there is excess, else 0.
    fn damping<T: Over<P>>(&self, v: T) -> T {
        T::from(self.speed).select_lt(v.abs(), self.damping.into(), T::zero())
    }

    fn force<T: Over<P>>(&self, v: T) -> T {
        let (zero, limit) = (T::zero(), T::from(self.speed));
        let over = limit.select_lt(v, v - limit, zero);
        let under = v.select_lt(-limit, v + limit, zero);
        -((over + under) * self.damping)
    }
}

/// The actuators of a robot, one for each velocity coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuation<P = f64> {
    actuators: Vec<Actuator<P>>,
    /// Of the robot that they are for.
    structure: Structure,
}

/// Coulomb friction of joints whose file says no more than its force: rad/s or m/s.
const DEFAULT_SLIP_VELOCITY: f64 = 1e-2;

/// Response time of a stop or a speed limit where the file gives only its place, s: a joint that hits a stop at speed v goes about
/// v times this beyond it. Steps of Runge and Kutta of twice this and longer are unstable.
const DEFAULT_RESPONSE_TIME: f64 = 0.01;

impl Actuation<f64> {
    /// Ideal motors without friction and limits: τ = u.
    pub fn ideal(model: &Model) -> Self {
        Self {
            actuators: vec![Actuator::default(); model.nv()],
            structure: model.structure(),
        }
    }

    /// Actuation that the description states for each joint: limits of effort, position and velocity, and Coulomb friction.
    ///
    /// Descriptions do not say how hard a stop is. Here it is critically damped with a response time of 10 ms, for the inertia that the
    /// joint feels at the neutral configuration while the others are free, and so is the speed limit; friction has a slip velocity of
    /// 0.01 rad/s or m/s. [`with_actuator`](Self::with_actuator) changes what does not suit. On light links such numbers are far stiffer than a
    /// step resolves, which only [`RungeKutta4`](crate::Integrator::RungeKutta4) minds: the other integrators take them at the end of the step.
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
                    friction: (joint.friction != 0.0).then_some(CoulombFriction {
                        force: joint.friction,
                        slip_velocity: DEFAULT_SLIP_VELOCITY,
                    }),
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

    /// Gives the coordinates of a joint an actuator.
    ///
    /// # Errors
    /// If the model has no joint of that name.
    ///
    /// # Panics
    /// If the actuators are those of another robot, the joint follows another one, or position limits are given to a joint of several degrees of freedom. If a number makes no sense:
    /// one that is negative or not finite (an effort limit may be infinite), a slip velocity of 0, a largest speed that is not above the
    /// threshold, a lower end above the upper one.
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
            "\"{joint}\" follows another joint, which is the one to actuate"
        );
        assert!(
            actuator.position.is_none() || body.joint.nq() == 1,
            "\"{joint}\" has several degrees of freedom, its position has no two ends"
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

    /// Converts the actuation to another scalar type.
    pub fn cast<Q: Over<P>>(&self) -> Actuation<Q> {
        Actuation {
            actuators: self.actuators.iter().map(Actuator::cast).collect(),
            structure: self.structure,
        }
    }

    /// Other numbers in the same parts: over dual numbers, for derivatives in them.
    ///
    /// # Panics
    /// If there are not as many actuators, or a number makes no sense, as in [`with_actuator`](Self::with_actuator).
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

    /// The actuators, to be changed.
    pub(super) fn actuators_mut(&mut self) -> &mut [Actuator<P>] {
        &mut self.actuators
    }

    /// # Panics
    /// If a number makes no sense, with its name.
    pub(super) fn check_numbers(&self) {
        self.actuators.iter().for_each(Actuator::check);
    }

    /// # Panics
    /// If they are those of another robot.
    pub(super) fn check(&self, model: &Model<P>) {
        self.structure.check(model, "the actuators");
    }

    /// Turns inputs into forces along the coordinates but for those of stops: `tau` (length `nv`) holds the input of each, and becomes the
    /// force.
    pub(super) fn drive<T: Over<P>>(&self, v: &[T], tau: &mut [T]) {
        for ((actuator, &v), tau) in self.actuators.iter().zip(v).zip(tau) {
            *tau = actuator.drive(v, *tau);
        }
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

    /// Whether a joint has friction, a speed limit or a stop.
    pub(super) fn resists(&self) -> bool {
        let resists =
            |a: &Actuator<P>| a.friction.is_some() || a.velocity.is_some() || a.position.is_some();
        self.actuators.iter().any(resists)
    }

    /// Damping coefficient of friction and the speed limit together, of the coordinate `k` at the velocity `v`.
    pub(super) fn damping<T: Over<P>>(&self, k: usize, v: T) -> T {
        self.actuators[k].damping(v)
    }
}

impl Actuation<f64> {
    /// Hands every end of every joint with its derivatives in the numbers of its actuator to `each(coordinate, end)`.
    pub(super) fn each_seeded_end(
        &self,
        model: &Model,
        q: &[f64],
        mut each: impl FnMut(usize, &End<'_, OfActuator, OfActuator>),
    ) {
        for body in single(model) {
            if let Some(limits) = self.actuators[body.v].seeded().position {
                limits.each_end(q[body.q].into(), |end| each(body.v, end));
            }
        }
    }
}

/// The bodies whose joints have a position, which is where limits of it are.
fn single<P: Scalar>(model: &Model<P>) -> impl Iterator<Item = &Body<P>> {
    model.independent().filter(|body| body.joint.nq() == 1)
}
