//! A shape at a pose, on plain values: how far it reaches, and with which vertices.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use crate::nested::IntoNested;
use nalgebra::Vector3;

use super::feature::{Face, Feature};
use super::shape::Shape;
use crate::scalar::MapEach;
use crate::spatial::Transform;
use crate::spatial::linear::columns;

/// Largest length, m: squares of lengths, and products of two squares, are finite.
const LARGEST: f64 = 1e100;

/// A shape at a pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solid<'a> {
    pub(super) shape: &'a Shape,
    pub(super) X: Transform<f64>,
}

/// Farthest point of a core, with the vertex on which it lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    pub(super) point: Vector3<f64>,
    pub(super) vertex: u32,
}

impl<'a> Solid<'a> {
    pub(super) fn new(shape: &'a Shape, X: &Transform<f64>) -> Self {
        Self { shape, X: *X }
    }

    /// Whether no number is infinite, or so large that its square is.
    pub(super) fn is_finite(&self) -> bool {
        let sizes: &[f64] = match self.shape {
            Shape::Sphere { radius } => &[*radius],
            Shape::Capsule {
                radius,
                half_length,
            }
            | Shape::Cylinder {
                radius,
                half_length,
            } => &[*radius, *half_length],
            Shape::Box { half_extents: x }
            | Shape::Ellipsoid { semi_axes: x }
            | Shape::Hull { scale: x, .. } => x,
            Shape::Triangle { .. } | Shape::HalfSpace | Shape::Field { .. } => &[],
        };
        let corners = match self.shape {
            Shape::Triangle { vertices } => vertices.as_slice(),
            _ => &[],
        };
        let corners = corners.iter().nested(|v| v.iter());
        // Without an early end, so that numbers are compared together.
        let is_small = |all: bool, x: &f64| all & (x.abs() <= LARGEST);
        let [rotation, translation] = [self.X.rotation.as_slice(), self.X.translation.as_slice()];
        let pose = rotation.iter().fold(true, is_small);
        let place = translation.iter().fold(pose, is_small);
        let sized = sizes.iter().fold(place, is_small);
        corners.fold(sized, is_small)
    }

    /// A vertex in world axes.
    pub(super) fn vertex(&self, index: u32) -> Vector3<f64> {
        self.X.point(&self.shape.vertex(index))
    }

    /// The vertices of a box in world axes, each as [`vertex`](Self::vertex) gives it.
    pub(super) fn corners_of_box(&self, half_extents: &[f64; 3]) -> [Vector3<f64>; 8] {
        let [x, y, z] = columns(&self.X.rotation);
        let [a, b, c] = *half_extents;
        let (x, y, z, at) = (x * a, y * b, z * c, self.X.translation);
        let [both, first, second] = [y + z, y - z, z - y];
        [
            -x - both + at,
            x - both + at,
            first - x + at,
            x + first + at,
            second - x + at,
            x + second + at,
            both - x + at,
            x + both + at,
        ]
    }

    /// The point of the shape, without the radius around its core, that lies farthest along a direction of any length.
    pub(super) fn support(&self, n: &Vector3<f64>) -> Support {
        let n = self.X.rotation.tr_mul(n);
        let vertex = self.farthest_vertex(&n);
        let point = self.X.point(&(self.shape.vertex(vertex) + self.bulge(&n)));
        Support { point, vertex }
    }

    /// Coordinate along an axis of the world of the point, without the radius around the core, that lies farthest to the side of a sign.
    pub(super) fn reach_along(&self, axis: usize, sign: f64) -> f64 {
        let row = self.X.rotation.row(axis);
        let n = row.transpose() * sign;
        let point = self.shape.vertex(self.farthest_vertex(&n)) + self.bulge(&n);
        row[0] * point.x + row[1] * point.y + row[2] * point.z + self.X.translation[axis]
    }

    /// Vertex that lies farthest along a direction in the frame of the shape.
    fn farthest_vertex(&self, n: &Vector3<f64>) -> u32 {
        let side = |axis: usize| u32::from(n[axis] > 0.0);
        match self.shape {
            Shape::Sphere { .. } | Shape::Ellipsoid { .. } | Shape::HalfSpace => 0,
            Shape::Capsule { .. } | Shape::Cylinder { .. } => side(2),
            Shape::Box { .. } | Shape::Field { .. } => side(0) | side(1) << 1 | side(2) << 2,
            Shape::Hull { hull, scale } => {
                let n = Vector3::from_fn(|axis, _| n[axis] * scale[axis]);
                farthest_of(hull.vertices(), &n)
            }
            Shape::Triangle { vertices } => farthest_of(vertices, n),
        }
    }

