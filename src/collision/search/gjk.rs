//! The distance of two convex sets by the algorithm of Gilbert, Johnson and Keerthi.

use nalgebra::Vector3;

use super::difference::Difference;
use super::simplex::Simplex;

/// Most iterations: polytopes need some ten, curved shapes some tens at the tolerances in use.
const MAX_ITERATIONS: usize = 128;
/// Part of the size below which a distance counts as a touch: its direction has no digits left.
const TOUCH: f64 = 1e-10;
/// Part of the size that is rounding.
const ROUNDING: f64 = 1e-15;

/// End of the search for the nearest points.
pub(super) enum Gjk {
    /// Apart; the nearest difference.
    Apart(Vector3<f64>),
    /// Touching or overlapping, with the last simplex.
    Overlap(Simplex),
    /// Farther apart than what is asked for.
    Far,
}

/// The shortest difference of two cores, to a tolerance relative to its length.
///
/// * `start` – a direction from the first to the second
/// * `far` – distance of the cores beyond which it is enough to know that they are apart, m
pub(super) fn gjk(
    difference: &Difference<'_>,
    start: &Vector3<f64>,
    tolerance: f64,
    far: f64,
) -> Gjk {
    let size = difference.size;
    let mut simplex = Simplex::new(difference.support(&-start));
    let mut v = simplex.reduce();
    for _ in 0..MAX_ITERATIONS {
        let square = v.norm_squared();
        if square <= (TOUCH * size).powi(2) {
            return Gjk::Overlap(simplex);
        }
        let w = difference.support(&-v);
        let along = v.dot(&w);
        // The cores are on either side of planes across v, v · w / ‖v‖ apart.
        if along > far * v.norm() {
            return Gjk::Far;
        }
        let gain = square - along;
        let is_old = simplex.points().contains(&w);
        if is_old || gain <= tolerance * square + ROUNDING * size * v.norm() {
            break;
        }
        simplex.push(w);
        let next = simplex.reduce();
        if simplex.points().len() == 4 {
            return Gjk::Overlap(simplex);
        }
        if next.norm_squared() >= square {
            break;
        }
        v = next;
    }
    Gjk::Apart(v)
}
