//! The nearest features of two convex shapes of any kind.
//!
//! Distance and depth are one problem: the unit normal n across which the gap g(n) between two planes with the shapes on either side is widest. For simple shapes
//! that overlap, n is one of few directions. Else: apart, the
//! algorithm of Gilbert, Johnson and Keerthi finds n; overlapping, a polytope that grows inside the differences of the shapes. Both end at polytopes
//! exactly, at curved shapes near enough; features about n are then tried one by one, each with its own normal by a closed form or Newton's method, and the
//! one with the widest gap is taken. That no gap exceeds the distance of its points is the proof.

mod axes;
mod choose;
mod curved;
mod difference;
mod ellipse;
mod gjk;
mod options;
mod polytope;
mod settle;
mod simplex;

use nalgebra::Vector3;

use super::clip::nearest_on_faces;
use super::feature::{Feature, FeatureId, NormalSource, PairFeature};
use super::solid::Solid;
use crate::scalar::MapEach;
use axes::{Axis, widest};
use choose::{Found, candidate, choose, choose_without_faces};
use difference::Difference;
use gjk::{Gjk, gjk};
use polytope::{Polytope, Start, tetrahedron};
use settle::settled;

/// A search for the nearest points, and the angle within which features about its normal are tried.
#[derive(Clone, Copy)]
struct Round {
    /// Tolerance of the square of the distance.
    tolerance: f64,
    /// rad
    angle: f64,
}

const fn round(tolerance: f64, angle: f64) -> Round {
    Round { tolerance, angle }
}

/// Rounds on polytopes, until the proof holds: the search ends at them exactly, or where it has no digits of the normal left.
const FLAT: [Round; 2] = [round(1e-15, PARALLEL), round(1e-15, 1e-7)];
/// Rounds on curved shapes: the angle is the root of the tolerance.
const CURVED: [Round; 4] = [
    round(1e-6, 1e-3),
    round(1e-9, 3.2e-5),
    round(1e-12, 1e-6),
    round(1e-15, 3.2e-8),
];
/// Angle within which features count as parallel on polytopes, rad.
const PARALLEL: f64 = 1e-9;
/// Angle within which features of polytopes are all near, rad.
const ALL: f64 = 2.0;
/// Part of the size by which gap and distance may differ.
const PROOF: f64 = 1e-13;
/// Part of the size to which a polytope grows towards curved shapes before features are tried.
const GROWN: f64 = 1e-4;
/// Part of the size by which planes differ that are equal up to rounding.
const SLACK: f64 = 1e-12;
/// Part of the size by which the nearest face of a growing polytope comes nearer only where rounding turned it.
const TURNED: f64 = 1e-6;
/// Angle by which the normal of a face of the polytope may be wrong, rad.
const LOOSE: f64 = 0.05;
/// Cosine of the angle between normals that are tried once.
const SAME: f64 = 1.0 - 1e-4;
/// Part of the size by which a point may lie beyond a face.
const BEYOND: f64 = 1e-9;
/// Most faces that are tried.
const MAX_TRIED: usize = 16;

/// The nearest features of two shapes, neither of them a half-space; `None` where these are farther apart than a margin.
pub(super) fn search(a: &Solid<'_>, b: &Solid<'_>, margin: f64) -> Option<PairFeature> {
    let difference = Difference::new(*a, *b);
    let far = margin + a.radius() + b.radius();
    if let Some(axis) = widest(&difference, far) {
        if axis.gap > far {
            return None;
        }
        let found = at_axis(&difference, &axis);
        if found.is_some() {
            return found;
        }
    }
    let pair = from_simplex(&difference, far)?;
    let Some(flat) = nearest_on_faces(a, b, &pair) else {
        return Some(pair);
    };
    if flat.outside > BEYOND * difference.size
        && let Some(beside) = choose_without_faces(&difference, &pair.seed, PARALLEL)
        && beside.gap >= flat.distance - PROOF * difference.size
        && is_proved(&difference, &beside)
    {
        return Some(beside.pair);
    }
    Some(flat.pair)
}

/// The features about the normal of the widest gap, where they are the nearest: up to rounding, always where shapes overlap.
fn at_axis(difference: &Difference<'_>, axis: &Axis) -> Option<PairFeature> {
    let (a, b) = (&difference.a, &difference.b);
    let rounding = PROOF * difference.size;
    let [first, second] = axis.choices(difference);
    let found = candidate(difference, &axis.normal, &first, &second)?;
    let is_exact =
        found.gap >= axis.gap - rounding && (found.distance - found.gap).abs() <= rounding;
    if !is_exact {
        return None;
    }
    match nearest_on_faces(a, b, &found.pair) {
        Some(flat)
            if axis.gap < -rounding
                || (flat.outside <= rounding && flat.distance <= axis.gap + rounding) =>
        {
            Some(flat.pair)
        }
        None if axis.gap <= 0.0 || is_proved(difference, &found) => Some(found.pair),
        _ => None,
    }
}

/// The nearest features from the simplex of nearest differences.
fn from_simplex(difference: &Difference<'_>, far: f64) -> Option<PairFeature> {
    let (a, b) = (&difference.a, &difference.b);
    let rounds: &[Round] = if difference.is_curved() {
        &CURVED
    } else {
        &FLAT
    };
    let mut best: Option<Found> = None;
    let apart = b.X.translation - a.X.translation;
    // From elsewhere where simplices that are nearly flat have ended a search early.
    let others = [Vector3::x(), Vector3::y(), Vector3::z()];
    let mut last = apart;
    for start in [apart].into_iter().chain(others) {
        let mut start = start;
        for &Round { tolerance, angle } in rounds {
            match gjk(difference, &start, tolerance, far) {
                Gjk::Far => return None,
                Gjk::Overlap(simplex) => return Some(overlapping(difference, simplex.points())),
                Gjk::Apart(v) => {
                    best = wider(difference, best, choose(difference, &v.normalize(), angle));
                    (start, last) = (v, v);
                }
            }
            if let Some(found) = &best
                && is_proved(difference, found)
            {
                return Some(found.pair);
            }
        }
    }
    // Slivers on which simplices have no digits: every feature that looks the right way.
    if let Some(n) = last.try_normalize(f64::MIN_POSITIVE) {
        best = wider(difference, best, choose(difference, &n, ALL));
    }
    Some(pair_of(difference, best, &last))
}

