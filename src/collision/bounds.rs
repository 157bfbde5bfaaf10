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
        match self {
            Self::HalfSpace => f64::INFINITY,
            Self::Sphere { radius } => *radius,
            Self::Capsule {
                radius,
                half_length,
            } => radius + half_length,
            Self::Box { half_extents } => Vector3::from(*half_extents).norm(),
            _ => Solid::new(self, &Transform::identity()).reach(),
        }
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
        let beyond = |radius: f64| Vector3::from_element(radius + margin);
        if let Some((half, radius)) = half_sizes(shape, X_WS) {
            let half = half + beyond(radius);
            return Self {
                low: X_WS.translation - half,
                high: X_WS.translation + half,
            };
        }
        let solid = Solid::new(shape, X_WS);
        let reach = |axis: usize, sign: f64| solid.reach_along(axis, sign);
        Self {
            low: Vector3::from_fn(|axis, _| reach(axis, -1.0)) - beyond(0.0),
            high: Vector3::from_fn(|axis, _| reach(axis, 1.0)) + beyond(0.0),
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
    #[inline]
    pub fn overlaps(&self, other: &Self) -> bool {
        // Without an early end, so that coordinates are compared together.
        let along = |k: usize| (self.low[k] <= other.high[k]) & (other.low[k] <= self.high[k]);
        along(0) & along(1) & along(2)
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

/// Half the sizes of the box around a shape that is the same from opposite sides, without a radius around it, and that radius; `None` for other shapes.
fn half_sizes(shape: &Shape, X_WS: &Transform<f64>) -> Option<(Vector3<f64>, f64)> {
    let R = &X_WS.rotation;
    let along = |half: &[f64; 3]| {
        let part = |axis: usize, k: usize| (R[(axis, k)] * half[k]).abs();
        Vector3::from_fn(|axis, _| part(axis, 0) + part(axis, 1) + part(axis, 2))
    };
    let axis = |half: f64| Vector3::from_fn(|axis, _| (R[(axis, 2)] * half).abs());
    Some(match shape {
        Shape::Sphere { radius } => (Vector3::zeros(), *radius),
        Shape::Capsule {
            radius,
            half_length,
        } => (axis(*half_length), *radius),
        Shape::Box { half_extents } => (along(half_extents), 0.0),
        Shape::Field { field } => (along(&field.half_extents()), 0.0),
        _ => return None,
    })
}
