//! Servos: motors whose force is affine in position and velocity.

use super::interval::Interval;
use crate::numbers::{Numbers, numbers};
use crate::scalar::{MapEach, Over, Scalar};

/// Motor with its own control loop. The input u is its target: a position, a velocity, or a combination set by the gains.
///
/// At the position q and the velocity v of its joint, with the gear ratio n, the force on the joint is
///
/// > τ = n (g u + b − `k_p` n q − `k_v` n v),
///
/// with u within its range and the force of the motor, τ / n, within its own. The effort limit of its [`Actuator`](super::Actuator) also bounds τ.
/// Euler steps use position and velocity at the end of the step, q + Δt v⁺ and v⁺, which is stable for all gains; A and B are those of this step.
/// Runge–Kutta and the implicit midpoint rule treat the servo force like any other force.
///
/// | servo | constructor | u |
/// |---|---|---|
/// | torque behind a gear | [`torque`](Self::torque) | force of the motor, N·m or N |
/// | position | [`position`](Self::position), [`position_with_damping_ratio`](Self::position_with_damping_ratio) | target, rad or m |
/// | velocity | [`velocity`](Self::velocity) | target, rad/s or m/s |
/// | general affine | the fields | |
///
/// # Examples
/// ```
/// use dualbody::{Simulator, State, model::samples, sim::{Actuation, Actuator, Servo}};
///
/// // Gains that no explicit step of 10 ms would bear.
/// let model = samples::pendulum();
/// let motor = Actuator { servo: Some(Servo::position(1e4, 100.0)), ..Actuator::default() };
/// let joint = model.joint_names()[0].to_owned();
/// let actuation = Actuation::ideal(&model).with_actuator(&model, &joint, motor)?;
/// let simulator = Simulator::new(model).with_actuation(actuation).with_time_step(0.01);
/// let reached = simulator.rollout(&State::new(&[0.0], &[0.0]), 500, |_, _, u| u[0] = 0.3);
/// // Gravity bends it by m g l sin q / 2 k_p.
/// assert!((reached.last().q[0] - 0.3 + 0.5 * 9.81 * 0.3_f64.sin() / 1e4).abs() < 1e-6);
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo<P = f64> {
    /// n, turns of the motor for one of the joint; of any sign.
    pub gear: P,
    /// g, force of the motor per unit of input.
    pub gain: P,
    /// b, force of the motor without input, N·m or N.
    pub bias: P,
    /// `k_p`, N·m/rad or N/m of the motor. A negative gain, which drives away from the target, is evaluated at the start of the step.
    pub position_gain: P,
    /// `k_v`, N·m·s/rad or N·s/m of the motor. A negative gain is evaluated at the start of the step. So the step has a kink where a gain is zero; gradients
    /// in it are those of the negative side there.
    pub velocity_gain: P,
    /// Least and largest input. Steps and their derivatives clamp the input to this range; at an end the derivatives are those of the inner side.
    pub input_range: Option<Interval<P>>,
    /// Least and largest force of the motor before the gear, N·m or N.
    pub force_range: Option<Interval<P>>,
}

numbers! { pub struct Servo {
    gear: Finite("gear ratio", "gear ratio of a servo"),
    gain: Finite("servo gain", "gain of a servo"),
    bias: Finite("servo bias", "bias of a servo"),
    position_gain: Finite("position gain", "position gain of a servo"),
    velocity_gain: Finite("velocity gain", "velocity gain of a servo"),
    input_range: part(Interval, "{} input", "{} input of a servo"),
    force_range: part(Interval, "{} motor force", "{} motor force of a servo"),
} }

impl<P: Scalar> Servo<P> {
    /// A motor without a loop, behind a gear: τ = n u.
    pub fn torque(gear: P) -> Self {
        Self {
            gear,
            gain: P::one(),
            bias: P::zero(),
            position_gain: P::zero(),
            velocity_gain: P::zero(),
            input_range: None,
            force_range: None,
        }
    }

    /// Holds a position: τ = `k_p` (u − q) − `k_v` v.
    ///
    /// * `kp` – N·m/rad or N/m
    /// * `kv` – N·m·s/rad or N·s/m
    pub fn position(kp: P, kv: P) -> Self {
        Self {
            gain: kp,
            position_gain: kp,
            velocity_gain: kv,
            ..Self::torque(P::one())
        }
    }