/// Whether no other features can be nearer: the gap is the distance, and a face reaches as far as it must.
fn is_proved(difference: &Difference<'_>, found: &Found) -> bool {
    let reaches = match found.pair.id.normal {
        NormalSource::Features => true,
        NormalSource::First(_) | NormalSource::Second(_) => reaches(difference, found),
    };
    reaches && found.lack() <= PROOF * difference.size
}

/// Whether a face lies opposite to what is nearest to its plane.
fn reaches(difference: &Difference<'_>, found: &Found) -> bool {
    let (a, b) = (&difference.a, &difference.b);
    let flat = nearest_on_faces(a, b, &found.pair);
    flat.is_some_and(|flat| flat.outside <= BEYOND * difference.size)
}

fn wider(difference: &Difference<'_>, best: Option<Found>, other: Option<Found>) -> Option<Found> {
    match (best, other) {
        (Some(best), Some(other)) if !other.is_better(&best, difference.size) => Some(best),
        (best, other) => other.or(best),
    }
}

/// The features of the least depth.
fn overlapping(difference: &Difference<'_>, points: &[Vector3<f64>]) -> PairFeature {
    let start = match tetrahedron(difference, points) {
        Start::Tetrahedron(start) => start,
        Start::Flat(normal) => {
            let either = [normal, -normal].map_each(|n| choose(difference, &n, PARALLEL));
            let best = wider(difference, either[0], either[1]);
            return pair_of(difference, best, &normal);
        }
    };
    let mut polytope = Polytope::new(&start, difference.size);
    let grown = grow(difference, &mut polytope);
    let normal = -grown.normal;
    let mut best = of_near_faces(difference, &mut polytope, grown.depth);
    if !grown.is_whole {
        for angle in [PARALLEL, LOOSE] {
            best = wider(difference, best, choose(difference, &normal, angle));
        }
    }
    pair_of(difference, best, &normal)
}

/// The features found, or others near them unless they are proved the nearest; without any, those along a direction.
fn pair_of(difference: &Difference<'_>, found: Option<Found>, n: &Vector3<f64>) -> PairFeature {
    match found {
        Some(found) if is_proved(difference, &found) => found.pair,
        Some(found) => settled(difference, found).pair,
        None => at_direction(difference, n),
    }
}

/// End of the growth of a polytope.
struct Grown {
    /// Least distance of a supporting plane from the origin, which the depth does not exceed.
    depth: f64,
    /// Outward unit normal of that plane.
    normal: Vector3<f64>,
    /// Whether all faces are those of a convex polytope: where points all but coincide, rounding turns some inside out.
    is_whole: bool,
}

/// Grows a polytope until its nearest face touches the rim of the differences, or nearly does where that is curved.
fn grow(difference: &Difference<'_>, polytope: &mut Polytope) -> Grown {
    let mut own = Grown {
        depth: f64::INFINITY,
        normal: polytope.faces()[polytope.nearest()].normal,
        is_whole: true,
    };
    let mut least = f64::NEG_INFINITY;
    let grown = if difference.is_curved() { GROWN } else { SLACK };
    while polytope.has_room() {
        let nearest = polytope.nearest();
        let face = polytope.faces()[nearest];
        if least > 0.0 && face.distance < least - TURNED * difference.size {
            own.is_whole = false;
            break;
        }
        least = face.distance;
        let point = difference.support(&face.normal);
        let reach = point.dot(&face.normal);
        if reach < own.depth {
            (own.depth, own.normal) = (reach, face.normal);
        }
        let is_reached = own.depth - face.distance <= grown * difference.size;
        if is_reached || !polytope.add_vertex(point, nearest) {
            break;
        }
    }
    own
}

/// The best features about the faces that may be the nearest, these first.
fn of_near_faces(
    difference: &Difference<'_>,
    polytope: &mut Polytope,
    depth: f64,
) -> Option<Found> {
    let faces = polytope.sorted();
    let depth = depth + SLACK * difference.size;
    let mut tried = [Vector3::zeros(); MAX_TRIED];
    let mut n_tried = 0;
    let mut best = None;
    for face in faces.iter().take_while(|face| face.distance <= depth) {
        let is_new = tried[..n_tried].iter().all(|n| n.dot(&face.normal) < SAME);
        if is_new && n_tried < MAX_TRIED {
            tried[n_tried] = face.normal;
            n_tried += 1;
            for angle in [PARALLEL, LOOSE] {
                best = wider(difference, best, choose(difference, &-face.normal, angle));
                if best.is_some_and(|best| best.gap >= -face.distance - PROOF * difference.size) {
                    return best;
                }
            }
        }
    }
    best
}

/// The features farthest along a direction, where no pair is stationary.
fn at_direction(difference: &Difference<'_>, n: &Vector3<f64>) -> PairFeature {
    let n = n
        .try_normalize(f64::MIN_POSITIVE)
        .unwrap_or_else(Vector3::z);
    let features: [Feature; 2] = [
        difference.a.extreme_feature(&n),
        difference.b.extreme_feature(&-n),
    ];
    PairFeature {
        id: FeatureId {
            features,
            normal: NormalSource::Features,
        },
        seed: n,
    }
}
