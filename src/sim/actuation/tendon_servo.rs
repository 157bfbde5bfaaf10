//! Servos on tendons, which act on several joints at once.

use super::actuator::Actuator;
use super::servo::Servo;
use crate::error::UnknownName;
use crate::model::{Model, Structure};
use crate::numbers::{Domain, numbers};
use crate::scalar::{Over, Scalar, is_more_than_values};

/// A servo on a tendon that is fixed to joints, with its own input. The tendon length is Σ cᵢ qᵢ; a tendon force F acts with cᵢ F on joint i.
///
/// On a tendon of one joint it is an additional servo of that joint. Euler steps use the force at the end of the step. Its gains are not diagonal, so
/// the constraint solver finds it together with the other constraint forces. A servo without gains needs no solver.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples, sim::{Servo, TendonServo}};
///
/// // The sum of both angles goes to 0.4 rad under gains that no explicit step of 10 ms would bear.
/// let model = samples::double_pendulum().with_gravity([0.0; 3].into());
/// let joints = model.joint_names();
/// let servo = TendonServo::new(&model, "sum", &[(joints[0], 1.0), (joints[1], 1.0)], Servo::position(1e4, 100.0))?;
/// let simulator = Simulator::new(model.clone()).with_actuated_joints(&[])?.with_tendon_servos(vec![servo]).with_time_step(0.01);
/// let reached = simulator.rollout(&simulator.neutral_state(), 300, |_, _, u| u[0] = 0.4);
/// assert!((reached.last().q.sum() - 0.4).abs() < 1e-3);
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TendonServo<P = f64> {
    name: String,
    joints: Vec<Pulled<P>>,
    /// Of which the servo and the effort limit count.
    actuator: Actuator<P>,
    /// Of the robot that it is for.
    structure: Structure,
}

/// A joint that a tendon passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pulled<P> {
    /// Places of its coordinate in q and in v.
    pub(crate) q: usize,
    pub(crate) v: usize,
    pub(crate) coefficient: P,
}

numbers! { pub struct TendonServo {
    name: kept(), joints: part(Pulled), actuator: part(Actuator), structure: kept(),
} }

numbers! { struct Pulled {
    q: kept(), v: kept(),
    coefficient: Finite("coefficient", "coefficient of a tendon"),
} }

/// Length and rate of a tendon, rad or m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TendonMotion<L> {
    pub(crate) length: L,
    pub(crate) rate: L,
}

impl TendonServo<f64> {
    /// A servo on a tendon.
    ///
    /// * `name` – of its input
    /// * `joints` – names with coefficients cᵢ
    /// * `servo` – its force along the tendon: q and v of a [`Servo`] are length and rate
    ///
    /// # Errors
    /// If the model has no joint with this name.
    ///
    /// # Panics
    /// If the list of joints is empty, a joint has several degrees of freedom or is a mimic joint, or a parameter is out of range as in
    /// [`Actuation::with_actuator`](super::Actuation::with_actuator).
    pub fn new(
        model: &Model,
        name: impl Into<String>,
        joints: &[(&str, f64)],
        servo: Servo,
    ) -> Result<Self, UnknownName> {
        assert!(
            !joints.is_empty(),
            "a tendon needs at least one joint, got none"
        );
        let actuator = Actuator {
            servo: Some(servo),
            ..Actuator::default()
        };
        actuator.check();
        Ok(Self {
            name: name.into(),
            joints: (joints.iter())
                .map(|(joint, c)| Pulled::new(model, joint, *c))
                .collect::<Result<_, _>>()?,
            actuator,
            structure: model.structure(),
        })
    }

    /// Bounds its force along the tendon.
    ///
    /// * `limit` – N·m or N, behind the gear
    ///
    /// # Panics
    /// If it is negative or NaN.
    #[must_use]
    pub fn with_effort(mut self, limit: f64) -> Self {
        self.actuator.effort = Some(limit);
        self.actuator.check();
        self
    }
}

impl Pulled<f64> {
    fn new(model: &Model, joint: &str, coefficient: f64) -> Result<Self, UnknownName> {
        let id = model.find_joint(joint)?;
        let body = model.body(model.joint_body(id));
        assert!(
            body.coupling.is_none() && body.joint.nq() == 1,
            "a tendon passes \"{joint}\", which mimics another joint or has several degrees of freedom"
        );
        let phrase = format_args!("a coefficient {coefficient} of \"{joint}\"");
        Domain::Finite.hold(phrase, coefficient);
        Ok(Self {
            q: body.q,
            v: body.v,
            coefficient,
        })
    }
}

impl<P: Scalar> TendonServo<P> {
    /// Name of its input.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The servo along the tendon.
    ///
    /// # Panics
    /// Never: it has one.
    pub(crate) fn servo(&self) -> &Servo<P> {
        let servo = self.actuator.servo.as_ref();
        servo.expect("a servo on a tendon")
    }

    pub(crate) fn actuator(&self) -> &Actuator<P> {
        &self.actuator
    }

    /// The velocity coordinates of its joints.
    pub(crate) fn coordinates(&self) -> impl Iterator<Item = usize> {
        self.joints.iter().map(|joint| joint.v)
    }

    pub(crate) fn joints(&self) -> &[Pulled<P>] {
        &self.joints
    }

    /// Whether its force follows the motion over a step.
    pub(crate) fn follows(&self) -> bool {
        is_more_than_values::<P>() || self.servo().has_loop()
    }

    /// Length and rate.
    pub(crate) fn motion<T: Over<P>>(&self, q: &[T], v: &[T]) -> TendonMotion<T> {
        let zero = TendonMotion {
            length: T::zero(),
            rate: T::zero(),
        };
        self.joints.iter().fold(zero, |sum, own| TendonMotion {
            length: sum.length + q[own.q] * own.coefficient,
            rate: sum.rate + v[own.v] * own.coefficient,
        })
    }

    /// # Panics
    /// If it belongs to another robot.
    pub(crate) fn check(&self, model: &Model<P>) {
        self.structure.check(model, "the servos of tendons");
    }
}
