//! The nearest features of two shapes, found on plain values.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::clip::manifold;
use super::feature::{Face, Feature, FeatureId, Manifold, NormalSource, PairFeature};
use super::field_pairs::nearest_to_field;
use super::point_cylinder::nearest_to_center;
use super::search::search;
use super::segments::nearest_of_segments;
use super::shape::Shape;
use super::solid::Solid;
use crate::scalar::Scalar;
use crate::spatial::Transform;

/// Finds the nearest features of two shapes; for overlapping shapes those of the shortest translation that separates them.
///
/// [`witness`](super::witness) computes distance, points and normal from them. `None` for two half-spaces, a [field](super::DistanceField) with a half-space or a field, and if an argument is not finite or a
/// length is above 10¹⁰⁰ m.
///
/// If several pairs are equally near, it returns one of them, always the same. If points coincide, the normal is perpendicular to both cores, or z of the world.
///
/// * `X_WA`, `X_WB` – poses of the shapes in the world
pub fn nearest_features(
    a: &Shape,
    X_WA: &Transform<f64>,
    b: &Shape,
    X_WB: &Transform<f64>,
) -> Option<PairFeature> {
    let [X_A, X_B] = about_first(X_WA, X_WB);
    nearest_within(&Solid::new(a, &X_A), &Solid::new(b, &X_B), f64::INFINITY)
}

/// The nearest features of two solids; where these are farther apart than a margin, the same or none.
fn nearest_within(a: &Solid<'_>, b: &Solid<'_>, margin: f64) -> Option<PairFeature> {
    if !(a.is_finite() && b.is_finite()) {
        return None;
    }
    match (a.shape, b.shape) {
        (Shape::Field { .. }, _) | (_, Shape::Field { .. }) => nearest_to_field(a, b),
        (Shape::HalfSpace, Shape::HalfSpace) => None,
        (Shape::HalfSpace, _) => Some(on_plane(a, b)),
        (_, Shape::HalfSpace) => Some(swapped(on_plane(b, a))),
        (
            Shape::Sphere { .. } | Shape::Capsule { .. },
            Shape::Sphere { .. } | Shape::Capsule { .. },
        ) => nearest_of_segments(a, b, margin),
        (
            Shape::Cylinder {
                radius,
                half_length,
            },
            Shape::Sphere { .. },
        ) => Some(nearest_to_center(a, *radius, *half_length, b)),
        (
            Shape::Sphere { .. },
            Shape::Cylinder {
                radius,
                half_length,
            },
        ) => Some(swapped(nearest_to_center(b, *radius, *half_length, a))),
        _ => search(a, b, margin),
    }
}

/// Finds the features at which two shapes touch: at most eight pairs, the nearest first; no pair if the distance of the shapes exceeds the margin.
///
/// Pairs keep their [identity](PairFeature::id) from step to step. Does not allocate.
///
/// * `margin` – maximum distance of a pair, m
/// * `out` – output
pub fn features(
    a: &Shape,
    X_WA: &Transform<f64>,
    b: &Shape,
    X_WB: &Transform<f64>,
    margin: f64,
    out: &mut Manifold,
) {
    out.clear();
    let [X_A, X_B] = about_first(X_WA, X_WB);
    let (a, b) = (Solid::new(a, &X_A), Solid::new(b, &X_B));
    if let Some(pair) = nearest_within(&a, &b, margin) {
        manifold(&a, &b, pair, margin, out);
    }
}

/// The poses about the origin of the first shape: far from the world's no digit is lost.
pub(super) fn about_first<T: Scalar>(
    X_WA: &Transform<T>,
    X_WB: &Transform<T>,
) -> [Transform<T>; 2] {
    let zero = Vector3::from_element(T::zero());
    [
        Transform::new(X_WA.rotation, zero),
        Transform::new(X_WB.rotation, X_WB.translation - X_WA.translation),
    ]
}

/// The feature of a shape that is nearest to a half-space, or deepest in it.
fn on_plane(plane: &Solid<'_>, b: &Solid<'_>) -> PairFeature {
    let normal = plane.X.rotation.column(2).into_owned();
    PairFeature {
        id: FeatureId {
            features: [Feature::Vertex(0), b.extreme_feature(&-normal)],
            normal: NormalSource::First(Face::Plane),
        },
        seed: normal,
    }
}

/// The pair of the second shape with the first.
fn swapped(pair: PairFeature) -> PairFeature {
    let [first, second] = pair.id.features;
    let normal = match pair.id.normal {
        NormalSource::First(face) => NormalSource::Second(face),
        NormalSource::Second(face) => NormalSource::First(face),
        NormalSource::Features => NormalSource::Features,
    };
    PairFeature {
        id: FeatureId {
            features: [second, first],
            normal,
        },
        seed: -pair.seed,
    }
}
