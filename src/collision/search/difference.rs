//! The set of differences q − p of points of two shapes: its distance from the origin is theirs.

use nalgebra::Vector3;

use crate::collision::shape::Shape;
use crate::collision::solid::Solid;
use crate::spatial::linear::columns;

/// Differences of the points of two cores, of the second those of the first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Difference<'a> {
    pub(super) a: Solid<'a>,
    pub(super) b: Solid<'a>,
    /// Length by which roundings are judged, m.
    pub(super) size: f64,
    /// Those of both cores; `None` where one is of another kind.
    spans: Option<[Span; 2]>,
}

/// The sum of segments about a centre: a box, the axis of a capsule, a point.
#[derive(Clone, Copy, Debug)]
struct Span {
    halves: [Vector3<f64>; 3],
    len: usize,
}

impl Span {
    fn new(solid: &Solid<'_>) -> Option<Self> {
        let [x, y, z] = columns(&solid.X.rotation);
        let (halves, len) = match solid.shape {
            Shape::Sphere { .. } => ([x, y, z], 0),
            Shape::Capsule { half_length, .. } => ([z * *half_length, x, y], 1),
            Shape::Box {
                half_extents: [a, b, c],
            } => ([x * *a, y * *b, z * *c], 3),
            _ => return None,
        };
        Some(Self { halves, len })
    }

    /// How far it reaches beyond its centre along a direction of any length, times that length.
    fn reach(&self, n: &Vector3<f64>) -> f64 {
        let [a, b, c] = &self.halves;
        let along = |half: &Vector3<f64>| half.dot(n).abs();
        match self.len {
            0 => 0.0,
            1 => along(a),
            _ => along(a) + along(b) + along(c),
        }
    }
}

impl<'a> Difference<'a> {
    pub(super) fn new(a: Solid<'a>, b: Solid<'a>) -> Self {
        let size = a.reach() + b.reach();
        let spans = Span::new(&a).zip(Span::new(&b));
        Self {
            a,
            b,
            size,
            spans: spans.map(|(a, b)| [a, b]),
        }
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
        match &self.spans {
            Some([a, b]) => {
                let apart = self.b.X.translation - self.a.X.translation;
                apart.dot(n) - a.reach(n) - b.reach(n)
            }
            None => self.support(&-n).dot(n),
        }
    }
}
