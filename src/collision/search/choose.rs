//! The pair of features that is nearest, of those that take part about a direction.

use nalgebra::Vector3;

use super::curved::{Widest, curved_normal, flat_axis};
use super::difference::Difference;
use super::options::{Choice, Options};
use crate::collision::feature::{Feature, FeatureId, NormalSource, PairFeature};
use crate::collision::placed::{Core, Placed, face_normal};
use crate::collision::shape::Shape;
use crate::collision::solid::Solid;
use crate::collision::witness::nearest_normal;

/// Part of the size by which gaps differ that are equal but for rounding.
const EQUAL: f64 = 1e-14;
/// Tilt below which a normal is across a disc, rad.
const ACROSS: f64 = 1e-9;
/// Part of the size by which gap and distance of features differ that are not those of the normal.
const EXACT: f64 = 1e-9;
/// Part of the size by which the gap of the right features may be narrower.
const NARROWER: f64 = 1e-6;
/// Part of an edge by which a point may lie beyond its ends.
const BEYOND: f64 = 1e-9;

/// A pair of features, and the gap between planes across its normal: the distance of the cores, if no other has a wider one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) pair: PairFeature,
    pub(super) gap: f64,
    /// Distance of the features along the normal, which no gap exceeds where they are the nearest.
    pub(super) distance: f64,
    /// By how much a step of Newton's method would widen the gap of curved features, m: zero where their normal is that of the widest.
    gain: f64,
}

impl Found {
    /// Whether the gap is wider, or as wide and nearer to the distance. Features whose distance is another than the gap give way to those that have it, unless these have a gap
    /// that is much narrower.
    ///
    /// * `size` – of the differences, m
    pub(super) fn is_better(&self, other: &Self, size: f64) -> bool {
        let margin = EQUAL * size;
        let is_exact = |found: &Self| found.lack() <= EXACT * size;
        let narrower = (self.gap - other.gap).abs() <= NARROWER * size;
        if narrower && is_exact(self) != is_exact(other) {
            return is_exact(self);
        }
        let is_equal = (self.gap - other.gap).abs() <= margin;
        if is_equal {
            self.lack() < other.lack() - margin
        } else {
            self.gap > other.gap
        }
    }

    /// By how much the gap may be another than the distance of the features, m.
    pub(super) fn lack(&self) -> f64 {
        (self.distance - self.gap).abs() + self.gain
    }
}

/// The best pair of features about a unit normal that is right to an angle (rad).
pub(super) fn choose(difference: &Difference<'_>, n: &Vector3<f64>, angle: f64) -> Option<Found> {
    best_of(difference, n, angle, |_| true)
}

/// Likewise, without those that have the normal of a face.
pub(super) fn choose_without_faces(
    difference: &Difference<'_>,
    n: &Vector3<f64>,
    angle: f64,
) -> Option<Found> {
    best_of(difference, n, angle, |choice| choice.face.is_none())
}

fn best_of(
    difference: &Difference<'_>,
    n: &Vector3<f64>,
    angle: f64,
    counts: fn(&Choice) -> bool,
) -> Option<Found> {
    let first = Options::new(&difference.a, n, angle);
    let second = Options::new(&difference.b, &-n, angle);
    let mut best: Option<Found> = None;
    for a in first.choices().iter().filter(|a| counts(a)) {
        for b in second.choices().iter().filter(|b| counts(b)) {
            let Some(found) = candidate(difference, n, a, b) else {
                continue;
            };
            if best.is_none_or(|best| found.is_better(&best, difference.size)) {
                best = Some(found);
            }
        }
    }
    best
}

