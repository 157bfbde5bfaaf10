//! Points of a shape that are near to a body by a signed distance.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::Range;

use nalgebra::Vector3;

use super::feature::{Feature, FeatureId, NormalSource, PairFeature, Witness};
use super::field::DistanceField;
use super::guard::normalized_or;
use super::placed::Placed;
use super::shape::{RIM_VERTICES, Shape};
use super::solid::Solid;
use crate::scalar::{Over, Scalar};
use crate::spatial::Transform;
use crate::spatial::linear::{rotate, rotate_back, scale};

/// The field of a shape, if it is one.
fn field_of<P>(shape: &Shape<P>) -> Option<&DistanceField> {
    match shape {
        Shape::Field { field } => Some(field),
        _ => None,
    }
}

/// Whether one of two shapes is a field.
pub(super) fn is_field<P>(a: &Shape<P>, b: &Shape<P>) -> bool {
    field_of(a).or(field_of(b)).is_some()
}

/// The vertices of a shape that can touch a field.
fn points_of<P: Scalar>(shape: &Shape<P>) -> Range<u32> {
    match shape {
        Shape::HalfSpace | Shape::Field { .. } => 0..0,
        Shape::Cylinder { .. } => 2..2 + 2 * RIM_VERTICES,
        Shape::Ellipsoid { .. } => 1..shape.n_vertices(),
        _ => 0..shape.n_vertices(),
    }
}

/// Hands on each pair of a field and a point of the other shape, with their distance.
pub(super) fn each_pair(a: &Solid<'_>, b: &Solid<'_>, each: &mut dyn FnMut(PairFeature, f64)) {
    let (solid, field, other, sign) = match (field_of(a.shape), field_of(b.shape)) {
        (Some(field), None) => (a, field, b, 1.0),
        (None, Some(field)) => (b, field, a, -1.0),
        _ => return,
    };
    for k in points_of(other.shape) {
        let x = solid
            .X
            .rotation
            .tr_mul(&(other.vertex(k) - solid.X.translation));
        let Some(found) = field.value(&x) else {
            continue;
        };
        let out = Vector3::from(found.gradient).try_normalize(f64::MIN_POSITIVE);
        let seed = solid.X.rotation * out.unwrap_or_else(Vector3::z) * sign;
        let features = [Feature::Surface, Feature::Vertex(k)];
        let features = if sign > 0.0 {
            features
        } else {
            [features[1], features[0]]
        };
        let id = FeatureId {
            features,
            normal: NormalSource::Features,
        };
        each(PairFeature { id, seed }, found.distance - other.radius());
    }
}

/// The pair of a field and the nearest point of the other shape.
pub(super) fn nearest_to_field(a: &Solid<'_>, b: &Solid<'_>) -> Option<PairFeature> {
    let mut best: Option<(PairFeature, f64)> = None;
    each_pair(a, b, &mut |pair, distance| {
        if best.is_none_or(|(_, least)| distance < least) {
            best = Some((pair, distance));
        }
    });
    best.map(|(pair, _)| pair)
}

/// Distance, points and normal of a pair of which one is a field; `None` of another one.
pub(super) fn field_witness<P: Scalar, T: Over<P>>(
    pair: &PairFeature,
    [a, b]: [&Shape<P>; 2],
    [X_A, X_B]: [&Transform<T>; 2],
) -> Option<Witness<T>> {
    let [first, second] = pair.id.features;
    let (field, X, point, is_first) = match (field_of(a), field_of(b)) {
        (Some(field), None) => (field, X_A, Placed::new(second, b, X_B), true),
        (None, Some(field)) => (field, X_B, Placed::new(first, a, X_A), false),
        _ => return None,
    };
    let seed = pair.seed * if is_first { 1.0 } else { -1.0 };
    Some(witness_of_point(field, X, &point, &seed, is_first))
}

/// Distance, points and normal of a field and a point with a radius, once for all types of sizes.
///
/// * `seed` – direction out of the field
/// * `is_first` – whether the field is the first of the two
fn witness_of_point<T: Scalar>(
    field: &DistanceField,
    X: &Transform<T>,
    point: &Placed<T>,
    seed: &Vector3<f64>,
    is_first: bool,
) -> Witness<T> {
    let (center, radius) = (point.center, point.radius);
    let (distance, gradient) = field.at(&rotate_back(&X.rotation, &(center - X.translation)));
    let sign = if is_first { 1.0 } else { -1.0 };
    let seed = seed.map(T::constant);
    let out = normalized_or(&rotate(&X.rotation, &gradient), T::zero(), &seed);
    let on_field = center - scale(&out, distance);
    let on_point = center - scale(&out, radius);
    Witness {
        distance: distance - radius,
        points: if is_first {
            [on_field, on_point]
        } else {
            [on_point, on_field]
        },
        normal: scale(&out, T::constant(sign)),
    }
}
