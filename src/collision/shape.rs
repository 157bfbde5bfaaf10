//! Convex shapes in their own frames.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::Vector3;

use super::field::DistanceField;
use super::hull::Hull;
use crate::numbers::numbers;
use crate::scalar::{MapEach, Scalar};

/// A shape in its own frame, convex but for a [`Field`](Self::Field), centred at the origin, axes along z; lengths in m.
///
/// Sizes are data of type `P`: over dual numbers, distances are differentiable in them. A size may be zero: a sphere of radius zero is a point, a box
/// with one zero extent is a rectangle.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Shape<P = f64> {
    /// A sphere.
    Sphere {
        /// Radius.
        radius: P,
    },
    /// A cylinder about z with hemispheres at its ends.
    Capsule {
        /// Radius.
        radius: P,
        /// Half the length of the cylinder, without the half spheres.
        half_length: P,
    },
    /// A box with edges along the axes.
    Box {
        /// Half the edge lengths.
        half_extents: [P; 3],
    },
    /// A cylinder about z.
    Cylinder {
        /// Radius.
        radius: P,
        /// Half the length.
        half_length: P,
    },
    /// An ellipsoid along the axes of the frame.
    Ellipsoid {
        /// Semi-axes.
        semi_axes: [P; 3],
    },
    /// The convex hull of points, scaled along the axes; a negative scale mirrors it.
    Hull {
        /// The vertices before they are scaled.
        hull: Arc<Hull>,
        /// Scale along the axes.
        scale: [P; 3],
    },
    /// A flat triangle, for example of a mesh; its vertices have no derivatives.
    Triangle {
        /// The vertices.
        vertices: [Vector3<f64>; 3],
    },
    /// The half-space z ≤ 0.
    HalfSpace,
    /// A body of any form by a user's function; its distance is that of points of the other shape.
    Field {
        /// The signed distance, which has no parameters.
        field: DistanceField,
    },
}

numbers! { pub enum Shape {
    Sphere { radius: NotNegative("radius", "radius of a sphere") },
    Capsule {
        radius: NotNegative("radius", "radius of a capsule"),
        half_length: NotNegative("half length", "half length of a capsule"),
    },
    Box { half_extents: NotNegative(["half extent x", "half extent y", "half extent z"], "half extent of a box") },
    Cylinder {
        radius: NotNegative("radius", "radius of a cylinder"),
        half_length: NotNegative("half length", "half length of a cylinder"),
    },
    Ellipsoid { semi_axes: NotNegative(["semi-axis x", "semi-axis y", "semi-axis z"], "semi-axis of an ellipsoid") },
    Hull { hull: kept(), scale: Finite(["scale x", "scale y", "scale z"], "scale of a hull") },
    Triangle { vertices: kept() },
    HalfSpace {},
    Field { field: kept() },
} }

/// Fixed points on each rim of a cylinder.
pub(super) const RIM_VERTICES: u32 = 16;

impl<P: Scalar> Shape<P> {
    /// Number of vertices of the core: the polytope that, with a radius around it, makes the shape. Cylinders have the ends of their axes.
    pub(super) fn n_vertices(&self) -> u32 {
        match self {
            Self::Sphere { .. } | Self::HalfSpace => 1,
            Self::Ellipsoid { .. } => 7,
            Self::Capsule { .. } | Self::Cylinder { .. } => 2,
            Self::Box { .. } | Self::Field { .. } => 8,
            Self::Triangle { .. } => 3,
            Self::Hull { hull, .. } => hull.vertices().len() as u32,
        }
    }

    /// A vertex of the core, in the frame of the shape, m.
    pub(super) fn vertex(&self, index: u32) -> Vector3<P> {
        match self {
            Self::Sphere { .. } | Self::HalfSpace => Vector3::zeros(),
            Self::Ellipsoid { semi_axes } => tip(semi_axes, index),
            Self::Cylinder {
                radius,
                half_length,
            } if index > 1 => {
                let angle = f64::from(index / 2 - 1) * TAU / f64::from(RIM_VERTICES);
                let (sin, cos) = angle.sin_cos();
                let z = side(index, 0, *half_length);
                Vector3::new(*radius * cos, *radius * sin, z)
            }
            Self::Capsule { half_length, .. } | Self::Cylinder { half_length, .. } => {
                Vector3::new(P::zero(), P::zero(), side(index, 0, *half_length))
            }
            Self::Box { half_extents } => {
                Vector3::from_fn(|axis, _| side(index, axis, half_extents[axis]))
            }
            // The box that holds it.
            Self::Field { field } => {
                let [x, y, z] = field.half_extents().map_each(P::constant);
                Vector3::new(side(index, 0, x), side(index, 1, y), side(index, 2, z))
            }
            Self::Hull { hull, scale } => {
                let vertex = &hull.vertices()[index as usize];
                Vector3::from_fn(|axis, _| scale[axis] * vertex[axis])
            }
            Self::Triangle { vertices } => vertices[index as usize].map(P::constant),
        }
    }
}

/// The centre of an ellipsoid, or after it an end of an axis.
fn tip<P: Scalar>(semi_axes: &[P; 3], index: u32) -> Vector3<P> {
    let end = index.wrapping_sub(1);
    let on = |axis: usize| index > 0 && end / 2 == axis as u32;
    let along = |axis: usize| side(end, 0, semi_axes[axis]);
    Vector3::from_fn(|axis, _| if on(axis) { along(axis) } else { P::zero() })
}

/// The size along an axis, to the side that the index of a vertex has there.
fn side<P: Scalar>(index: u32, axis: usize, size: P) -> P {
    if index >> axis & 1 == 0 { -size } else { size }
}
