//! The pair of features that is nearest, of those that take part about a direction.

use nalgebra::Vector3;

use super::difference::Difference;
use super::options::{Choice, Options};
use crate::collision::feature::{Feature, FeatureId, NormalSource, PairFeature};
use crate::collision::guard::rejected;
use crate::collision::newton::newton_step;
use crate::collision::placed::{Core, Placed, face_normal};
use crate::collision::shape::Shape;
use crate::collision::solid::Solid;
use crate::collision::witness::nearest_normal;

/// Most steps of Newton's method on values: some ten, more on slivers.
const MAX_STEPS: usize = 100;
/// Most halvings of a step.
const MAX_HALVINGS: usize = 30;
/// Part of a gap that is rounding.
const ROUNDING: f64 = 1e-15;
/// Step of a unit normal that is rounding.
const LAST_STEP: f64 = 1e-15;
/// Part of the size by which gaps differ that are equal but for rounding.
const EQUAL: f64 = 1e-14;
/// Tilt of a normal against the axis of a rim below which its side is that of the other shape, rad.
const UPRIGHT: f64 = 1e-3;
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
}

impl Found {
    /// Whether the gap is wider, or as wide and nearer to the distance. Features whose distance is another than the gap give way to those that have it, unless these have a gap
    /// that is much narrower.
    ///
    /// * `size` – of the differences, m
    pub(super) fn is_better(&self, other: &Self, size: f64) -> bool {
        let margin = EQUAL * size;
        let lack = |found: &Self| (found.distance - found.gap).abs();
        let is_exact = |found: &Self| lack(found) <= EXACT * size;
        let narrower = (self.gap - other.gap).abs() <= NARROWER * size;
        if narrower && is_exact(self) != is_exact(other) {
            return is_exact(self);
        }
        let is_equal = (self.gap - other.gap).abs() <= margin;
        if is_equal {
            lack(self) < lack(other) - margin
        } else {
            self.gap > other.gap
        }
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
    let (normal, source) = match (a.face, b.face) {
        (Some(face), _) => (
            face_normal(face, first.shape, &first.X),
            NormalSource::First(face),
        ),
        (_, Some(face)) => (
            -face_normal(face, second.shape, &second.X),
            NormalSource::Second(face),
        ),
        _ => (
            free_normal(&p, &q, n, &mut features)?,
            NormalSource::Features,
        ),
    };
    let toward = normal.dot(n) > 0.0;
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
) -> Option<Vector3<f64>> {
    if let (Core::Line(u), Core::Line(v)) = (&p.core, &q.core) {
        let normal = crossing_normal(&(q.center - p.center), u, v)?;
        if normal.dot(n) < 0.0 {
            turn(&mut features[1]);
            return Some(-normal);
        }
        return Some(normal);
    }
    let is_curved = p.is_curved() || q.is_curved();
    let normal = if is_curved {
        let normal = converged(p, q, n);
        tilted(p, q, n).map_or(normal, |start| {
            let other = converged(p, q, &start);
            let gap = |n: &Vector3<f64>| (q.support(&-n) - p.support(n)).dot(n);
            if gap(&other) > gap(&normal) {
                other
            } else {
                normal
            }
        })
    } else {
        nearest_normal(&[*p, *q], n)
    };
    if is_across(p, &normal) || is_across(q, &normal) {
        return None;
    }
    let (x, y) = (p.support(&normal), q.support(&-normal));
    (is_on(p, &y, &normal) && is_on(q, &x, &normal)).then_some(normal)
}

/// Whether a normal is across a disc or a flat ellipsoid, no point of whose rim lies farthest there: the face does.
fn is_across(own: &Placed<f64>, normal: &Vector3<f64>) -> bool {
    match &own.core {
        Core::Disc(axis, _) => axis.cross(normal).norm() <= ACROSS,
        Core::Ellipsoid(map) => (0..3).any(|flat| {
            let [u, v] = [1, 2].map(|k| map.column((flat + k) % 3));
            let axis = u.cross(&v);
            let is_flat = map.column(flat).norm_squared() == 0.0;
            is_flat && axis.cross(normal).norm() <= ACROSS * axis.norm()
        }),
        _ => false,
    }
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

/// The stationary normal of features of which one is curved.
fn converged(p: &Placed<f64>, q: &Placed<f64>, start: &Vector3<f64>) -> Vector3<f64> {
    let mut n = *start;
    if let (Core::Line(u), _) | (_, Core::Line(u)) = (&p.core, &q.core) {
        let across = n - u * (n.dot(u) / u.norm_squared());
        n = across.try_normalize(f64::MIN_POSITIVE).unwrap_or(n);
    }
    for _ in 0..MAX_STEPS {
        let (step, length) = ascent(p, q, &n, start);
        match widened(p, q, &n, &step) {
            Some(next) => n = next,
            None => break,
        }
        if length <= LAST_STEP {
            break;
        }
    }
    n
}

/// A normal near the axis of a rim, tilted so that the point of the rim along it is the one beneath the other shape; near the axis that is not where steps lead.
fn tilted(p: &Placed<f64>, q: &Placed<f64>, n: &Vector3<f64>) -> Option<Vector3<f64>> {
    let (axis, toward) = match (&p.core, &q.core) {
        (Core::Line(_), _) | (_, Core::Line(_)) => return None,
        (Core::Disc(axis, _), _) => (axis, q.support(&-n) - p.center),
        (_, Core::Disc(axis, _)) => (axis, q.center - p.support(n)),
        _ => return None,
    };
    let across = |v: &Vector3<f64>| v - axis * axis.dot(v);
    if across(n).norm() > UPRIGHT {
        return None;
    }
    let toward = across(&toward).try_normalize(f64::MIN_POSITIVE)?;
    Some((axis * axis.dot(n) + toward * UPRIGHT).normalize())
}

/// A step of Newton's method where it widens the gap, else one along its derivative; with the length of the step.
fn ascent(
    p: &Placed<f64>,
    q: &Placed<f64>,
    n: &Vector3<f64>,
    start: &Vector3<f64>,
) -> (Vector3<f64>, f64) {
    let newton = newton_step(p, q, n, start);
    let w = q.support(&-n) - p.support(n);
    let along = match (&p.core, &q.core) {
        (Core::Line(u), _) | (_, Core::Line(u)) => rejected(&w, u),
        _ => w,
    };
    let derivative = along - n * n.dot(&along);
    let step = if newton.dot(&derivative) >= 0.0 {
        newton
    } else {
        derivative
    };
    let length = step.norm();
    // A step of a right angle or more says only where to look.
    if length > 1.0 {
        (step / length, length)
    } else {
        (step, length)
    }
}

/// The normal after the longest of a step and its parts that does not make the gap of the features narrower.
fn widened(
    p: &Placed<f64>,
    q: &Placed<f64>,
    n: &Vector3<f64>,
    step: &Vector3<f64>,
) -> Option<Vector3<f64>> {
    let apart = |n: &Vector3<f64>| q.support(&-n) - p.support(n);
    let before = apart(n);
    let least = before.dot(n) - ROUNDING * before.norm();
    let mut part = 1.0;
    for _ in 0..MAX_HALVINGS {
        let next = (n + step * part).normalize();
        if apart(&next).dot(&next) >= least {
            return Some(next);
        }
        part *= 0.5;
    }
    None
}
