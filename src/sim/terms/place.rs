//! Gradient in the pose of an attachment frame in its frame, and of that frame on its body.

use crate::scalar::Scalar;
use crate::spatial::{Force, Transform};

/// Derivatives in the increments of two placements.
pub(super) struct PlaceDerivatives<T> {
    /// Of the frame on its body, along the axes of the frame.
    pub(super) frame: Force<T>,
    /// Of the attachment frame: its origin in the frame, and its rotation about its own axes.
    pub(super) place: Force<T>,
}

impl<T: Scalar> PlaceDerivatives<T> {
    /// From the derivative in a small motion of the attachment frame, in the body: it moves in its frame as that frame moves on its body.
    ///
    /// * `frame` – pose of the frame on the body; `None` for the world itself
    /// * `place` – pose of the attachment frame on the body
    pub(super) fn of(
        moved: &Force<T>,
        frame: Option<&Transform<f64>>,
        place: &Transform<f64>,
    ) -> Self {
        let in_frame = frame.map_or(*moved, |frame| frame.force_inverse(moved));
        let turn = place.force_inverse(moved).angular;
        Self {
            frame: in_frame,
            place: Force::new(in_frame.linear, turn),
        }
    }
}
