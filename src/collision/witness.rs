//! Distance, points and normal of a pair of features, over the scalar.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::feature::{NormalSource, PairFeature, Witness};
use super::field_pairs::field_witness;
use super::guard::{normalized_or, reciprocal_or_zero, rejected};
use super::newton::refined_normal;
use super::placed::{Core, Placed, face_normal};
use super::shape::Shape;
use crate::scalar::{MapEach, Over, Scalar};
use crate::spatial::Transform;
use crate::spatial::linear::{cross, dot, scale, scale_add_data};

/// Computes distance, points and normal of a pair of features.
///
/// Exact in poses and sizes: closed forms for points, lines and planes with radii; Newton steps over the scalar from the seed for rims of cylinders
/// and ellipsoids, with derivatives of first and second order. d = n · (p₂ − p₁). Constant time, no allocation.
///
/// * `X_WA`, `X_WB` – poses of the shapes in the world
///
/// If features coincide, the normal is the constant seed: the derivative is one-sided, for motion along it. Never NaN.
///
/// # Panics
/// If a feature refers to a vertex that the shape does not have.
pub fn witness<P: Scalar, T: Over<P>>(
    pair: &PairFeature,
    a: &Shape<P>,
    X_WA: &Transform<T>,
    b: &Shape<P>,
    X_WB: &Transform<T>,
) -> Witness<T> {
    if let Some(found) = field_witness(pair, [a, b], [X_WA, X_WB]) {
        return found;
    }
    // About A's origin: far from the world's no digit is lost.
    let origin = X_WA.translation;
    let zero = Vector3::from_element(T::zero());
    let X_A = Transform::new(X_WA.rotation, zero);
    let X_B = Transform::new(X_WB.rotation, X_WB.translation - origin);
    let placed = [
        Placed::new(pair.id.features[0], a, &X_A),
        Placed::new(pair.id.features[1], b, &X_B),
    ];
    let normal = match pair.id.normal {
        NormalSource::Features => nearest_normal(&placed, &pair.seed),
        NormalSource::First(face) => face_normal(face, a, &X_A),
        NormalSource::Second(face) => -face_normal(face, b, &X_B),
    };
    let found = along(&placed, &normal, pair.id.normal);
    Witness {
        points: found.points.map_each(|point| point + origin),
        ..found
    }
}

/// Distance and points of two features along a unit normal.
pub(super) fn along<T: Scalar>(
    placed: &[Placed<T>; 2],
    normal: &Vector3<T>,
    source: NormalSource,
) -> Witness<T> {
    let [p, q] = core_points(placed, normal, source);
    let [r, s] = [placed[0].radius, placed[1].radius];
    Witness {
        distance: dot(normal, &(q - p)) - r - s,
        points: [
            scale_add_data::<T, T>(normal, r, &p),
            scale_add_data::<T, T>(normal, -s, &q),
        ],
        normal: *normal,
    }
}

/// The direction in which two features are nearest.
pub(super) fn nearest_normal<T: Scalar>(
    [a, b]: &[Placed<T>; 2],
    seed: &Vector3<f64>,
) -> Vector3<T> {
    let fallback = seed.map(T::constant);
    let apart = b.center - a.center;
    let size = dot(&apart, &apart);
    match (&a.core, &b.core) {
        (Core::Point, Core::Point) => normalized_or(&apart, T::zero(), &fallback),
        (Core::Line(u), Core::Point) | (Core::Point, Core::Line(u)) => {
            // Across the line as it turns, so that no place along it is another one.
            let across = normalized_or(&rejected(&fallback, u), T::zero(), &fallback);
            normalized_or(&rejected(&apart, u), size, &across)
        }
        (Core::Line(u), Core::Line(v)) => normalized_or(&cross(u, v), T::zero(), &fallback),
        _ => refined_normal(a, b, seed),
    }
}

/// The points of two cores that are nearest along a normal.
fn core_points<T: Scalar>(
    [a, b]: &[Placed<T>; 2],
    n: &Vector3<T>,
    source: NormalSource,
) -> [Vector3<T>; 2] {
    if let (Core::Line(u), Core::Line(v)) = (&a.core, &b.core) {
        return crossing([&a.center, &b.center], [u, v], n);
    }
    let (mut p, mut q) = (a.support(n), b.support(&-n));
    if source == NormalSource::Features {
        // From elsewhere on a line, rounding of the normal between points that all but coincide would count.
        p += part_along(a, &(q - p));
        q += part_along(b, &(p - q));
    }
    let step = scale(n, dot(n, &(q - p)));
    let is_first_known = match source {
        NormalSource::First(_) => false,
        NormalSource::Second(_) => true,
        NormalSource::Features => spread(a) <= spread(b),
    };
    if is_first_known {
        [p, p + step]
    } else {
        [q - step, q]
    }
}

/// The part of a vector along a line; zero for other cores.
fn part_along<T: Scalar>(own: &Placed<T>, v: &Vector3<T>) -> Vector3<T> {
    match &own.core {
        Core::Line(u) => v - rejected(v, u),
        _ => Vector3::from_element(T::zero()),
    }
}

/// How far the supporting point of a core moves with the normal, in an order: that of a flat ellipsoid is not known where its normal is, that of a line not at all.
fn spread<T>(own: &Placed<T>) -> u8 {
    match own.core {
        Core::Point => 0,
        Core::Disc(..) => 1,
        Core::Ellipsoid(_) => 2,
        Core::Line(_) => 3,
    }
}

/// The points of two lines that lie on one another as seen along n: p + s u and q + t v with (q + t v − p − s u) × n = 0.
fn crossing<T: Scalar>(
    [p, q]: [&Vector3<T>; 2],
    [u, v]: [&Vector3<T>; 2],
    n: &Vector3<T>,
) -> [Vector3<T>; 2] {
    let apart = q - p;
    let across = reciprocal_or_zero(dot(n, &cross(u, v)));
    let s = dot(&cross(&apart, v), n) * across;
    let t = dot(&cross(&apart, u), n) * across;
    [
        scale_add_data::<T, T>(u, s, p),
        scale_add_data::<T, T>(v, t, q),
    ]
}
