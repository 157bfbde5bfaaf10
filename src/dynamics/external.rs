//! External forces on frames.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::kinematics::Kinematics;
use crate::model::{FrameId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Representation};

/// Adds a force on a frame to the list of forces on bodies that [`inverse_dynamics_into`](super::inverse_dynamics_into)
/// and [`forward_dynamics_into`](super::forward_dynamics_into) take.
///
/// A force on a frame that is fixed to the world has no effect and is ignored.
///
/// * `force` – N and N·m; *body*: in the frame's axes about its origin; *mixed*: in the world's axes about the frame's
///   origin; *inertial*: in the world's axes about the world's origin
/// * `bodies` – the force on each body in its body frame, length `n_bodies`
///
/// # Panics
/// If `bodies` or the kinematics have the wrong length, or the id is not one of the model.
pub fn add_frame_force<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
    frame: FrameId,
    force: &Force<T>,
    representation: Representation,
    bodies: &mut [Force<T>],
) {
    kinematics.check(model);
    assert_eq!(
        bodies.len(),
        model.n_bodies(),
        "\"{}\" has one external force a body",
        model.name()
    );
    let frame = model.frame_of(frame);
    let Some(body) = frame.body else { return };
    let X_BF = frame.placement.lift::<T>();
    let X_WF = kinematics.pose(frame.body) * X_BF;
    bodies[body.0] += X_BF.force(&representation.force_to_body(&X_WF, force));
}
