//! Corners and sides of the flat part of a shape, seen along a direction.

use nalgebra::{Vector2, Vector3};

use super::feature::Feature;
use super::guard::plane_across;
use super::placed::Placed;
use super::solid::Solid;

/// A corner of a polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) feature: Feature,
    /// Vertex by which edges name the corner.
    pub(super) vertex: u32,
    /// Where it is in world axes, if the feature is that vertex.
    pub(super) point: Vector3<f64>,
    /// Place across the direction.
    pub(super) at: Vector2<f64>,
}

/// The corners at the ends of a side of a polygon.
pub(super) type Ends<'a> = [&'a Corner; 2];

/// The side as a feature.
pub(super) fn edge([a, b]: Ends<'_>) -> Feature {
    Feature::Edge([a.vertex, b.vertex])
}

/// The side in world axes.
pub(super) fn placed_edge([a, b]: Ends<'_>, solid: &Solid<'_>) -> Placed<f64> {
    let edge = edge([a, b]);
    match (a.feature, b.feature) {
        (Feature::Vertex(_), Feature::Vertex(_)) => {
            Placed::of_edge(edge, [a.point, b.point], solid.shape)
        }
        _ => Placed::new(edge, solid.shape, &solid.X),
    }
}

impl Corner {
    /// The feature in world axes.
    pub(super) fn placed(&self, solid: &Solid<'_>) -> Placed<f64> {
        match self.feature {
            Feature::Vertex(_) => Placed::of_vertex(self.point, solid.shape),
            feature => Placed::new(feature, solid.shape, &solid.X),
        }
    }
}

/// Two axes across a normal, such that x × y = n.
#[derive(Clone, Copy, Debug)]
pub(super) struct Across {
    x: Vector3<f64>,
    y: Vector3<f64>,
}

impl Across {
    pub(super) fn new(n: &Vector3<f64>) -> Self {
        let [x, y] = plane_across(n);
        Self { x, y }
    }

    pub(super) fn place(&self, p: &Vector3<f64>) -> Vector2<f64> {
        Vector2::new(self.x.dot(p), self.y.dot(p))
    }
}
