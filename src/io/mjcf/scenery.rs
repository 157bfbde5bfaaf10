//! Planes and height fields of the world that are not its ground: shapes of the link `world`.

use crate::collision::Surface;
use crate::spatial::Transform;

/// Name of the link that is the world itself.
pub(super) const WORLD: &str = "world";

/// The most triangles of height fields beside the ground: each is a shape of its own.
pub(super) const MOST_TRIANGLES: usize = 100_000;

/// A shape of the world.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Scenery {
    /// The half-space below the plane z = 0 of a pose.
    Plane(Transform<f64>),
    /// The triangles of a height field, in the world.
    Heights(Surface),
}

impl Scenery {
    /// Number of its shapes.
    pub(super) fn shapes(&self) -> usize {
        match self {
            Self::Plane(_) => 1,
            Self::Heights(surface) => surface.triangles().len(),
        }
    }
}
