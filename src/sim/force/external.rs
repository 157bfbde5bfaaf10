//! External forces on a robot.

use super::function::{ForceFunction, Function};
use super::{check_finite, each_place, unit_forces};
use crate::constraint::Anchor;
use crate::numbers::{Each, Numbers, numbers};
use crate::scalar::{Cast, Over, Scalar};
use crate::spatial::{Force, Motion, Representation, Transform};

/// A force at an attachment frame, constant or a function of the motion of that frame.
///
/// The representation defines the coordinates of the force while the frame moves. *Body*: along the axes of the frame, rotating with them. *Mixed*:
/// along world axes, through the origin of the frame. *Inertial*: along world axes, about the world origin, so the line of action is fixed in the
/// world.
///
/// A force that changes with time is an input, set by the closure of a rollout: see [`FrameActuator::wrench`](super::FrameActuator::wrench).
///
/// # Examples
/// ```
/// use dualbody::{Simulator, constraint::Anchor, model::{LinkSpec, ModelBuilder}, sim::ExternalForce};
/// use dualbody::spatial::{Force, Representation};
///
/// let mut builder = ModelBuilder::new("balloon");
/// builder.add_link(LinkSpec::new("body").with_mass(2.0, [0.0; 3], [0.1; 3]));
/// let model = builder.build()?;
/// // It carries its weight and 1 N more.
/// let lift = Force::from_array([0.0, 0.0, 2.0 * 9.81 + 1.0, 0.0, 0.0, 0.0]);
/// let lift = ExternalForce::constant(Anchor::frame(&model, "body")?, lift, Representation::Mixed);
/// let balloon = Simulator::new(model).with_external_forces(vec![lift]).with_time_step(0.1);
/// let next = balloon.step(&balloon.neutral_state::<f64>(), &[]);
/// assert!((next.v[2] - 0.05).abs() < 1e-14); // Δt · 1 N / 2 kg
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ExternalForce<P = f64> {
    place: Anchor<P>,
    representation: Representation,
    kind: Kind<P>,
}

#[derive(Clone, Debug)]
enum Kind<P> {
    Constant(Force<P>),
    Function(Function<P>),
}

numbers! { pub struct ExternalForce {
    place: part(Anchor), representation: kept(), kind: part(Kind),
} }

numbers! { enum Kind { Constant(force: part(Force)), Function(function: part(Function)) } }

impl ExternalForce<f64> {
    /// A constant force at an attachment frame (N, and N·m about the origin of the representation).
    ///
    /// # Panics
    /// If an entry is not finite.
    pub fn constant(place: Anchor, force: Force<f64>, representation: Representation) -> Self {
        check_finite("an external force", &force);
        Self {
            place,
            representation,
            kind: Kind::Constant(force),
        }
    }

    /// A force that depends on pose and velocity of its attachment frame. Derivatives of a step include its derivatives.
    ///
    /// All integrators except Runge–Kutta evaluate it at the start of a step: drag with coefficient c on a mass m needs steps shorter than 2 m / c.
    ///
    /// * `representation` – of the velocity that the function receives, and of the force that it returns
    /// * `parameters` – passed to the function; see [`with_parameters`](Self::with_parameters)
    ///
    /// # Panics
    /// If there are more than [`MAX_FORCE_PARAMETERS`](super::MAX_FORCE_PARAMETERS) parameters.
    pub fn function(
        place: Anchor,
        function: impl ForceFunction,
        parameters: &[f64],
        representation: Representation,
    ) -> Self {
        Self {
            place,
            representation,
            kind: Kind::Function(Function::new(function, parameters)),
        }
    }
}

impl ExternalForce<f64> {
    /// Passes the derivative of the [force](Self::force_at) in each of its own numbers to `each`.
    pub(super) fn each_derivative<T: Scalar>(
        &self,
        pose: &Transform<T>,
        V: &Motion<T>,
        each: &mut dyn FnMut(Force<T>),
    ) {
        match &self.kind {
            Kind::Constant(_) => unit_forces().into_iter().for_each(each),
            Kind::Function(function) => function.each_derivative(pose, V, each),
        }
    }
}

impl<P: Scalar> ExternalForce<P> {
    /// Attachment frame at which it acts.
    pub(crate) fn place(&self) -> &Anchor<P> {
        &self.place
    }

    /// Representation of the force: the axes and point of its coordinates while the attachment frame moves.
    pub(crate) fn representation(&self) -> Representation {
        self.representation
    }

    /// The force, if it is constant (N, N·m).
    pub(crate) fn force(&self) -> Option<&Force<P>> {
        match &self.kind {
            Kind::Constant(force) => Some(force),
            Kind::Function(_) => None,
        }
    }

    /// Returns another constant force at the same attachment frame in the same representation: over dual numbers, for derivatives in the force.
    #[must_use]
    pub fn with_force<Q: Over<P>>(&self, force: Force<Q>) -> ExternalForce<Q> {
        ExternalForce {
            kind: Kind::Constant(force),
            ..self.cast()
        }
    }

    /// Returns the force with other parameters of its function: over dual numbers, for derivatives in them.
    ///
    /// # Panics
    /// If it is not a function, or the number of parameters is wrong.
    #[must_use]
    pub fn with_parameters<Q: Over<P>>(&self, parameters: &[Q]) -> ExternalForce<Q> {
        let Kind::Function(function) = &self.kind else {
            panic!("a constant force has no parameters; with_force gives it another value");
        };
        ExternalForce {
            kind: Kind::Function(function.with_parameters(parameters)),
            ..self.cast()
        }
    }

    /// Passes each parameter with its name to `each`: where its place is in its frame and by how much it is turned, then a constant force or the parameters of a
    /// function.
    pub(crate) fn each_placed_number(&mut self, each: &mut Each<'_, P>) {
        each_place(&mut self.place, each);
        Numbers::each_number(self, each);
    }

    /// The force in its representation, for a pose of the attachment frame in the world and a velocity in the same representation.
    pub(super) fn force_at<T: Over<P>>(&self, pose: &Transform<T>, V: &Motion<T>) -> Force<T> {
        match &self.kind {
            Kind::Constant(force) => force.lift(),
            Kind::Function(function) => function.force(pose, V),
        }
    }
}
