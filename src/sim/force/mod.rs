//! Forces at attachment frames: external forces, and actuators that are not at a joint, such as thrusters.
//!
//! Each is a term Jᵀ F of the equation of motion, where F is a force at an attachment frame ([`Anchor`]: a link or frame, with an optional offset) in
//! a [`Representation`]:
//!
//! | term | F |
//! |---|---|
//! | [`ExternalForce::constant`] | constant: a load, a steady wind |
//! | [`ExternalForce::function`] | a function of pose and velocity of the attachment frame: drag, a tether, buoyancy |
//! | [`FrameActuator`] | a wrench scaled by an entry of the input: a thruster, or a push that changes with time; or a servo along it |
//!
//! Only this module defines F as a function of pose, velocity and input; steps, their Jacobians and recordings get the force on the body from
//! [`FrameTerm::body_force`].

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

mod actuator;
mod external;
mod function;

pub use actuator::FrameActuator;
use actuator::ServoAt;
pub use external::ExternalForce;
pub use function::{ForceFunction, MAX_FORCE_PARAMETERS};

use crate::constraint::Anchor;
use crate::model::Model;
use crate::numbers::{Each, numbers};
use crate::scalar::{Over, Scalar, from_each};
use crate::spatial::{Force, Motion, Representation, SPATIAL, Transform};

/// The terms of a simulator.
#[derive(Clone, Debug)]
pub(crate) struct FrameTerms<P> {
    pub(super) forces: Vec<ExternalForce<P>>,
    pub(super) actuators: Vec<FrameActuator<P>>,
}

impl<P> Default for FrameTerms<P> {
    fn default() -> Self {
        Self {
            forces: Vec::new(),
            actuators: Vec::new(),
        }
    }
}

numbers! { struct FrameTerms { forces: part(ExternalForce), actuators: part(FrameActuator) } }

impl<P: Scalar> FrameTerms<P> {
    pub(crate) fn is_empty(&self) -> bool {
        self.forces.is_empty() && self.actuators.is_empty()
    }

    /// Number of inputs of the actuators.
    pub(super) fn nu(&self) -> usize {
        self.actuators.len()
    }

    /// All of them, external forces first, then the actuators in the order of their inputs.
    pub(crate) fn iter(&self) -> impl Iterator<Item = FrameTerm<'_, P>> {
        let forces = self.forces.iter().map(FrameTerm::Force);
        let actuators = self.actuators.iter().enumerate();
        forces.chain(actuators.map(|(input, actuator)| FrameTerm::Actuator { actuator, input }))
    }
}

/// A term of the equation of motion.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FrameTerm<'a, P> {
    Force(&'a ExternalForce<P>),
    Actuator {
        actuator: &'a FrameActuator<P>,
        /// Index of its input among those of frame actuators.
        input: usize,
    },
}

impl<P: Scalar> FrameTerm<'_, P> {
    pub(crate) fn place(&self) -> &Anchor<P> {
        match self {
            Self::Force(force) => force.place(),
            Self::Actuator { actuator, .. } => actuator.place(),
        }
    }

    fn representation(&self) -> Representation {
        match self {
            Self::Force(force) => force.representation(),
            Self::Actuator { actuator, .. } => actuator.representation(),
        }
    }

    /// Index of its input among those of frame actuators, if it has one.
    pub(crate) fn input(&self) -> Option<usize> {
        match self {
            Self::Force(_) => None,
            Self::Actuator { input, .. } => Some(*input),
        }
    }

    /// Whether the force stays the same in the body, however that moves.
    pub(crate) fn is_fixed_to_body(&self) -> bool {
        let is_function = matches!(self, Self::Force(force) if force.force().is_none());
        let has_servo =
            matches!(self, Self::Actuator { actuator, .. } if actuator.servo().is_some());
        self.representation() == Representation::Body && !is_function && !has_servo
    }

    /// The force on the body of the attachment frame, in the body (N, N·m about its origin).
    ///
    /// * `X_WB`, `V_B` – pose of the body, and its velocity in the body
    /// * `u` – its own entry of the input; of no meaning to a term without one
    /// * `found` – the force of a servo along its wrench, if that is not the one of the state
    pub(crate) fn body_force<T: Over<P>>(
        &self,
        X_BA: &Transform<P>,
        X_WB: &Transform<T>,
        V_B: &Motion<T>,
        u: T,
        found: Option<T>,
    ) -> Force<T> {
        let (X_WA, V_A) = self.place_motion(X_BA, X_WB, V_B);
        let F = match self {
            Self::Actuator { actuator, .. } => actuator.force_at(&X_WA, &V_A, u, found),
            Self::Force(force) => force.force_at(&X_WA, &V_A),
        };
        X_BA.force(&self.representation().force_to_body(&X_WA, &F))
    }

    /// Pose of the attachment frame in the world and its velocity in the representation.
    fn place_motion<T: Over<P>>(
        &self,
        X_BA: &Transform<P>,
        X_WB: &Transform<T>,
        V_B: &Motion<T>,
    ) -> (Transform<T>, Motion<T>) {
        let X_WA = X_BA.after(X_WB);
        let V_A = X_BA.motion_inverse(V_B);
        let V_A = self.representation().velocity_from_body(&X_WA, &V_A);
        (X_WA, V_A)
    }
}