    /// [`position`](Self::position) with `k_v` = 2 ζ √(`k_p` I) for a damping ratio ζ.
    ///
    /// * `kp` – N·m/rad or N/m, not negative
    /// * `ratio` – ζ, 1 for critical damping
    /// * `inertia` – the inertia I that the joint feels, kg·m² or kg: 1 / (M⁻¹)ₖₖ of [`mass_matrix_inverse`](crate::dynamics::mass_matrix_inverse) if
    ///   the other joints are free
    pub fn position_with_damping_ratio(kp: P, ratio: P, inertia: P) -> Self {
        Self::position(kp, ratio * (kp * inertia).sqrt() * 2.0)
    }

    /// Holds a velocity: τ = `k_v` (u − v).
    ///
    /// * `kv` – N·m·s/rad or N·s/m
    pub fn velocity(kv: P) -> Self {
        Self {
            gain: kv,
            velocity_gain: kv,
            ..Self::torque(P::one())
        }
    }

    /// The servo behind a gear, whose target and gains are those of the motor.
    ///
    /// * `gear` – n, turns of the motor for one of the joint
    #[must_use]
    pub fn with_gear(self, gear: P) -> Self {
        Self { gear, ..self }
    }

    /// The servo with a least and a largest input.
    ///
    /// # Examples
    /// ```
    /// use dualbody::sim::{Actuator, Servo};
    ///
    /// let servo = Servo::position(10.0, 0.0).with_input_range(-1.0, 1.0).with_force_range(-4.0, 6.0);
    /// let motor = Actuator { servo: Some(servo), ..Actuator::default() };
    /// assert!((motor.force(0.8, 0.0, 3.0) - 2.0_f64).abs() < 1e-12); // 10 (1 − 0.8)
    /// assert_eq!(motor.force(-3.0, 0.0, 1.0), 6.0);
    /// ```
    #[must_use]
    pub fn with_input_range(self, lower: P, upper: P) -> Self {
        let input_range = Some(Interval { lower, upper });
        Self {
            input_range,
            ..self
        }
    }

    /// The servo with a least and a largest force of its motor, before the gear.
    ///
    /// * `lower`, `upper` – N·m or N
    #[must_use]
    pub fn with_force_range(self, lower: P, upper: P) -> Self {
        let force_range = Some(Interval { lower, upper });
        Self {
            force_range,
            ..self
        }
    }

    /// # Panics
    /// If the ends of a range are not in order.
    pub(super) fn check_order(&self) {
        if let Some(range) = &self.input_range {
            range.check_order("inputs of a servo");
        }
        if let Some(range) = &self.force_range {
            range.check_order("motor forces of a servo");
        }
    }

    /// Least and largest force on the joint that the range of the motor allows.
    pub(super) fn joint_range<T: Over<P>>(&self) -> Option<Interval<T>> {
        let range: Interval<T> = self.force_range?.lift();
        let [a, b] = [range.lower, range.upper].map_each(|end| end * self.gear);
        Some(Interval {
            lower: a.select_lt(b, a, b),
            upper: a.select_lt(b, b, a),
        })
    }

    /// The force on the joint at a position, where it has one, and a velocity under an input.
    pub(super) fn force<T: Over<P>>(&self, q: Option<T>, v: T, u: T) -> T {
        let gear = T::from(self.gear);
        let by_position = q.map_or(T::zero(), |q| q * self.position_gain);
        let loop_force = (by_position + v * self.velocity_gain) * gear;
        let u = self.input_range.map_or(u, |range| range.lift().nearest(u));
        (u * self.gain + T::from(self.bias) - loop_force) * gear
    }

    /// The force on the joint at the end of a step, as  p − r a  for the acceleration a over it: p and r.
    pub(super) fn over_step<T: Over<P>>(&self, q: Option<T>, v: T, u: T, dt: T) -> (T, T) {
        let square = T::from(self.gear * self.gear);
        let stiffness = T::from(self.position_gain).max(T::zero());
        let damping = T::from(self.velocity_gain).max(T::zero());
        let spring = q.map_or(T::zero(), |_| square * stiffness * dt);
        let push = self.force(q, v, u) - spring * v;
        (push, (spring + square * damping) * dt)
    }

    /// Whether its force depends on the motion in some lane.
    pub(super) fn has_loop(&self) -> bool {
        self.has_gains(false)
    }

    /// Whether its force may depend on the motion: also where that is unknown.
    pub(super) fn may_follow(&self) -> bool {
        self.has_gains(true)
    }

    /// Whether a gain is set in some lane.
    ///
    /// * `unknown` – what counts for one without a value
    fn has_gains(&self, unknown: bool) -> bool {
        let is_set = |x: P| match x.has_value() {
            true => (0..P::LANES).any(|lane| x.value(lane) != 0.0),
            false => unknown,
        };
        is_set(self.position_gain) || is_set(self.velocity_gain)
    }
}
