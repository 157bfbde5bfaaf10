//! The set of differences q − p of points of two shapes: its distance from the origin is theirs.

use nalgebra::Vector3;

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

    /// Difference that lies farthest along a direction of any length.
    pub(super) fn support(&self, n: &Vector3<f64>) -> Vector3<f64> {
        self.b.support(n).point - self.a.support(&-n).point
    }

    /// Gap between planes across n with the cores on either side: at most their distance.
    pub(super) fn gap(&self, n: &Vector3<f64>) -> f64 {
        self.support(&-n).dot(n)
    }
}
