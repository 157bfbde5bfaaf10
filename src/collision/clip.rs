//! The points at which flat parts of two shapes lie on one another.

use nalgebra::{Vector2, Vector3};

use super::corner::{Across, Corner, Ends, edge, placed_edge};
use super::ends::each_end;
use super::feature::{Face, FeatureId, MAX_POINTS, Manifold, NormalSource, PairFeature, Witness};
use super::field_pairs::{each_pair, is_field};
use super::patch::{MAX_CORNERS, Patch};
use super::placed::{Placed, face_normal};
use super::solid::Solid;
use super::witness::{along, witness};

/// Angle within which flat parts count as parallel where one nearest pair is looked for, rad.
const PARALLEL: f64 = 1e-9;
/// Angle within which they may touch at several points, rad: some three degrees.
pub(super) const TOUCHING: f64 = 0.05;
/// Part of the size by which a corner may be outside of a polygon.
pub(super) const SLACK: f64 = 1e-12;
/// Part of the size within which points are one: corners that coincide are found more than once or not by rounding, and each point is a spring of its own.
pub(super) const SAME: f64 = 1e-6;
/// Sine of the angle between sides that lie along one another: their ends say as much as a crossing would.
pub(super) const ALONG: f64 = 1e-4;
/// Most pairs among which those of a manifold are chosen: corners of both, crossings of convex polygons.
const MAX_PAIRS: usize = 4 * MAX_CORNERS;

/// A pair with its distance and its place across the normal.
#[derive(Clone, Copy, Debug)]
struct Point {
    pair: PairFeature,
    distance: f64,
    at: Vector2<f64>,
    /// Distance of a corner from the polygon on which it should lie: that of round faces has corners only here and there.
    outside: f64,
}

/// The nearest pair of two flat parts.
pub(super) struct OnFaces {
    pub(super) pair: PairFeature,
    pub(super) distance: f64,
    /// Distance by which one part is outside of the other there, m; not positive where they overlap.
    pub(super) outside: f64,
}

/// The pair of two flat parts that is nearest where they lie on one another, for a pair whose normal is that of a face.
pub(super) fn nearest_on_faces(
    a: &Solid<'_>,
    b: &Solid<'_>,
    pair: &PairFeature,
) -> Option<OnFaces> {
    let mut best: Option<Point> = None;
    let slack = SLACK * (a.reach() + b.reach());
    each_point(a, b, pair, PARALLEL, f64::INFINITY, &mut |point| {
        let is_better = |best: &Point| {
            let lack = |point: &Point| point.outside.max(slack);
            let [own, other] = [lack(&point), lack(best)];
            own < other || (own == other && point.distance < best.distance)
        };
        if best.as_ref().is_none_or(is_better) {
            best = Some(point);
        }
    });
    best.map(|best| OnFaces {
        pair: best.pair,
        distance: best.distance,
        outside: best.outside,
    })
}

/// The pairs about the nearest one that are not farther apart than a margin: at most eight, those which span the most.
pub(super) fn manifold(
    a: &Solid<'_>,
    b: &Solid<'_>,
    pair: PairFeature,
    margin: f64,
    out: &mut Manifold,
) {
    let nearest = point(a, b, pair, &Across::new(&pair.seed));
    if nearest.distance > margin {
        return;
    }
    let size = a.reach() + b.reach();
    let slack = SLACK * size;
    let mut found = [nearest; MAX_PAIRS];
    let mut len = 1;
    let mut add = |point: Point| {
        let is_new = found[..len]
            .iter()
            .all(|known| known.pair.id != point.pair.id);
        if point.distance <= margin && len < MAX_PAIRS && is_new {
            found[len] = point;
            len += 1;
        }
    };
    if pair.id.normal == NormalSource::Features && !is_field(a.shape, b.shape) {
        let across = Across::new(&pair.seed);
        each_end(a, b, &pair, slack, &mut |end| {
            add(point(a, b, end, &across));
        });
    } else {
        each_point(a, b, &pair, TOUCHING, slack, &mut add);
    }
    span(&mut found[..len], SAME * size, out);
}

/// Adds the first point, and one after the other those farthest from all that are there, as long as they are so far apart.
fn span(found: &mut [Point], apart: f64, out: &mut Manifold) {
    out.push(found[0].pair);
    let mut far = [f64::INFINITY; MAX_PAIRS];
    let mut last = found[0].at;
    for _ in 1..MAX_POINTS.min(found.len()) {
        let mut next = (0, 0.0);
        for (k, point) in found.iter().enumerate() {
            far[k] = far[k].min((point.at - last).norm());
            if far[k] > next.1 {
                next = (k, far[k]);
            }
        }
        if next.1 <= apart {
            break;
        }
        last = found[next.0].at;
        out.push(found[next.0].pair);
    }
}