impl<P: Scalar> FrameTerm<'_, P> {
    /// The actuator of a term that is one.
    pub(crate) fn actuator(&self) -> Option<&FrameActuator<P>> {
        match self {
            Self::Force(_) => None,
            Self::Actuator { actuator, .. } => Some(actuator),
        }
    }
}

impl FrameTerm<'_, f64> {
    /// Passes the derivative of the [force](Self::body_force) on the body in each parameter, except those of its attachment frame, to `each`, in order.
    pub(crate) fn each_derivative<T: Scalar>(
        &self,
        X_BA: &Transform<f64>,
        X_WB: &Transform<T>,
        V_B: &Motion<T>,
        u: T,
        found: Option<T>,
        each: &mut dyn FnMut(Force<T>),
    ) {
        let (X_WA, V_A) = self.place_motion(X_BA, X_WB, V_B);
        let representation = self.representation();
        let mut on_body = |F: Force<T>| {
            each(X_BA.force(&representation.force_to_body(&X_WA, &F)));
        };
        match self {
            Self::Actuator { actuator, .. } => {
                let (pose, velocity) = (&X_WA, &V_A);
                actuator.each_derivative(&ServoAt { pose, velocity, u }, found, &mut on_body);
            }
            Self::Force(force) => force.each_derivative(&X_WA, &V_A, &mut on_body),
        }
    }
}

/// Names of the coordinates of a force.
const AXES: [[&str; 3]; 2] = [["fx", "fy", "fz"], ["nx", "ny", "nz"]];

numbers! { struct Force { linear: Finite((AXES[0])), angular: Finite((AXES[1])) } }

/// Parameters of an attachment frame: coordinates of its origin, then components of its rotation.
pub(crate) const PLACE_NUMBERS: usize = SPATIAL;

fn each_place<P: Scalar>(place: &mut Anchor<P>, each: &mut Each<'_, P>) {
    place.each_position("", each);
    place.each_turn("", each);
}

/// A force of one along each coordinate.
fn unit_forces<T: Scalar>() -> [Force<T>; SPATIAL] {
    let unit = |i: usize, k: usize| if i == k { T::one() } else { T::zero() };
    from_each(|k| Force::from_array(from_each(|i| unit(i, k))))
}

/// Refuses an attachment frame that is fixed to the world.
///
/// # Panics
/// If it belongs to another robot, or is fixed to the world.
pub(super) fn check<P: Scalar>(what: &str, place: &Anchor<P>, model: &Model<P>) {
    let name = model.name();
    let frame = place.frame.map(|id| model.frames().get(id.0));
    assert!(
        place.is_of(model) && !matches!(frame, Some(None)),
        "{what} belongs to another robot than \"{name}\""
    );
    let frame = frame.flatten();
    let on = frame.map_or("the world", |frame| &frame.name);
    assert!(
        frame.is_some_and(|frame| frame.body.is_some()),
        "{what} acts on \"{on}\", which is fixed to the world in \"{name}\": load it with a floating base?"
    );
}

/// Refuses a wrench that is not finite.
fn check_finite(what: &str, force: &Force<f64>) {
    let numbers = force.to_array();
    assert!(
        numbers.iter().all(|x| x.is_finite()),
        "{what} of {numbers:?} (N, N·m) is not finite"
    );
}
