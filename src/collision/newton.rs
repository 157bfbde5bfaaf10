//! The normal between curved features, by Newton's method over the scalar.
//!
//! The distance of convex shapes A and B is the largest gap between two parallel planes with the shapes on either side,
//!
//! > d = max over unit n of g(n),  g(n) = −h_A(n) − h_B(−n),
//!
//! with their support functions h; where they overlap, it is the least depth, negative. With the supporting points p(n) of A and q(n) of B and w = q − p, g = n · w, and
//! n is stationary where w has no part across n. Its derivative across n is `−(∇²h_A + ∇²h_B + g 1)`. A line keeps n across itself.

use nalgebra::Vector3;

use super::guard::{ROUNDING, normalized_or, reciprocal_above, rejected};
use super::placed::{Core, Placed};
use crate::scalar::{MapEach, Scalar};
use crate::spatial::linear::{cross, dot, scale};

/// Steps over the scalar from the solution: two make derivatives exact to third order.
pub(super) const STEPS: usize = 2;
/// Steps of what is recorded, whose solution moves away from the seed.
const RECORDED_STEPS: usize = 8;

/// Part of the distance of the points that the stiffness must be for the normal to have derivatives: below, rounding of the normal times its derivatives would count in those of the distance, which need none.
pub(super) const LEAST_STIFFNESS: f64 = 1e-9;

/// Part that curvatures and reaches have in that distance, of which the stiffness is a difference.
const CURVED: f64 = 1e-5;

/// Narrowing of a gap that is not rounding, in the square of the distance of its points, 1/m, and in m.
const LOSS: f64 = 1e-12;
const SMALLEST_LOSS: f64 = 1e-12;
/// Cosine of the angle from the seed beyond which a step led elsewhere.
const NEAR: f64 = 0.9;

/// The normal between two features of which one is curved, from a seed near it.
pub(super) fn refined_normal<T: Scalar>(
    a: &Placed<T>,
    b: &Placed<T>,
    seed: &Vector3<f64>,
) -> Vector3<T> {
    let mut n = seed.map(T::constant);
    if let Some(u) = line(a, b) {
        n = normalized_or(&rejected(&n, u), T::zero(), &n);
    }
    let start = n;
    let (steps, least) = if T::HAS_VALUES {
        (STEPS, LEAST_STIFFNESS)
    } else {
        (RECORDED_STEPS, ROUNDING)
    };
    for _ in 0..steps {
        let step = newton_step(a, b, &n, seed, least);
        n = normalized_or(&(n + step), T::zero(), &n);
    }
    if T::HAS_VALUES {
        wider(a, b, &start, &n)
    } else {
        n
    }
}

/// The second of two normals; the first where its gap is wider or they are far apart, as at the edge of a cap, where the curvature of a rim has no bound and a step leads anywhere.
fn wider<T: Scalar>(
    a: &Placed<T>,
    b: &Placed<T>,
    first: &Vector3<T>,
    second: &Vector3<T>,
) -> Vector3<T> {
    let [w, v] = [first, second].map_each(|n| b.support(&-n) - a.support(n));
    let least = dot(first, &w) - dot(&w, &w) * LOSS - SMALLEST_LOSS;
    let (gap, near) = (dot(second, &v), T::constant(NEAR));
    let alike = dot(first, second);
    Vector3::from_fn(|k, _| {
        let found = gap.select_lt(least, first[k], second[k]);
        alike.select_lt(near, first[k], found)
    })
}

/// The direction of a line among the features.
fn line<'a, T>(a: &'a Placed<T>, b: &'a Placed<T>) -> Option<&'a Vector3<T>> {
    match (&a.core, &b.core) {
        (Core::Line(u), _) | (_, Core::Line(u)) => Some(u),
        _ => None,
    }
}

/// Change of the normal n, across it, by a step of Newton's method; zero where the stiffness is too small: there normals of a whole arc are as good.
///
/// * `seed` – near n; chooses the axes across it
/// * `least` – part of the distance of the points that the stiffness must be
pub(super) fn newton_step<T: Scalar>(
    a: &Placed<T>,
    b: &Placed<T>,
    n: &Vector3<T>,
    seed: &Vector3<f64>,
    least: f64,
) -> Vector3<T> {
    let w = b.support(&-n) - a.support(n);
    let g = dot(n, &w);
    let curvature = |e: &Vector3<T>| a.curvature(n, e) + b.curvature(n, e) + scale(e, g);
    if let Some(u) = line(a, b) {
        let e = normalized_or(&cross(u, n), T::zero(), n);
        let stiffness = dot(&e, &curvature(&e));
        let reach = dot(n, &(b.center - a.center)).abs();
        let inverse = reciprocal_above(stiffness, (g.abs() + reach * CURVED) * least);
        return scale(&e, dot(&e, &w) * inverse);
    }
    step_across(n, seed, &w, curvature, least)
}

/// Change of a normal n, across it, by a step of Newton's method; see [`newton_step`].
///
/// * `w` – from the supporting point of the first shape to that of the second
/// * `curvature` – `(∇²h_A + ∇²h_B + g 1) e` for a direction e across n
pub(super) fn step_across<T: Scalar>(
    n: &Vector3<T>,
    seed: &Vector3<f64>,
    w: &Vector3<T>,
    curvature: impl Fn(&Vector3<T>) -> Vector3<T>,
    least: f64,
) -> Vector3<T> {
    let g = dot(n, w);
    let helper = Vector3::ith(seed.iamin(), T::one());
    let x = normalized_or(&cross(n, &helper), T::zero(), &helper);
    let y = cross(n, &x);
    let (kx, ky) = (curvature(&x), curvature(&y));
    let (xx, xy, yy) = (dot(&x, &kx), dot(&x, &ky), dot(&y, &ky));
    let (fx, fy) = (dot(&x, w), dot(&y, w));
    let terms = xx.abs() + yy.abs();
    let rounding = terms * (g.abs() + terms * CURVED) * least;
    let inverse = reciprocal_above(xx * yy - xy * xy, rounding);
    scale(&x, (yy * fx - xy * fy) * inverse) + scale(&y, (xx * fy - xy * fx) * inverse)
}