/// Hands on the pairs of corners and crossing sides of the flat parts about a nearest pair.
fn each_point(
    a: &Solid<'_>,
    b: &Solid<'_>,
    pair: &PairFeature,
    angle: f64,
    slack: f64,
    each: &mut dyn FnMut(Point),
) {
    let n = &pair.seed;
    let across = Across::new(n);
    if is_field(a.shape, b.shape) {
        each_pair(a, b, &mut |pair, _| each(point(a, b, pair, &across)));
        return;
    }
    let [tight_a, tight_b] = match pair.id.normal {
        NormalSource::First(_) => [PARALLEL, angle],
        NormalSource::Second(_) => [angle, PARALLEL],
        NormalSource::Features => return,
    };
    let first = Patch::new(a, n, tight_a, &across);
    let second = Patch::new(b, &-n, tight_b, &across);
    // A face of both shapes, on which their corners lie.
    let [face_a, face_b] = match pair.id.normal {
        NormalSource::First(face) => [Some(face), second.face],
        NormalSource::Second(face) => [first.face, Some(face)],
        NormalSource::Features => [None; 2],
    };
    // Their normals are the same for all points.
    let normal_a = face_a.map(|face| face_normal(face, a.shape, &a.X));
    let normal_b = face_b.map(|face| -face_normal(face, b.shape, &b.X));
    let mut offer = |id: FeatureId, placed: &[Placed<f64>; 2], outside: f64| {
        let normal = match id.normal {
            NormalSource::First(_) => normal_a,
            _ => normal_b,
        };
        if let Some(normal) = normal {
            let found = along(placed, &normal, id.normal);
            let pair = PairFeature { id, seed: *n };
            each(Point::new(pair, &found, &across, outside));
        }
    };
    if let Some(face) = face_a {
        let (vertex, normal) = (face.vertex(), NormalSource::First(face));
        let on_face = Placed::new(vertex, a.shape, &a.X);
        each_corner(&second, &first, &face, slack, |corner, outside| {
            let features = [vertex, corner.feature];
            let placed = [on_face, corner.placed(b)];
            offer(FeatureId { features, normal }, &placed, outside);
        });
    }
    if let Some(face) = face_b {
        let (vertex, normal) = (face.vertex(), NormalSource::Second(face));
        let on_face = Placed::new(vertex, b.shape, &b.X);
        each_corner(&first, &second, &face, slack, |corner, outside| {
            let features = [corner.feature, vertex];
            let placed = [corner.placed(a), on_face];
            offer(FeatureId { features, normal }, &placed, outside);
        });
    }
    for side in first.sides() {
        for other in second.sides().filter(|other| cross(side, *other)) {
            let id = FeatureId {
                features: [edge(side), edge(other)],
                normal: pair.id.normal,
            };
            offer(id, &[placed_edge(side, a), placed_edge(other, b)], 0.0);
        }
    }
}

/// Hands on the corners of a patch, each with its distance from the face on which it should lie, unless it is more than a slack.
fn each_corner(
    own: &Patch,
    other: &Patch,
    face: &Face,
    slack: f64,
    mut each: impl FnMut(&Corner, f64),
) {
    for corner in own.corners() {
        let is_endless = matches!(face, Face::Plane);
        let outside = if is_endless {
            0.0
        } else {
            other.outside(&corner.at)
        };
        if outside <= slack {
            each(corner, outside);
        }
    }
}

/// Whether two segments cross between their ends, at an angle: where sides lie along one another rounding would decide.
fn cross([a, b]: Ends<'_>, [c, d]: Ends<'_>) -> bool {
    let (a, b, c, d) = (&a.at, &b.at, &c.at, &d.at);
    let (u, v) = (b - a, d - c);
    let apart = |u: &Vector2<f64>, from: &Vector2<f64>, p: &Vector2<f64>, q: &Vector2<f64>| {
        u.perp(&(p - from)) * u.perp(&(q - from)) < 0.0
    };
    let are_along = || u.perp(&v).abs() <= ALONG * u.norm() * v.norm();
    apart(&u, a, c, d) && apart(&v, c, a, b) && !are_along()
}

fn point(a: &Solid<'_>, b: &Solid<'_>, pair: PairFeature, across: &Across) -> Point {
    let found = witness::<f64, f64>(&pair, a.shape, &a.X, b.shape, &b.X);
    Point::new(pair, &found, across, 0.0)
}

impl Point {
    fn new(pair: PairFeature, found: &Witness<f64>, across: &Across, outside: f64) -> Self {
        let middle: Vector3<f64> = (found.points[0] + found.points[1]) / 2.0;
        Self {
            pair,
            distance: found.distance,
            at: across.place(&middle),
            outside,
        }
    }
}
