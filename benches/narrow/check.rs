//! What a pair must satisfy: the distance is the widest gap, the points are on the shapes, the derivatives those of that distance.

use dualbody::Cast;
use dualbody::autodiff::Dual;
use dualbody::collision::{Shape, Witness, nearest_features, witness};
use dualbody::spatial::{Quaternion, Transform};

use super::differences::{DIRECTIONS, Motion, Slope, found, random_motion, slope};
use super::pairs::{Pair, Pose, Random};
use super::proof::{Verdict, climb, widest};
use super::support::{gap, outside, radii};

/// Distances by other formulas, m.
pub(crate) const DISTANCE: f64 = 1e-9;
/// Points: that of an ellipsoid as thin as a sliver moves by 10⁸ m for each radian of its normal.
const POINT: f64 = 1e-7;
/// Derivatives by differences.
pub(crate) const DERIVATIVE: f64 = 1e-7;
/// Part of the distance by which the points of a proof may be off.
const CERTAIN: f64 = 0.2 * DISTANCE;

/// Distance of cores whose normal is one, m.
const APART: f64 = 1e-3;

/// What is wrong with a pair, by how much; zero where nothing is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Errors {
    /// Gap wider than the distance, or one that does not reach it, m.
    pub(crate) distance: f64,
    /// Distance of a point from its shape, or from where the normal leads, m.
    pub(crate) points: f64,
    /// Gradient against the one that normal and points imply.
    pub(crate) gradient: f64,
    /// Gradient along a motion against differences, where features stay and the differences converge.
    pub(crate) difference: f64,
    /// Where features of cores that are apart switch: by how much the gradient is not between the slopes of both sides.
    pub(crate) beyond: f64,
    /// One-sided difference along the normal against one.
    pub(crate) one_sided: f64,
    /// Whether features switch within the shortest step.
    pub(crate) switches: bool,
    /// Whether differences told nothing.
    pub(crate) unknown: bool,
    /// Whether the search for a wider gap ended without a proof.
    pub(crate) unproved: bool,
    /// Whether something was NaN or missing.
    pub(crate) broken: bool,
}

impl Errors {
    /// Whether the distance itself is not what it must be.
    pub(crate) fn is_wrong(&self) -> bool {
        self.broken || self.distance.is_nan() || self.distance > DISTANCE
    }

    pub(crate) fn is_miss(&self) -> bool {
        let lengths = [self.distance, self.one_sided];
        let slopes = [self.gradient, self.difference, self.beyond];
        self.broken
            || self.points.is_nan()
            || self.points > POINT
            || lengths.iter().any(|x| x.is_nan() || *x > DISTANCE)
            || slopes.iter().any(|x| x.is_nan() || *x > DERIVATIVE)
    }
}

/// Compares all of a pair.
pub(crate) fn check(pair: &Pair, rng: &mut Random) -> Errors {
    let motion = random_motion(rng);
    let broken = Errors {
        broken: true,
        ..Errors::default()
    };
    let Some(here) = found(pair) else {
        return broken;
    };
    let at = here.1;
    let Some(gradient) = gradient(pair, &at) else {
        return broken;
    };
    let mut errors = Errors {
        points: points(pair, &at),
        gradient: worst(&gradient, &implied(pair, &at)),
        one_sided: one_sided(pair, &at),
        ..Errors::default()
    };
    (errors.distance, errors.unproved) = distance(pair, &at, errors.points);
    let along: f64 = gradient.iter().zip(&motion).map(|(x, y)| x * y).sum();
    match slope(pair, &here, &motion) {
        Slope::Smooth(slope) => errors.difference = (slope - along).abs(),
        Slope::Switch(least, most) => {
            errors.switches = true;
            // Where cores overlap, normals and points may both be several: a slope is that of one of each, and the one along the normal is known.
            if at.distance + radii(pair) > APART {
                errors.beyond = (least - along).max(along - most).max(0.0);
            }
        }
        Slope::Unknown => errors.unknown = true,
    }
    errors
}

