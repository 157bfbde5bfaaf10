//! Shapes for the HTML viewer.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use serde::Serialize;

use super::meshes::Piece;
use crate::spatial::{Quaternion, Transform};

/// Position and quaternion (x, y, z, w, i, j, k).
pub(super) type Pose = [f64; 7];

/// A shape on a body, or on the world.
#[derive(Debug, Serialize)]
pub(super) struct Shape {
    pub(super) body: Option<usize>,
    pub(super) pose: Pose,
    /// `None` is the colour of things without one.
    pub(super) color: Option<[f64; 4]>,
    #[serde(flatten)]
    pub(super) piece: Piece,
}

/// A transform as position and quaternion.
pub(super) fn pose(X: &Transform<f64>) -> Pose {
    let (p, q) = (&X.translation, Quaternion::from_matrix(&X.rotation));
    [p.x, p.y, p.z, q.w, q.xyz.x, q.xyz.y, q.xyz.z]
}
