//! Volume and inertia of shapes, and their distance from a point.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::feature::Witness;
use super::nearest::nearest_features;
use super::shape::Shape;
use super::witness::witness;
use crate::model::{Geometry, Mass};
use crate::scalar::MapEach;
use crate::spatial::{Inertia, Transform};

/// Volume of an ellipsoid, in the product of its semi-axes.
const ELLIPSOID: f64 = 4.0 / 3.0 * PI;

impl Shape {
    /// The volume, m³; `None` for a half-space, and for a hull, which has no faces: see [`Hardware`](crate::model::Hardware) for meshes.
    pub fn volume(&self) -> Option<f64> {
        match self {
            Self::Ellipsoid {
                semi_axes: [a, b, c],
            } => Some(ELLIPSOID * a * b * c),
            _ => self.geometry()?.volume(),
        }
    }

    /// The inertia of a homogeneous solid of the shape in its own frame; `None` if there is no [`volume`](Self::volume).
    ///
    /// # Examples
    /// ```
    /// use dualbody::{collision::Shape, model::Mass};
    ///
    /// let ellipsoid = Shape::Ellipsoid { semi_axes: [1.0, 2.0, 3.0] };
    /// let inertia = ellipsoid.inertia(Mass::Kilograms(5.0)).unwrap();
    /// assert!((inertia.rotational.xx - 13.0).abs() < 1e-14); // m (b² + c²) / 5
    /// ```
    pub fn inertia(&self, mass: Mass) -> Option<Inertia<f64>> {
        match self {
            Self::Ellipsoid { semi_axes } => {
                let kilograms = match mass {
                    Mass::Kilograms(kilograms) => kilograms,
                    Mass::Density(density) => density * self.volume()?,
                };
                Some(Inertia::solid_ellipsoid(kilograms, *semi_axes))
            }
            _ => self.geometry()?.inertia(mass),
        }
    }

    /// The distance of a point from the shape at a pose `X_WS`, with the nearest point of the shape first and the normal from it; negative inside.
    /// `None` if an argument is not finite.
    ///
    /// * `point` – in the world, m
    pub fn distance_to_point(
        &self,
        X_WS: &Transform<f64>,
        point: &Vector3<f64>,
    ) -> Option<Witness<f64>> {
        let (ball, at) = (
            Self::Sphere { radius: 0.0 },
            Transform::from_translation(*point),
        );
        let pair = nearest_features(self, X_WS, &ball, &at)?;
        Some(witness(&pair, self, X_WS, &ball, &at))
    }

    /// The shape as files have it.
    fn geometry(&self) -> Option<Geometry> {
        match *self {
            Self::Sphere { radius } => Some(Geometry::Sphere { radius }),
            Self::Capsule {
                radius,
                half_length,
            } => Some(Geometry::Capsule {
                radius,
                length: 2.0 * half_length,
            }),
            Self::Cylinder {
                radius,
                half_length,
            } => Some(Geometry::Cylinder {
                radius,
                length: 2.0 * half_length,
            }),
            Self::Box { half_extents } => Some(Geometry::Box {
                size: half_extents.map_each(|x| 2.0 * x),
            }),
            Self::Ellipsoid { semi_axes } => Some(Geometry::Ellipsoid {
                size: semi_axes.map_each(|x| 2.0 * x),
            }),
            _ => None,
        }
    }
}
