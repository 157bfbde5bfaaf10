//! What is left to do where features about a normal are not proved the nearest: the normal climbs to the widest gap nearby, and features are chosen there.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::choose::{Found, choose};
use super::difference::Difference;
use crate::collision::guard::plane_across;

/// First step of the normal, rad: features about it have been tried as far.
const FIRST_STEP: f64 = 0.02;
/// Step below which a normal is rounding, rad.
const LAST_STEP: f64 = 1e-10;
/// Most gaps that are tried.
const MAX_TRIES: usize = 1000;
/// Slopes of the gap about a normal, and with those at the ends of steps that failed.
const AROUND: usize = 8;
const MAX_SLOPES: usize = 12;
/// Angles within which features about the climbed normal are tried, rad; the last is that of all features of simple shapes, for a ball about one of their edges or vertices.
const ANGLES: [f64; 5] = [1e-9, 1e-6, 1e-4, 0.01, 2.0];
/// Part of the size by which gap and distance of features may differ, and gaps that are as wide.
const EXACT: f64 = 1e-11;

/// The features about the normal of the widest gap near that of a pair, or the pair.
pub(super) fn settled(difference: &Difference<'_>, found: Found) -> Found {
    let exact = EXACT * difference.size;
    let n = climbed(difference, found.pair.seed);
    let mut best = found;
    for angle in ANGLES {
        let Some(next) = choose(difference, &n, angle) else {
            continue;
        };
        let is_wider = next.gap > best.gap + exact && next.lack() <= best.lack().max(exact);
        let is_as_wide = next.gap >= best.gap - exact && next.lack() < best.lack() - exact;
        if is_wider || is_as_wide {
            best = next;
        }
    }
    best
}

/// A unit normal with a wider gap: up the derivative of the gap, or where this jumps along the ridge between its sides, by steps that shrink.
fn climbed(difference: &Difference<'_>, start: Vector3<f64>) -> Vector3<f64> {
    let (mut n, mut gap, mut step) = (start, difference.gap(&start), FIRST_STEP);
    let mut tries = 0;
    while step > LAST_STEP && tries < MAX_TRIES {
        tries += MAX_SLOPES;
        let next = uphill(difference, &n, gap, step);
        match next {
            Some(next) => (n, gap, step) = (next, difference.gap(&next), 2.0 * step),
            None => step *= 0.25,
        }
    }
    n
}

/// A normal with a wider gap, a step away towards the shortest mixture of the slopes about the normal; a step that does not widen the gap adds the slope at its end.
fn uphill(
    difference: &Difference<'_>,
    n: &Vector3<f64>,
    gap: f64,
    step: f64,
) -> Option<Vector3<f64>> {
    let [x, y] = plane_across(n);
    let mut slopes = [Vector3::zeros(); MAX_SLOPES];
    for (k, own) in slopes[..AROUND].iter_mut().enumerate() {
        let (sin, cos) = (TAU * k as f64 / AROUND as f64).sin_cos();
        *own = slope(difference, &(n + (x * cos + y * sin) * step).normalize());
    }
    for len in AROUND..MAX_SLOPES {
        let up = shortest(&slopes[..len]).try_normalize(f64::MIN_POSITIVE)?;
        let next = (n + up * step).normalize();
        if difference.gap(&next) > gap {
            return Some(next);
        }
        slopes[len] = slope(difference, &next);
    }
    None
}

/// The derivative of the gap in its unit normal, across it.
fn slope(difference: &Difference<'_>, n: &Vector3<f64>) -> Vector3<f64> {
    let w = difference.support(&-n);
    w - n * n.dot(&w)
}

/// The shortest mixture of two of some vectors.
fn shortest(vectors: &[Vector3<f64>]) -> Vector3<f64> {
    let mut best = vectors[0];
    for (k, a) in vectors.iter().enumerate() {
        for b in &vectors[..k] {
            let u = a - b;
            let part = (a.dot(&u) / u.norm_squared()).clamp(0.0, 1.0);
            let mixed = a - u * part;
            if mixed.norm_squared() < best.norm_squared() {
                best = mixed;
            }
        }
    }
    best
}
