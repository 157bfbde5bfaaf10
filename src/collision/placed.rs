//! A feature of a shape at its place, over the scalar.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use super::feature::{Face, Feature};
use super::guard::{normalized_or, reciprocal_or_zero, safe_norm};
use super::shape::Shape;
use crate::scalar::{MapEach, Over, Scalar, is_more_than_values};
use crate::spatial::Transform;
use crate::spatial::linear::{
    columns, cross, dot, from_columns, lift_vector, rotate, rotate_back, scale,
};

/// Sine of the angle of a direction from the axis of a rim below which the point of the rim along it is rounding.
const STEADY: f64 = 1e-10;

/// Core of a feature.
#[derive(Clone, Copy, Debug)]
pub(super) enum Core<T> {
    Point,
    /// A line along a direction of any length.
    Line(Vector3<T>),
    /// The disc about a unit axis with a radius.
    Disc(Vector3<T>, T),
    /// The image of the unit ball under a linear map.
    Ellipsoid(Matrix3<T>),
}

/// A feature in world axes: a core about a centre, with a radius around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed<T> {
    pub(super) center: Vector3<T>,
    pub(super) core: Core<T>,
    pub(super) radius: T,
}

impl<T: Scalar> Placed<T> {
    /// The feature of a shape at a pose.
    pub(super) fn new<P: Scalar>(feature: Feature, shape: &Shape<P>, X: &Transform<T>) -> Self
    where
        T: Over<P>,
    {
        let at = |index| X.point(&lift_vector(&shape.vertex(index)));
        let (center, core) = match feature {
            Feature::Vertex(index) => return Self::of_vertex(at(index), shape),
            Feature::Edge([i, j]) => (at(i), Core::Line(at(j) - at(i))),
            Feature::Rim(end) => (at(end), disc(shape, X)),
            Feature::Surface => (X.translation, ellipsoid(shape, X)),
        };
        Self {
            center,
            core,
            radius: radius(feature, shape),
        }
    }

    /// A vertex whose place is known.
    pub(super) fn of_vertex<P: Scalar>(center: Vector3<T>, shape: &Shape<P>) -> Self
    where
        T: Over<P>,
    {
        Self {
            center,
            core: Core::Point,
            radius: radius(Feature::Vertex(0), shape),
        }
    }

    /// An edge between vertices whose places are known.
    pub(super) fn of_edge<P: Scalar>(
        edge: Feature,
        [a, b]: [Vector3<T>; 2],
        shape: &Shape<P>,
    ) -> Self
    where
        T: Over<P>,
    {
        Self {
            center: a,
            core: Core::Line(b - a),
            radius: radius(edge, shape),
        }
    }

    /// The point of the core that lies farthest along a unit direction; of a line any point.
    pub(super) fn support(&self, n: &Vector3<T>) -> Vector3<T> {
        match &self.core {
            Core::Point | Core::Line(_) => self.center,
            Core::Disc(axis, radius) => {
                let (across, _) = across(axis, n);
                self.center + scale(&across, *radius)
            }
            Core::Ellipsoid(map) => self.center + ellipsoid_support(map, n).0,
        }
    }

    /// The change of the supporting point with its direction n, along e: ∇²h(n) e with the support function h.
    pub(super) fn curvature(&self, n: &Vector3<T>, e: &Vector3<T>) -> Vector3<T> {
        match &self.core {
            Core::Point | Core::Line(_) => Vector3::from_element(T::zero()),
            // h = r ‖n⊥‖, ∇²h = r t tᵀ / ‖n⊥‖ with t along the rim
            Core::Disc(axis, radius) => {
                let (across, length) = across(axis, n);
                let along = cross(axis, &across);
                scale(
                    &along,
                    dot(&along, e) * *radius * reciprocal_or_zero(length),
                )
            }
            // h = ‖Mᵀ n‖, p = M Mᵀ n / h, ∇²h = (M Mᵀ − p pᵀ) / h
            Core::Ellipsoid(map) => {
                let (p, h) = ellipsoid_support(map, n);
                let stretched = rotate(map, &rotate_back(map, e));
                scale(&(stretched - scale(&p, dot(&p, e))), reciprocal_or_zero(h))
            }
        }
    }
}