    /// The part of a curved shape beyond its farthest vertex.
    fn bulge(&self, n: &Vector3<f64>) -> Vector3<f64> {
        match self.shape {
            Shape::Cylinder { radius, .. } => {
                let length = n.x.hypot(n.y);
                let factor = if length > 0.0 { radius / length } else { 0.0 };
                Vector3::new(n.x * factor, n.y * factor, 0.0)
            }
            Shape::Ellipsoid {
                semi_axes: [a, b, c],
            } => {
                let m = Vector3::new(a * n.x, b * n.y, c * n.z);
                let length = m.norm();
                let factor = if length > 0.0 { 1.0 / length } else { 0.0 };
                Vector3::new(a * m.x, b * m.y, c * m.z) * factor
            }
            _ => Vector3::zeros(),
        }
    }

    /// Sine of the angle between a unit direction and an axis of the shape.
    pub(super) fn tilt(&self, axis: usize, n: &Vector3<f64>) -> f64 {
        self.X.rotation.column(axis).cross(n).norm()
    }

    /// Feature whose supporting point lies farthest along a direction.
    pub(super) fn extreme_feature(&self, n: &Vector3<f64>) -> Feature {
        let vertex = self.support(n).vertex;
        match self.shape {
            Shape::Cylinder { .. } => Feature::Rim(vertex),
            Shape::Ellipsoid { .. } => Feature::Surface,
            _ => Feature::Vertex(vertex),
        }
    }

    /// The face whose normal is along an axis of the shape, of a triangle across it, on the side to which a direction points.
    pub(super) fn face(&self, axis: usize, n: &Vector3<f64>) -> Face {
        match self.shape {
            Shape::Triangle { .. } => {
                let [a, b, c] = [0, 1, 2].map_each(|k| self.vertex(k));
                let is_above = (b - a).cross(&(c - a)).dot(n) > 0.0;
                Face::Vertices(if is_above { [0, 1, 2] } else { [0, 2, 1] })
            }
            Shape::Cylinder { .. } => Face::Cap(u32::from(self.is_above(2, n))),
            _ => {
                // Counter-clockwise from outside: axes i, j, k are a right-handed frame.
                let [i, j, k] = [axis + 1, axis + 2, axis].map_each(|k| 1 << (k % 3));
                Face::Vertices(if self.is_above(axis, n) {
                    [k, k | i, k | j]
                } else {
                    [0, j, i]
                })
            }
        }
    }

    /// The vertices of an edge that lies farthest along a direction: of the k-th edge, of a box of those along its k-th axis.
    pub(super) fn edge(&self, k: u32, n: &Vector3<f64>) -> [u32; 2] {
        match self.shape {
            Shape::Box { .. } => {
                let vertex = self.support(n).vertex;
                [vertex & !(1 << k), vertex | 1 << k]
            }
            Shape::Triangle { .. } => [k, (k + 1) % 3],
            _ => [0, 1],
        }
    }

    fn is_above(&self, axis: usize, n: &Vector3<f64>) -> bool {
        self.X.rotation.column(axis).dot(n) > 0.0
    }

    /// Radius of the rims of a cylinder.
    pub(super) fn rim_radius(&self) -> f64 {
        match self.shape {
            Shape::Cylinder { radius, .. } => *radius,
            _ => 0.0,
        }
    }

    /// Radius around the core.
    pub(super) fn radius(&self) -> f64 {
        match self.shape {
            Shape::Sphere { radius } | Shape::Capsule { radius, .. } => *radius,
            _ => 0.0,
        }
    }

    /// Distance from the origin of world axes within which the core lies.
    pub(super) fn reach(&self) -> f64 {
        let own = match self.shape {
            Shape::Ellipsoid {
                semi_axes: [a, b, c],
            } => a.max(*b).max(*c),
            Shape::Cylinder {
                radius,
                half_length,
            } => radius.hypot(*half_length),
            Shape::Hull { .. } | Shape::Triangle { .. } => self.farthest_of_vertices(),
            shape => shape.vertex(0).norm(),
        };
        self.X.translation.norm() + own
    }

    fn farthest_of_vertices(&self) -> f64 {
        let vertices = 0..self.shape.n_vertices();
        let lengths = vertices.map(|k| self.shape.vertex(k).norm());
        lengths.fold(0.0, f64::max)
    }
}

/// The vertex, by its index, that lies farthest along a direction.
fn farthest_of(vertices: &[Vector3<f64>], n: &Vector3<f64>) -> u32 {
    let reaches = vertices.iter().map(|v| v.dot(n)).enumerate();
    let farthest = |a: (usize, f64), b: (usize, f64)| if b.1 > a.1 { b } else { a };
    reaches.fold((0, f64::NEG_INFINITY), farthest).0 as u32
}
