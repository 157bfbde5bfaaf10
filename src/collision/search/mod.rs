//! The nearest features of two convex shapes of any kind.
//!
//! Distance and depth are one problem: the unit normal n across which the gap g(n) between two planes with the shapes on either side is widest. Apart, the
//! algorithm of Gilbert, Johnson and Keerthi finds n; overlapping, a polytope that grows inside the differences of the shapes. Both end at polytopes
//! exactly, at curved shapes near enough; features about n are then tried one by one, each with its own normal by a closed form or Newton's method, and the
//! one with the widest gap is taken. That no gap exceeds the distance of its points is the proof.

mod choose;
mod difference;
mod gjk;
mod options;
mod polytope;
mod simplex;

use nalgebra::Vector3;

use super::feature::{Face, Feature, FeatureId, NormalSource, PairFeature};
use super::patch::{Across, Patch};
use super::placed::Placed;
use super::shape::Shape;
use super::solid::Solid;
use choose::{Found, choose};
use difference::Difference;
use gjk::{Gjk, gjk};
use polytope::{Polytope, Start, tetrahedron};

/// Tolerance of the search on polytopes, of the square of the distance: it ends at them exactly.
const EXACT: f64 = 1e-15;
/// Tolerances on curved shapes, one after the other until the proof holds.
const CURVED: [f64; 4] = [1e-6, 1e-9, 1e-12, 1e-15];
/// Angle within which features count as parallel on polytopes, rad.
const PARALLEL: f64 = 1e-9;
/// Part of the size by which gap and distance may differ.
const PROOF: f64 = 1e-13;
/// Part of the size to which a polytope grows towards curved shapes before features are tried.
const GROWN: f64 = 1e-4;
/// Part of the size by which planes differ that are equal but for rounding.
const SLACK: f64 = 1e-12;
/// Angle by which the normal of a face of the polytope may be wrong, rad.
const LOOSE: f64 = 0.05;
/// Cosine of the angle between normals that are tried once.
const SAME: f64 = 1.0 - 1e-4;
/// Part of the size by which a point may lie beyond a face.
const BEYOND: f64 = 1e-9;
/// Most faces that are tried.
const MAX_TRIED: usize = 16;

/// The nearest features of two shapes, neither of them a half-space.
pub(super) fn search(a: &Solid<'_>, b: &Solid<'_>) -> PairFeature {
    let difference = Difference::new(*a, *b);
    let is_curved = |solid: &Solid<'_>| {
        matches!(
            solid.shape,
            Shape::Cylinder { .. } | Shape::Ellipsoid { .. }
        )
    };
    let tolerances: &[f64] = if is_curved(a) || is_curved(b) {
        &CURVED
    } else {
        &[EXACT]
    };
    let mut best: Option<Found> = None;
    let mut start = b.X.translation - a.X.translation;
    for &tolerance in tolerances {
        match gjk(&difference, &start, tolerance) {
            Gjk::Overlap(simplex) => return overlapping(&difference, simplex.points()),
            Gjk::Apart(v) => {
                let n = v.normalize();
                let angle = if tolerances.len() > 1 {
                    tolerance.sqrt().max(PARALLEL)
                } else {
                    PARALLEL
                };
                best = wider(best, choose(&difference, &n, angle));
                start = v;
            }
        }
        if best.is_some_and(|found| is_proved(&difference, &found)) {
            break;
        }
    }
    best.map_or_else(|| at_direction(&difference, &start), |found| found.pair)
}

/// Whether no other features can be nearer: the gap is the distance, and a face reaches as far as it must.
fn is_proved(difference: &Difference<'_>, found: &Found) -> bool {
    let (a, b) = (&difference.a, &difference.b);
    let n = &found.pair.seed;
    let [first, second] = found.pair.id.features;
    let reaches = match found.pair.id.normal {
        NormalSource::Features => true,
        NormalSource::First(face) => reaches(difference, a, face, n, b, second),
        NormalSource::Second(face) => reaches(difference, b, face, &-n, a, first),
    };
    reaches && found.distance - found.gap <= PROOF * difference.size
}

/// Whether a face lies opposite to the one point of another shape that is nearest to its plane; taken for granted where there are several.
fn reaches(
    difference: &Difference<'_>,
    own: &Solid<'_>,
    face: Face,
    n: &Vector3<f64>,
    other: &Solid<'_>,
    feature: Feature,
) -> bool {
    let across = Across::new(n);
    if Patch::new(other, &-n, PARALLEL, &across).corners().len() > 1 {
        return true;
    }
    let point = Placed::new(feature, other.shape, &other.X).support(&-n);
    let beyond = match (face, own.shape) {
        (Face::Cap(end), Shape::Cylinder { radius, .. }) => {
            let apart = point - own.vertex(end);
            (apart - n * n.dot(&apart)).norm() - radius
        }
        (Face::Vertices(_), _) => {
            Patch::new(own, n, PARALLEL, &across).outside(&across.place(&point))
        }
        _ => 0.0,
    };
    beyond <= BEYOND * difference.size
}

fn wider(best: Option<Found>, other: Option<Found>) -> Option<Found> {
    match (best, other) {
        (Some(best), Some(other)) if other.gap <= best.gap => Some(best),
        (best, other) => other.or(best),
    }
}

/// The features of the least depth.
fn overlapping(difference: &Difference<'_>, points: &[Vector3<f64>]) -> PairFeature {
    let start = match tetrahedron(difference, points) {
        Start::Tetrahedron(start) => start,
        Start::Flat(normal) => {
            let either = [normal, -normal].map(|n| choose(difference, &n, PARALLEL));
            let best = wider(either[0], either[1]);
            return best.map_or_else(|| at_direction(difference, &normal), |found| found.pair);
        }
    };
    let mut polytope = Polytope::new(&start, difference.size);
    let depth = grow(difference, &mut polytope);
    let best = of_near_faces(difference, &mut polytope, depth);
    let normal = -polytope.faces()[0].normal;
    best.map_or_else(|| at_direction(difference, &normal), |found| found.pair)
}

/// Grows a polytope until its nearest face touches the rim of the differences, or nearly does where that is curved. Returns the least distance of a
/// supporting plane from the origin, which the depth does not exceed.
fn grow(difference: &Difference<'_>, polytope: &mut Polytope) -> f64 {
    let mut depth = f64::INFINITY;
    while polytope.has_room() {
        let nearest = polytope.nearest();
        let face = polytope.faces()[nearest];
        let point = difference.support(&face.normal);
        let reach = point.dot(&face.normal);
        depth = depth.min(reach);
        let is_reached = depth - face.distance <= GROWN * difference.size;
        if is_reached || !polytope.add_vertex(point, nearest) {
            break;
        }
    }
    depth
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
                best = wider(best, choose(difference, &-face.normal, angle));
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
