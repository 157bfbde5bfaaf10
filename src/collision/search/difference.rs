//! The set of differences q − p of points of two shapes: its distance from the origin is theirs.

use nalgebra::Vector3;

use crate::collision::shape::Shape;
use crate::collision::solid::Solid;

/// Differences of the points of two cores, of the second those of the first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Difference<'a> {
    pub(super) a: Solid<'a>,
    pub(super) b: Solid<'a>,
    /// Length by which roundings are judged, m.
    pub(super) size: f64,
}

impl<'a> Difference<'a> {
    pub(super) fn new(a: Solid<'a>, b: Solid<'a>) -> Self {
        let size = a.reach() + b.reach();
        Self { a, b, size }
    }

    /// Whether one of the shapes is not a polytope with a radius around it.
    pub(super) fn is_curved(&self) -> bool {
        let is_curved = |solid: &Solid<'_>| {
            matches!(
                solid.shape,
                Shape::Cylinder { .. } | Shape::Ellipsoid { .. }
            )
        };
        is_curved(&self.a) || is_curved(&self.b)
    }

    /// Difference that lies farthest along a direction of any length.
    pub(super) fn support(&self, n: &Vector3<f64>) -> Vector3<f64> {
        self.b.support(n).point - self.a.support(&-n).point
    }

    /// Gap between planes across n with the cores on either side: at most their distance.
    pub(super) fn gap(&self, n: &Vector3<f64>) -> f64 {
        self.support(&-n).dot(n)
    }
}
