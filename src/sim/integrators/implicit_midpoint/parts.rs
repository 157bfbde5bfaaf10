//! Division of a step that is too long for the rotation of joints.
//!
//! If joint axes align, for example in a hip of three joints, coordinates rotate by radians in a short time, even for slow bodies. A longer step then
//! has no solution, or several, of which the first one found may be far from the motion. A part must satisfy two criteria: Newton's method converges
//! directly, and the change of kinetic energy equals the work of the forces. The rule satisfies that balance exactly for a constant mass matrix, so
//! neither stiff springs nor strong dampers divide a step.

use crate::cone::Status;
use crate::scalar::Scalar;
use crate::sim::state::State;

/// Most parts of a step.
const MOST: usize = 1024;

/// Largest energy error of a part, relative to the kinetic energy. A smaller one keeps the energy better where steps are divided, but divides more of them,
/// and only undivided steps are symplectic.
const ENERGY: f64 = 3e-4;

/// Displacement in a part of a step, rad or m, that is resolved: below it, errors of the energy and slow convergence are ignored.
pub(super) const TURN: f64 = 0.003;

/// Result of the search for a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    pub(super) status: Status,
    /// Whether the first guess led straight to the solution, which is then the one that continues the motion.
    pub(super) is_direct: bool,
}

impl Search {
    pub(super) fn found(is_direct: bool) -> Self {
        Self {
            status: Status::Converged,
            is_direct,
        }
    }

    pub(super) fn failed(status: Status) -> Self {
        Self {
            status,
            is_direct: false,
        }
    }

    /// The search for a part whose energy has an error, relative to the kinetic energy.
    pub(super) fn with_energy_error(mut self, error: f64) -> Self {
        self.is_direct &= error <= ENERGY;
        self
    }
}

/// Takes a step whole, or in 2, 4, … equal parts: the fewest of which each is found directly, or the most that there may be. Their number, and the worst
/// status.
///
/// * `is_finite` – whether the start and the input are finite; otherwise the step is taken whole, because no division helps
/// * `step` – takes it in so many parts
pub(super) fn divided(is_finite: bool, mut step: impl FnMut(usize) -> Search) -> (usize, Status) {
    let mut parts = 1;
    loop {
        let search = step(parts);
        if search.is_direct || parts == MOST || !is_finite {
            return (parts, search.status);
        }
        parts *= 2;
    }
}

/// Takes parts in sequence, up to one that is not found directly where there may be more parts.
pub(super) fn each(parts: usize, mut take: impl FnMut(usize) -> Search) -> Search {
    let mut all = take(0);
    for k in 1..parts {
        if !all.is_direct && parts < MOST {
            break;
        }
        let search = take(k);
        all.status = all.status.max(search.status);
        all.is_direct &= search.is_direct;
    }
    all
}

/// Whether the start of a step and its input are finite.
pub(super) fn is_finite<T: Scalar>(state: &State<T>, u: &[T]) -> bool {
    state.numbers().chain(u).all(|x| x.value(0).is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of searches, and the number of parts and the status that `divided` returns.
    fn count(is_finite: bool, direct_from: usize) -> (usize, (usize, Status)) {
        let mut searches = 0;
        let found = divided(is_finite, |parts| {
            each(parts, |_| {
                searches += 1;
                match parts >= direct_from {
                    true => Search::found(true),
                    false => Search::failed(Status::NotFinite),
                }
            })
        });
        (searches, found)
    }

    #[test]
    fn a_step_from_numbers_that_are_not_finite_is_searched_once() {
        assert_eq!(count(false, usize::MAX), (1, (1, Status::NotFinite)));
    }

    /// One search of each number of parts that is too small, then one a part.
    #[test]
    fn other_steps_are_divided_until_their_parts_are_found() {
        assert_eq!(count(true, 1), (1, (1, Status::Converged)));
        assert_eq!(count(true, 4), (2 + 4, (4, Status::Converged)));
        let (searches, found) = count(true, usize::MAX);
        assert_eq!((searches, found), (10 + 1024, (1024, Status::NotFinite)));
    }

    #[test]
    fn a_part_whose_energy_has_an_error_is_not_direct() {
        let with = |error| Search::found(true).with_energy_error(error).is_direct;
        assert!(with(0.0) && with(0.9 * ENERGY));
        assert!(!with(1.1 * ENERGY) && !with(f64::NAN));
    }
}
