//! The normal across which the gap of two features is the widest, where one of them is curved: Newton's method on values.

use nalgebra::Vector3;

use crate::collision::guard::{ROUNDING, reciprocal_or_zero, rejected};
use crate::collision::newton::newton_step;
use crate::collision::placed::{Core, Placed};
use crate::scalar::MapEach;

/// Most steps of Newton's method on values: some ten, more on slivers.
const MAX_STEPS: usize = 100;
/// Most halvings of a step.
const MAX_HALVINGS: usize = 30;
/// Part of a gap that is rounding.
const EQUALLY_WIDE: f64 = 1e-15;
/// Step of a unit normal that is rounding.
const LAST_STEP: f64 = 1e-15;
/// Tilt of a normal against the axis of a rim below which its side is that of the other shape, rad.
const UPRIGHT: f64 = 1e-3;
/// Part of a gap below which its slope is small: features are as good over much of the sphere.
const SMALL: f64 = 1e-4;

/// A normal across which the gap of features is the widest, and by how much it would be wider after another step, m.
#[derive(Clone, Copy)]
pub(super) struct Widest {
    pub(super) normal: Vector3<f64>,
    pub(super) gain: f64,
}

impl Widest {
    pub(super) fn exact(normal: Vector3<f64>) -> Self {
        Self { normal, gain: 0.0 }
    }
}

/// The normal of features of which one is curved, the better one from two places.
pub(super) fn curved_normal(p: &Placed<f64>, q: &Placed<f64>, n: &Vector3<f64>) -> Widest {
    let own = converged(p, q, n);
    tilted(p, q, n).map_or(own, |start| {
        let other = converged(p, q, &start);
        if gap(p, q, &other.normal) > gap(p, q, &own.normal) {
            other
        } else {
            own
        }
    })
}

/// The stationary normal of features of which one is curved.
fn converged(p: &Placed<f64>, q: &Placed<f64>, start: &Vector3<f64>) -> Widest {
    let mut n = *start;
    if let (Core::Line(u), _) | (_, Core::Line(u)) = (&p.core, &q.core) {
        let across = n - u * (n.dot(u) / u.norm_squared());
        n = across.try_normalize(f64::MIN_POSITIVE).unwrap_or(n);
    }
    let mut gain = 0.0;
    for _ in 0..MAX_STEPS {
        let slope = slope(p, q, &n);
        let newton = newton(p, q, &n, start, &slope);
        gain = newton.dot(&slope);
        let step = if gain >= 0.0 {
            newton
        } else if slope.norm() < SMALL * gap(p, q, &n).abs() {
            // Away from where the gap is narrowest: along the slope it would be many short steps.
            -newton
        } else {
            slope
        };
        match widened(p, q, &n, &step) {
            Some(next) => n = next,
            None => break,
        }
        if step.norm() <= LAST_STEP {
            break;
        }
    }
    Widest {
        normal: n,
        gain: gain.abs(),
    }
}

/// Gap of two features between planes across a normal, m.
fn gap(p: &Placed<f64>, q: &Placed<f64>, n: &Vector3<f64>) -> f64 {
    (q.support(&-n) - p.support(n)).dot(n)
}

/// A normal near the axis of a rim, tilted so that the point of the rim along it is the one beneath the other shape; near the axis that is not where steps lead.
fn tilted(p: &Placed<f64>, q: &Placed<f64>, n: &Vector3<f64>) -> Option<Vector3<f64>> {
    if matches!(p.core, Core::Line(_)) || matches!(q.core, Core::Line(_)) {
        return None;
    }
    let (axis, toward) = match (flat_axis(p), flat_axis(q)) {
        (Some(axis), _) => (axis, q.support(&-n) - p.center),
        (_, Some(axis)) => (axis, q.center - p.support(n)),
        _ => return None,
    };
    let across = |v: &Vector3<f64>| v - axis * axis.dot(v);
    if across(n).norm() > UPRIGHT {
        return None;
    }
    let toward = across(&toward).try_normalize(f64::MIN_POSITIVE)?;
    Some((axis * axis.dot(n) + toward * UPRIGHT).normalize())
}

/// The unit axis across a disc or a flat ellipsoid.
pub(super) fn flat_axis(own: &Placed<f64>) -> Option<Vector3<f64>> {
    match &own.core {
        Core::Disc(axis, _) => Some(*axis),
        Core::Ellipsoid(map) => {
            let flat = (0..3).find(|&k| map.column(k).norm_squared() == 0.0)?;
            let [u, v] = [1, 2].map_each(|k| map.column((flat + k) % 3));
            u.cross(&v).try_normalize(f64::MIN_POSITIVE)
        }
        _ => None,
    }
}

/// A step of Newton's method.
fn newton(
    p: &Placed<f64>,
    q: &Placed<f64>,
    n: &Vector3<f64>,
    start: &Vector3<f64>,
    slope: &Vector3<f64>,
) -> Vector3<f64> {
    let step = newton_step(p, q, n, start, ROUNDING);
    if step == Vector3::zeros() {
        along_slope(p, q, n, slope)
    } else {
        step
    }
}

/// Newton's step along the slope only, for a stiffness that vanishes across it.
fn along_slope(
    p: &Placed<f64>,
    q: &Placed<f64>,
    n: &Vector3<f64>,
    slope: &Vector3<f64>,
) -> Vector3<f64> {
    let stiff = p.curvature(n, slope) + q.curvature(n, slope) + slope * gap(p, q, n);
    let square = slope.norm_squared();
    slope * (square * reciprocal_or_zero(slope.dot(&stiff)))
}

/// The derivative of the gap of two features in the normal, across it; with a line across that too.
fn slope(p: &Placed<f64>, q: &Placed<f64>, n: &Vector3<f64>) -> Vector3<f64> {
    let w = q.support(&-n) - p.support(n);
    let along = match (&p.core, &q.core) {
        (Core::Line(u), _) | (_, Core::Line(u)) => rejected(&w, u),
        _ => w,
    };
    along - n * n.dot(&along)
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
    let least = before.dot(n) - EQUALLY_WIDE * before.norm();
    // A step of a right angle or more says only where to look.
    let mut part = 1.0 / step.norm().max(1.0);
    for _ in 0..MAX_HALVINGS {
        let next = (n + step * part).normalize();
        if apart(&next).dot(&next) >= least {
            return Some(next);
        }
        part *= 0.5;
    }
    None
}
