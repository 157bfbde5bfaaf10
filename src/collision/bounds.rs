//! Axis-aligned bounding boxes of shapes in the world.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::shape::Shape;
use super::solid::Solid;
use crate::spatial::Transform;

/// An axis-aligned bounding box in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least coordinates, m.
    pub low: Vector3<f64>,
    /// Largest coordinates, m.
    pub high: Vector3<f64>,
}

impl Shape {
    /// Radius of a ball about the origin that holds the shape, m; that of a half-space is infinite.
    pub(crate) fn reach(&self) -> f64 {
        if let Self::HalfSpace = self {
            return f64::INFINITY;
        }
        let solid = Solid::new(self, &Transform::identity());
        solid.reach() + solid.radius()
    }
}

impl Bounds {
    /// The smallest box around a shape at a pose `X_WS`, widened by a margin, m. For a half-space it is unbounded.
    pub fn of(shape: &Shape, X_WS: &Transform<f64>, margin: f64) -> Self {
        if let Shape::HalfSpace = shape {
            let all = Vector3::from_element(f64::INFINITY);
            return Self {
                low: -all,
                high: all,
            };
        }
        let solid = Solid::new(shape, X_WS);
        let beyond = Vector3::from_element(solid.radius() + margin);
        let reach = |axis: usize, sign: f64| solid.reach_along(axis, sign);
        Self {
            low: Vector3::from_fn(|axis, _| reach(axis, -1.0)) - beyond,
            high: Vector3::from_fn(|axis, _| reach(axis, 1.0)) + beyond,
        }
    }

    /// The box, wider by a margin (m) on each side.
    pub(crate) fn widened(&self, margin: f64) -> Self {
        let beyond = Vector3::from_element(margin);
        Self {
            low: self.low - beyond,
            high: self.high + beyond,
        }
    }

    /// Whether two boxes overlap. A box with a NaN coordinate overlaps none.
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }

    /// The smallest box around two boxes.
    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            low: self.low.inf(&other.low),
            high: self.high.sup(&other.high),
        }
    }

    /// Whether all coordinates are finite.
    pub(super) fn is_finite(&self) -> bool {
        self.low
            .iter()
            .chain(self.high.iter())
            .all(|x| x.is_finite())
    }

    /// Half the area of the surface, m².
    pub(super) fn half_area(&self) -> f64 {
        let d = self.high - self.low;
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}
