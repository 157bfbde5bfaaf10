//! Differences of distances, in place of derivatives: central where the nearest features stay, from either side where they switch.

use dualbody::collision::{FeatureId, Witness, nearest_features, witness};
use dualbody::spatial::Quaternion;
use rand::RngExt;

use super::pairs::{Pair, Random, V};

/// Directions of a pair: three of translation and three of rotation, of each shape.
pub(crate) const DIRECTIONS: usize = 12;
/// A motion of both shapes.
pub(crate) type Motion = [f64; DIRECTIONS];

/// Steps of differences: longer ones have more digits, and agree where features all but switch.
const STEPS: [f64; 4] = [1e-6, 1e-5, 1e-4, 1e-3];
/// Step from either side where features switch.
const SHORT: f64 = 1e-6;
/// Differences of two steps that agree to this have converged.
const CONVERGED: f64 = 2e-8;
/// Distance by which a point moves with such a step only where the nearest point is another one, m.
const JUMP: f64 = 0.1;

/// Features and their distance.
pub(crate) type Found = (FeatureId, Witness<f64>);

pub(crate) fn found(pair: &Pair) -> Option<Found> {
    let ([a, b], [x, y]) = (&pair.shapes, &pair.at);
    let found = nearest_features(a, x, b, y)?;
    Some((found.id, witness(&found, a, x, b, y)))
}

/// The slope of the distance along a motion.
pub(crate) enum Slope {
    /// One slope.
    Smooth(f64),
    /// The least and the greatest of the slopes from either side.
    Switch(f64, f64),
    /// There is no distance on one side.
    Unknown,
}

/// A motion in a random direction, of unit length.
pub(crate) fn random_motion(rng: &mut Random) -> Motion {
    let motion: Motion = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
    let norm = motion.iter().map(|x| x * x).sum::<f64>().sqrt();
    motion.map(|x| x / norm)
}

/// The slope along a motion, by differences.
pub(crate) fn slope(pair: &Pair, here: &Found, motion: &Motion) -> Slope {
    let mut last: Option<f64> = None;
    for h in STEPS {
        let Some(own) = central(pair, here, motion, h) else {
            break;
        };
        if last.is_some_and(|last| (own - last).abs() <= CONVERGED) {
            return Slope::Smooth(own);
        }
        last = Some(own);
    }
    let [Some(a), Some(b)] = [SHORT, -SHORT].map(|h| one_sided(pair, here, motion, h)) else {
        return Slope::Unknown;
    };
    let all = || a.into_iter().chain(b);
    let [least, most] = [
        all().fold(f64::MAX, f64::min),
        all().fold(f64::MIN, f64::max),
    ];
    Slope::Switch(least, most)
}

/// The central difference, without its error of second order; `None` where features switch.
fn central(pair: &Pair, here: &Found, motion: &Motion, h: f64) -> Option<f64> {
    let at = |h: f64| {
        let (next, w) = found(&moved(pair, motion, h))?;
        let jump = (0..2).map(|k| (w.points[k] - here.1.points[k]).norm());
        let stays = next == here.0 && jump.fold(0.0, f64::max) < JUMP;
        stays.then_some(w.distance)
    };
    let central = |h: f64| Some((at(h)? - at(-h)?) / (2.0 * h));
    Some((4.0 * central(h / 2.0)? - central(h)?) / 3.0)
}

/// The differences of a step to one side, of half of it, and without their error of first order.
fn one_sided(pair: &Pair, here: &Found, motion: &Motion, h: f64) -> Option<[f64; 3]> {
    let slope = |h: f64| {
        let (_, w) = found(&moved(pair, motion, h))?;
        Some((w.distance - here.1.distance) / h)
    };
    let [whole, half] = [slope(h)?, slope(h / 2.0)?];
    Some([whole, half, 2.0 * half - whole])
}

fn moved(pair: &Pair, motion: &Motion, h: f64) -> Pair {
    let mut moved = pair.clone();
    for (at, part) in moved.at.iter_mut().zip(motion.chunks(DIRECTIONS / 2)) {
        at.translation += V::from_column_slice(&part[..3]) * h;
        let turn = V::from_column_slice(&part[3..]) * h;
        at.rotation = Quaternion::exp(&turn).to_matrix() * at.rotation;
    }
    moved
}
