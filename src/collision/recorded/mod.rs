//! Points of two shapes over numbers without values, as in a graph: every feature that could be the nearest takes part, and selects choose between them.
//!
//! Distances, points and normals are those of [`witness`](super::witness()): its kernels are evaluated for each candidate. A pair of shapes has a fixed
//! number of points; one that is not there is [out of reach](FAR). The points equal those that [`features`](super::features) finds, in another order, except
//! where features are equally near, and except upper corners of boxes that are twenty times wider than high.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

mod box_box;
mod capsule_box;
mod cuboid;
mod pack;
mod plane;
mod point_box;
mod rectangle;
mod round;
mod when;

use nalgebra::Vector3;

use super::feature::{Feature, FeatureId, MAX_POINTS, NormalSource, PairFeature, Witness};
use super::placed::{Core, Placed};
use super::shape::Shape;
use super::witness::{along, nearest_normal};
use crate::scalar::{MapEach, Scalar};
use crate::spatial::Transform;
use cuboid::Cuboid;
use plane::Plane;
use round::{MOST_ALONG, Round};

/// Distance of a point that is not there, m: no contact model reaches as far.
const FAR: f64 = 1e6;

/// Part of the size by which distances differ that are equal up to rounding.
const EQUAL: f64 = 1e-12;

/// Sine of the angle between edges below which they count as parallel.
const PARALLEL: f64 = 1e-9;

/// Normal of features that coincide.
const SEED: Vector3<f64> = Vector3::new(0.0, 0.0, 1.0);
/// The same of a line and a point on it, but for its part along the line: lines along it are rare.
const ASLANT: Vector3<f64> = Vector3::new(0.48, 0.6, 0.64);

/// A shape at a pose.
enum Solid<T> {
    /// A sphere or a capsule.
    Round(Round<T>),
    Box(Cuboid<T>),
    HalfSpace(Plane<T>),
}

impl<T: Scalar> Solid<T> {
    fn new(shape: &Shape<T>, X: &Transform<T>) -> Option<Self> {
        Some(match shape {
            Shape::Sphere { radius } => Self::Round(Round::point(X.translation, *radius)),
            Shape::Capsule { radius, .. } => {
                let ends = [0, 1].map_each(|k| X.point(&shape.vertex(k)));
                Self::Round(Round::segment(ends, *radius))
            }
            Shape::Box { half_extents } => Self::Box(Cuboid::new(X, *half_extents)),
            Shape::HalfSpace => Self::HalfSpace(Plane::new(X)),
            _ => return None,
        })
    }
}

/// The number of points of two shapes in a graph; `None` where their features cannot be chosen by selects.
pub(crate) fn recorded_points<P>(a: &Shape<P>, b: &Shape<P>) -> Option<usize> {
    use Shape::{Box, Capsule, HalfSpace, Sphere};
    match (a, b) {
        (Sphere { .. }, Sphere { .. } | Capsule { .. } | Box { .. } | HalfSpace)
        | (Capsule { .. }, Sphere { .. })
        | (Box { .. } | HalfSpace, Sphere { .. }) => Some(1),
        (Capsule { .. }, Box { .. } | HalfSpace) | (Box { .. } | HalfSpace, Capsule { .. }) => {
            Some(2)
        }
        (Capsule { .. }, Capsule { .. }) => Some(MOST_ALONG),
        (Box { .. }, HalfSpace) | (HalfSpace, Box { .. }) => Some(4),
        (Box { .. }, Box { .. }) => Some(MAX_POINTS),
        _ => None,
    }
}

/// The identity of a point in a graph: its number, since its features are not known.
pub(crate) fn recorded_feature(number: usize) -> PairFeature {
    PairFeature {
        id: FeatureId {
            features: [Feature::Vertex(number as u32), Feature::Surface],
            normal: NormalSource::Features,
        },
        seed: SEED,
    }
}

/// Distance, points and normal of a point of two shapes in a graph.
///
/// * `point` – a [`recorded_feature`]
/// * `shapes`, `X_W` – both shapes and their poses in the world
///
/// # Panics
/// If the shapes have no such point, see [`recorded_points`].
pub(crate) fn recorded_witness<T: Scalar>(
    point: &PairFeature,
    shapes: [&Shape<T>; 2],
    X_W: [&Transform<T>; 2],
) -> Witness<T> {
    let Feature::Vertex(number) = point.id.features[0] else {
        unreachable!("a point in a graph has a number");
    };
    // About the origin of one shape: far from the world's no digit is lost. About that of a box the graph is smaller.
    let is_flat = matches!(shapes[1], Shape::Box { .. } | Shape::HalfSpace);
    let origin = X_W[usize::from(is_flat)].translation;
    let solid = |k: usize| {
        let X = Transform::new(X_W[k].rotation, X_W[k].translation - origin);
        Solid::new(shapes[k], &X)
    };
    let found = solid(0).zip(solid(1)).and_then(|(a, b)| points(&a, &b));
    let Some(found) = found else {
        unreachable!("shapes without points in graphs are refused before");
    };
    let own = found[number as usize];
    Witness {
        points: own.points.map_each(|point| point + origin),
        ..own
    }
}

/// All points of two solids; `None` for two half-spaces.
fn points<T: Scalar>(a: &Solid<T>, b: &Solid<T>) -> Option<Vec<Witness<T>>> {
    Some(match (a, b) {
        (Solid::Round(a), Solid::Round(b)) => round::points(a, b),
        (Solid::Round(a), Solid::Box(b)) if a.is_point => vec![point_box::nearest(a, b)],
        (Solid::Round(a), Solid::Box(b)) => capsule_box::points(a, b),
        (Solid::Box(a), Solid::Box(b)) => box_box::points(a, b),
        (Solid::Round(a), Solid::HalfSpace(b)) => b.points_of_round(a),
        (Solid::Box(a), Solid::HalfSpace(b)) => b.points_of_box(a),
        (Solid::HalfSpace(_), Solid::HalfSpace(_)) => return None,
        (Solid::Box(_), Solid::Round(_)) | (Solid::HalfSpace(_), _) => {
            points(b, a)?.into_iter().map(swapped).collect()
        }
    })
}

/// The point of the second shape with the first.
fn swapped<T: Scalar>(own: Witness<T>) -> Witness<T> {
    let [first, second] = own.points;
    Witness {
        points: [second, first],
        normal: -own.normal,
        ..own
    }
}

/// A vertex, with a radius around it.
fn vertex<T: Scalar>(center: Vector3<T>, radius: T) -> Placed<T> {
    Placed {
        center,
        core: Core::Point,
        radius,
    }
}

/// A line along a direction, with a radius around it.
fn line<T: Scalar>(center: Vector3<T>, along: Vector3<T>, radius: T) -> Placed<T> {
    Placed {
        center,
        core: Core::Line(along),
        radius,
    }
}

/// A vertex or a line against a vertex.
fn nearest<T: Scalar>(placed: &[Placed<T>; 2]) -> Witness<T> {
    let is_line = |own: &Placed<T>| matches!(own.core, Core::Line(_));
    let seed = match placed.iter().any(is_line) {
        true => ASLANT,
        false => SEED,
    };
    let normal = nearest_normal(placed, &seed);
    along(placed, &normal, NormalSource::Features)
}
