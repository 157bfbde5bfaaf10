//! Size parameters of shapes.

use std::fmt;

use crate::model::Geometry;
use crate::scalar::MapEach;

/// A design parameter of a link: a size of its shape, or its density.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Dimension {
    /// Edge of a box along x, m; scale of a mesh along x.
    X,
    /// Edge of a box along y, m; scale of a mesh along y.
    Y,
    /// Edge of a box along z, m; scale of a mesh along z.
    Z,
    /// Radius of a cylinder, capsule or sphere, m.
    Radius,
    /// Length of a cylinder, m; of a capsule without its hemispheres.
    Length,
    /// Mass divided by the volume of the shape, kg/m³.
    Density,
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::Radius => "radius",
            Self::Length => "length",
            Self::Density => "density",
        })
    }
}

/// The sizes that a shape has, in the order of its fields.
pub(super) fn dimensions_of(shape: &Geometry) -> &'static [Dimension] {
    match shape {
        Geometry::Box { .. } | Geometry::Ellipsoid { .. } | Geometry::Mesh { .. } => {
            &[Dimension::X, Dimension::Y, Dimension::Z]
        }
        Geometry::Cylinder { .. } | Geometry::Capsule { .. } => {
            &[Dimension::Radius, Dimension::Length]
        }
        Geometry::Sphere { .. } => &[Dimension::Radius],
    }
}

/// The sizes of a shape, in the order of [`dimensions_of`]; of a mesh that is mirrored, without the sign.
pub(super) fn sizes_of(shape: &Geometry) -> Vec<f64> {
    match *shape {
        Geometry::Box { size } | Geometry::Ellipsoid { size } => size.to_vec(),
        Geometry::Mesh { scale, .. } => scale.map_each(f64::abs).to_vec(),
        Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
            vec![radius, length]
        }
        Geometry::Sphere { radius } => vec![radius],
    }
}

/// A shape of the same kind with other sizes, in the order of [`dimensions_of`].
pub(super) fn resized(shape: &Geometry, sizes: &[f64]) -> Geometry {
    let mut shape = shape.clone();
    match &mut shape {
        Geometry::Box { size } | Geometry::Ellipsoid { size } => size.copy_from_slice(sizes),
        Geometry::Mesh { scale, .. } => {
            for (own, size) in scale.iter_mut().zip(sizes) {
                *own = size.copysign(*own);
            }
        }
        Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
            (*radius, *length) = (sizes[0], sizes[1]);
        }
        Geometry::Sphere { radius } => *radius = sizes[0],
    }
    shape
}

/// The name of a shape in a sentence.
pub(super) fn noun(shape: &Geometry) -> &'static str {
    match shape {
        Geometry::Box { .. } => "a box",
        Geometry::Cylinder { .. } => "a cylinder",
        Geometry::Capsule { .. } => "a capsule",
        Geometry::Sphere { .. } => "a sphere",
        Geometry::Ellipsoid { .. } => "an ellipsoid",
        Geometry::Mesh { .. } => "a mesh",
    }
}
