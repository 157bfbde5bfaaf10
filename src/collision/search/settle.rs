//! What is left to do where features about a normal are not proved the nearest: the normal climbs to the widest gap nearby, and features are chosen there.

use nalgebra::Vector3;

use super::choose::{Found, choose};
use super::difference::Difference;

/// First step of the normal, rad: features about it have been tried as far.
const FIRST_STEP: f64 = 0.02;
/// Step below which a normal is rounding, rad.
const LAST_STEP: f64 = 1e-10;
/// Most gaps that are tried.
const MAX_TRIES: usize = 400;
/// Angles within which features about the climbed normal are tried, rad.
const ANGLES: [f64; 4] = [1e-9, 1e-6, 1e-4, 0.01];
/// Part of the size by which gap and distance of features may differ, and gaps that are as wide.
const EXACT: f64 = 1e-11;

/// The features about the normal of the widest gap near that of a pair, or the pair.
pub(super) fn settled(difference: &Difference<'_>, found: Found) -> Found {
    let exact = EXACT * difference.size;
    let lack = |found: &Found| (found.distance - found.gap).abs();
    let n = climbed(difference, found.pair.seed);
    let mut best = found;
    for angle in ANGLES {
        let Some(next) = choose(difference, &n, angle) else {
            continue;
        };
        let is_wider = next.gap > best.gap + exact && lack(&next) <= lack(&best).max(exact);
        let is_as_wide = next.gap >= best.gap - exact && lack(&next) < lack(&best) - exact;
        if is_wider || is_as_wide {
            best = next;
        }
    }
    best
}

/// A unit normal with a wider gap, by steps that shrink where none of four widens it.
fn climbed(difference: &Difference<'_>, start: Vector3<f64>) -> Vector3<f64> {
    let (mut n, mut gap, mut step) = (start, difference.gap(&start), FIRST_STEP);
    let mut tries = 0;
    while step > LAST_STEP && tries < MAX_TRIES {
        let x = n.cross(&Vector3::ith(n.iamin(), 1.0)).normalize();
        let y = n.cross(&x);
        let around = [x, -x, y, -y].map(|e| (n + e * step).normalize());
        tries += around.len();
        let wider = around.into_iter().map(|n| (difference.gap(&n), n));
        match wider.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((wider, next)) if wider > gap => (n, gap) = (next, wider),
            _ => step *= 0.5,
        }
    }
    n
}