impl Placed<f64> {
    /// Whether the normal of the feature has no closed form.
    pub(super) fn is_curved(&self) -> bool {
        matches!(self.core, Core::Disc(..) | Core::Ellipsoid(_))
    }
}

/// The unit direction across an axis towards n, zero along the axis, and the length of that part of n. By products, which are across the axis however short they are.
fn across<T: Scalar>(axis: &Vector3<T>, n: &Vector3<T>) -> (Vector3<T>, T) {
    let part = cross(axis, &cross(n, axis));
    let length = safe_norm(&part);
    let unit = scale(&part, reciprocal_or_zero(length));
    let steady = |unit: &Vector3<T>| {
        let fixed = unit.map(T::detached);
        fixed - scale(axis, dot(axis, &fixed))
    };
    (steady_below(unit, length, T::one(), steady), length)
}

/// A direction, or where a length has too few digits for its derivatives one that has fewer of these.
///
/// * `whole` – square of what the length is a part of
fn steady_below<T: Scalar>(
    unit: Vector3<T>,
    length: T,
    whole: T,
    steady: impl FnOnce(&Vector3<T>) -> Vector3<T>,
) -> Vector3<T> {
    if !is_more_than_values::<T>() {
        return unit;
    }
    let (square, least) = (length * length, whole * (STEADY * STEADY));
    let steady = steady(&unit);
    Vector3::from_fn(|k, _| square.select_lt(least, steady[k], unit[k]))
}

/// Farthest point of an ellipsoid from its centre, and how far that is along n.
fn ellipsoid_support<T: Scalar>(map: &Matrix3<T>, n: &Vector3<T>) -> (Vector3<T>, T) {
    let m = rotate_back(map, n);
    let h = safe_norm(&m);
    let unit = scale(&m, reciprocal_or_zero(h));
    let p = rotate(map, &unit);
    let steady = |_: &Vector3<T>| rotate(map, &unit.map(T::detached));
    (steady_below(p, h, dot(&p, &p), steady), h)
}

fn disc<P: Scalar, T: Over<P>>(shape: &Shape<P>, X: &Transform<T>) -> Core<T> {
    let radius = match shape {
        Shape::Cylinder { radius, .. } => T::from(*radius),
        _ => T::zero(),
    };
    Core::Disc(columns(&X.rotation)[2], radius)
}

fn ellipsoid<P: Scalar, T: Over<P>>(shape: &Shape<P>, X: &Transform<T>) -> Core<T> {
    let [x, y, z] = columns(&X.rotation);
    let [a, b, c] = match shape {
        Shape::Ellipsoid { semi_axes } => semi_axes.map_each(T::from),
        _ => [T::zero(); 3],
    };
    Core::Ellipsoid(from_columns(&scale(&x, a), &scale(&y, b), &scale(&z, c)))
}

/// Radius around the core of a feature.
fn radius<P: Scalar, T: Over<P>>(feature: Feature, shape: &Shape<P>) -> T {
    match (shape, feature) {
        (Shape::Sphere { radius } | Shape::Capsule { radius, .. }, _)
        | (Shape::Cylinder { radius, .. }, Feature::Edge([0, 1] | [1, 0])) => T::from(*radius),
        _ => T::zero(),
    }
}

/// The outward unit normal of a face, in world axes; along z of the shape where three vertices lie on a line.
pub(super) fn face_normal<P: Scalar, T: Over<P>>(
    face: Face,
    shape: &Shape<P>,
    X: &Transform<T>,
) -> Vector3<T> {
    let axes = columns(&X.rotation);
    let axis = axes[2];
    match face {
        Face::Flat(side) if side % 2 == 0 => -axes[side as usize / 2 % 3],
        Face::Flat(side) => axes[side as usize / 2 % 3],
        Face::Plane | Face::Cap(1) => axis,
        Face::Cap(_) => -axis,
        Face::Vertices(indices) => {
            let [a, b, c] = indices.map_each(|k| lift_vector::<P, T>(&shape.vertex(k)));
            let normal = cross(&(b - a), &(c - a));
            let up = Vector3::new(T::zero(), T::zero(), T::one());
            rotate(&X.rotation, &normalized_or(&normal, T::zero(), &up))
        }
    }
}
