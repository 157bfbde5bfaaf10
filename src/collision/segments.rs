//! The nearest features of two points or segments: cores of spheres and capsules.

use nalgebra::Vector3;

use super::feature::{Feature, FeatureId, NormalSource, PairFeature};
use super::guard::ROUNDING;
use super::solid::Solid;

/// Sine of the angle between segments below which they count as parallel: products of rounded directions say no more.
const PARALLEL: f64 = 1e-9;

/// A segment from p along u.
struct Segment {
    p: Vector3<f64>,
    u: Vector3<f64>,
}

impl Segment {
    fn of(solid: &Solid<'_>) -> Self {
        let p = solid.vertex(0);
        let u = solid.vertex(solid.shape.n_vertices() - 1) - p;
        Self { p, u }
    }

    /// Place of the point nearest to x, from 0 to 1.
    fn nearest(&self, x: &Vector3<f64>) -> f64 {
        let square = self.u.norm_squared();
        let along = self.u.dot(&(x - self.p));
        if square > 0.0 {
            (along / square).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }

    /// Lengths of which its points are sums, m.
    fn size(&self) -> f64 {
        self.p.norm() + self.u.norm()
    }

    fn at(&self, s: f64) -> Vector3<f64> {
        self.p + self.u * s
    }
}

/// The nearest features of two shapes whose cores are points or segments; `None` where these are farther apart than a margin, beyond rounding.
pub(super) fn nearest_of_segments(
    a: &Solid<'_>,
    b: &Solid<'_>,
    margin: f64,
) -> Option<PairFeature> {
    let (first, second) = (Segment::of(a), Segment::of(b));
    let (s, t) = nearest_places(&first, &second);
    let apart = second.at(t) - first.at(s);
    let size = first.size() + second.size();
    let far = margin + a.radius() + b.radius();
    if apart.norm() > far + ROUNDING * (size + far) {
        return None;
    }
    let features = [feature(s), feature(t)];
    Some(match features {
        [Feature::Edge(_), Feature::Edge(_)] => crossing(&first, &second, &apart),
        _ => PairFeature {
            id: FeatureId {
                features,
                normal: NormalSource::Features,
            },
            seed: apart
                .try_normalize(ROUNDING * size)
                .unwrap_or_else(|| across(&first, &second)),
        },
    })
}

/// Places of the nearest points of two segments.
fn nearest_places(a: &Segment, b: &Segment) -> (f64, f64) {
    let (uu, uv, vv) = (a.u.norm_squared(), a.u.dot(&b.u), b.u.norm_squared());
    let apart = b.p - a.p;
    let square = a.u.cross(&b.u).norm_squared();
    // The best of: inside both, and each end against the other segment.
    let ends = |s: f64| (s, b.nearest(&a.at(s)));
    let mut best = ends(0.0);
    let distance = |&(s, t): &(f64, f64)| (b.at(t) - a.at(s)).norm_squared();
    for place in [
        ends(1.0),
        (a.nearest(&b.at(0.0)), 0.0),
        (a.nearest(&b.at(1.0)), 1.0),
    ] {
        if distance(&place) < distance(&best) {
            best = place;
        }
    }
    if square > PARALLEL * PARALLEL * uu * vv {
        let (ua, va) = (a.u.dot(&apart), b.u.dot(&apart));
        let s = (ua * vv - va * uv) / square;
        let t = (ua * uv - va * uu) / square;
        let inside = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
        if inside && distance(&(s, t)) < distance(&best) {
            best = (s, t);
        }
    }
    best
}

fn feature(place: f64) -> Feature {
    match place {
        0.0 => Feature::Vertex(0),
        1.0 => Feature::Vertex(1),
        _ => Feature::Edge([0, 1]),
    }
}

/// Two edges that cross, with the second turned so that u × v is the normal from the first to the second.
fn crossing(a: &Segment, b: &Segment, apart: &Vector3<f64>) -> PairFeature {
    let normal = a.u.cross(&b.u);
    let turned = normal.dot(apart) < 0.0;
    let (second, sign) = if turned {
        ([1, 0], -1.0)
    } else {
        ([0, 1], 1.0)
    };
    PairFeature {
        id: FeatureId {
            features: [Feature::Edge([0, 1]), Feature::Edge(second)],
            normal: NormalSource::Features,
        },
        seed: normal.normalize() * sign,
    }
}

/// A unit direction across both segments, for nearest points that coincide.
fn across(a: &Segment, b: &Segment) -> Vector3<f64> {
    let common = a.u.cross(&b.u);
    let longer = if a.u.norm_squared() < b.u.norm_squared() {
        b.u
    } else {
        a.u
    };
    let any = |u: &Vector3<f64>| u.cross(&Vector3::ith(u.iamin(), 1.0));
    let directions = [common, any(&longer)];
    let found = directions
        .iter()
        .find_map(|d| d.try_normalize(f64::MIN_POSITIVE));
    found.unwrap_or_else(Vector3::z)
}