/// A pair of features with its normal, if that is near to a unit normal and their nearest points lie on them.
pub(super) fn candidate(
    difference: &Difference<'_>,
    n: &Vector3<f64>,
    a: &Choice,
    b: &Choice,
) -> Option<Found> {
    let Difference {
        a: first,
        b: second,
        ..
    } = difference;
    let [p, q] = [placed(first, a.feature), placed(second, b.feature)];
    let mut features = [a.feature, b.feature];
    let (Widest { normal, gain }, source) = match (a.face, b.face) {
        (Some(face), _) => (
            Widest::exact(face_normal(face, first.shape, &first.X)),
            NormalSource::First(face),
        ),
        (_, Some(face)) => (
            Widest::exact(-face_normal(face, second.shape, &second.X)),
            NormalSource::Second(face),
        ),
        _ => (
            free_normal(&p, &q, n, &mut features)?,
            NormalSource::Features,
        ),
    };
    // That of curved features may be at the other end of a whole circle of normals as good.
    let is_curved = p.is_curved() || q.is_curved();
    let toward = normal.dot(n) > 0.0 || (is_curved && source == NormalSource::Features);
    let sides = side_radius(first, &p) + side_radius(second, &q);
    let distance = (q.support(&-normal) - p.support(&normal)).dot(&normal) - sides;
    let pair = PairFeature {
        id: FeatureId {
            features,
            normal: source,
        },
        seed: normal,
    };
    toward.then(|| Found {
        pair,
        gap: difference.gap(&normal),
        distance,
        gain,
    })
}

/// Radius of the side of a cylinder, which belongs to the core.
fn side_radius(solid: &Solid<'_>, placed: &Placed<f64>) -> f64 {
    match solid.shape {
        Shape::Cylinder { .. } => placed.radius,
        _ => 0.0,
    }
}

fn placed(solid: &Solid<'_>, feature: Feature) -> Placed<f64> {
    Placed::new(feature, solid.shape, &solid.X)
}

/// The normal between two features, if their nearest points lie on them; edges are turned so that their product points from the first to the second.
fn free_normal(
    p: &Placed<f64>,
    q: &Placed<f64>,
    n: &Vector3<f64>,
    features: &mut [Feature; 2],
) -> Option<Widest> {
    if let (Core::Line(u), Core::Line(v)) = (&p.core, &q.core) {
        let normal = crossing_normal(&(q.center - p.center), u, v)?;
        if normal.dot(n) < 0.0 {
            turn(&mut features[1]);
            return Some(Widest::exact(-normal));
        }
        return Some(Widest::exact(normal));
    }
    let widest = if p.is_curved() || q.is_curved() {
        curved_normal(p, q, n)
    } else {
        Widest::exact(nearest_normal(&[*p, *q], n))
    };
    let normal = &widest.normal;
    if is_across(p, normal) || is_across(q, normal) {
        return None;
    }
    let (x, y) = (p.support(normal), q.support(&-normal));
    (is_on(p, &y, normal) && is_on(q, &x, normal)).then_some(widest)
}

/// Whether a normal is across a disc or a flat ellipsoid, no point of whose rim lies farthest there: the face does.
fn is_across(own: &Placed<f64>, normal: &Vector3<f64>) -> bool {
    flat_axis(own).is_some_and(|axis| axis.cross(normal).norm() <= ACROSS)
}

fn turn(feature: &mut Feature) {
    if let Feature::Edge(ends) = feature {
        ends.reverse();
    }
}

/// The normal of two edges that cross between their ends; none of parallel ones.
fn crossing_normal(
    apart: &Vector3<f64>,
    u: &Vector3<f64>,
    v: &Vector3<f64>,
) -> Option<Vector3<f64>> {
    let normal = u.cross(v);
    let square = normal.norm_squared();
    let is_parallel = square <= (BEYOND * u.norm() * v.norm()).powi(2);
    let between = |t: f64| (-BEYOND..=1.0 + BEYOND).contains(&(t / square));
    let on_both = between(apart.cross(v).dot(&normal)) && between(apart.cross(u).dot(&normal));
    (!is_parallel && on_both).then(|| normal / square.sqrt())
}

/// Whether the point of an edge opposite a point lies between its ends; other features have no ends.
fn is_on(own: &Placed<f64>, point: &Vector3<f64>, normal: &Vector3<f64>) -> bool {
    let Core::Line(u) = &own.core else {
        return true;
    };
    let apart = point - own.center;
    let across = apart - normal * apart.dot(normal);
    let t = across.dot(u);
    let square = u.norm_squared();
    t >= -BEYOND * square && t <= (1.0 + BEYOND) * square
}