/// By how much the distance is not the widest gap, and whether that is without a proof.
///
/// * `off` – by how much the points may be off the shapes
fn distance(pair: &Pair, at: &Witness<f64>, off: f64) -> (f64, bool) {
    let plane = [0, 1]
        .into_iter()
        .find(|&k| matches!(pair.shapes[k], Shape::HalfSpace));
    if let Some(k) = plane {
        let axis = pair.at[k].rotation.column(2).into_owned();
        let n = if k == 0 { axis } else { -axis };
        return ((gap(pair, &n) - at.distance).abs(), false);
    }
    let mut widest_near = gap(pair, &at.normal);
    if widest_near < at.distance - CERTAIN {
        // A normal between points that all but coincide has few digits; the distance has all.
        widest_near = climb(pair, &at.normal).min(at.distance);
    }
    let lack = (widest_near - at.distance).abs();
    let core = at.points[1] - at.points[0] + at.normal * radii(pair);
    let known = (off <= CERTAIN).then_some(core);
    match widest(pair, at.distance, &at.normal, known, DISTANCE - CERTAIN) {
        Verdict::Proved => (lack, false),
        Verdict::NotFound => (lack, true),
        Verdict::Wider(by) => (lack.max(by), false),
    }
}

/// By how much the points are off the shapes, or not the distance apart along the normal, or the planes across it not there.
fn points(pair: &Pair, at: &Witness<f64>) -> f64 {
    let [p, q] = at.points;
    let apart = (q - p - at.normal * at.distance).norm();
    let off = [0, 1].map(|k| {
        let n = if k == 0 { at.normal } else { -at.normal };
        outside(&pair.shapes[k], &pair.at[k], &at.points[k], &n)
    });
    let lack = match gap(pair, &at.normal) {
        gap if gap.is_finite() => (gap - at.distance).abs(),
        _ => 0.0,
    };
    apart
        .max(lack)
        .max(off[0])
        .max(off[1])
        .max((at.normal.norm() - 1.0).abs())
}

/// The gradient in twelve directions; `None` where it is not finite, or belongs to another distance.
fn gradient(pair: &Pair, at: &Witness<f64>) -> Option<Motion> {
    type D = Dual<f64, DIRECTIONS>;
    let seeded = |at: &Pose, first: usize| -> Transform<D> {
        let variable = |k: usize| D::variable(0.0, first + k);
        let turn = nalgebra::Vector3::from_fn(|k, _| variable(3 + k));
        let rotation = Quaternion::exp(&turn).to_matrix() * at.rotation.map(D::from);
        let move_by = nalgebra::Vector3::from_fn(|k, _| variable(k));
        Transform::new(rotation, at.translation.map(D::from) + move_by)
    };
    let ([a, b], [x, y]) = (&pair.shapes, &pair.at);
    let features = nearest_features(a, x, b, y)?;
    let [a, b] = [a, b].map(|shape| shape.cast::<D>());
    let over = witness(&features, &a, &seeded(x, 0), &b, &seeded(y, 6));
    let d = over.distance;
    let is_same = (d.re - at.distance).abs() <= 1e-12;
    let all = d.eps;
    (is_same && all.iter().all(|x| x.is_finite())).then_some(all)
}

/// ∂d = n · (δq − δp), with points that move with their shapes.
fn implied(pair: &Pair, at: &Witness<f64>) -> Motion {
    let n = at.normal;
    let arm = |k: usize| at.points[k] - pair.at[k].translation;
    let turns = [-arm(0).cross(&n), arm(1).cross(&n)];
    std::array::from_fn(|k| match k {
        0..3 => -n[k],
        3..6 => turns[0][k - 3],
        6..9 => n[k - 6],
        _ => turns[1][k - 9],
    })
}

fn worst(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(x, y)| (x - y).abs())
        .fold(0.0, f64::max)
}

/// Moved along the normal by h, the second shape is h farther away: by no gap less, by no point more.
fn one_sided(pair: &Pair, at: &Witness<f64>) -> f64 {
    const H: f64 = 1e-3;
    let mut moved = pair.clone();
    moved.at[1].translation += at.normal * H;
    found(&moved).map_or(f64::NAN, |(_, next)| {
        (next.distance - at.distance - H).abs()
    })
}
