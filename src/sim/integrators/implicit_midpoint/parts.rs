//! Division of a step that is too long for how fast joints turn in it.
//!
//! Where axes of joints come into line, as those of a hip of three joints do, coordinates turn by radians within a moment, however slowly bodies move. A
//! longer step has no solution there, or several, of which the first that is found may be far from the motion.

use crate::cone::Status;
use crate::scalar::Scalar;
use crate::sim::state::State;

/// Most parts of a step.
const MOST: usize = 1024;

/// How much more the velocity may change after the middle of a step than before it.
const UNEVEN: f64 = 2.0;

/// Change of the turn in a step, rad or m, up to which that does not matter.
pub(super) const TURN: f64 = 0.003;

/// What the search for a step came to.
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
}

/// Takes a step whole, or in 2, 4, … equal parts: the fewest of which each is found directly, or the most that there may be. Their number, and the worst
/// status.
///
/// * `step` – takes it in so many parts
pub(super) fn divided(mut step: impl FnMut(usize) -> Search) -> (usize, Status) {
    let mut parts = 1;
    loop {
        let search = step(parts);
        if search.is_direct || parts == MOST {
            return (parts, search.status);
        }
        parts *= 2;
    }
}

/// Takes parts one after the other, up to one that is not found directly where there may be more parts.
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

/// Whether the velocity changes about as much after the middle of a step as before it. It does not where the end has light axes in line.
pub(super) fn is_even<T: Scalar>(start: &State<T>, xi: &[T], end: &State<T>, time: f64) -> bool {
    let most = |v: &State<T>| {
        let changes = v.v.iter().zip(xi).map(|(&v, &xi)| (v - xi).value(0).abs());
        time * changes.fold(0.0, f64::max)
    };
    most(end) <= TURN.max(UNEVEN * most(start))
}
