//! Rounds of an active set: all that break their law change at once, and from some round on only the first of them, which always ends.
//!
//! # References
//! [Júdice & Pires 1994].

use crate::scalar::Scalar;

/// Rounds in which all that break their law change at once; from then on the first of them.
pub(super) const TOGETHER: usize = 10;
/// Most rounds: rounding may keep a force at the end of a piece of its law from settling, on either side of which the motion is the same.
const MOST_ROUNDS: usize = 100;

/// Whether another round is needed after so many changes in a round: while a step is recorded, whether it may be.
///
/// * `recorded` – rounds while a step is recorded
/// * `condition` – what then holds after the last of them
pub(super) fn goes_on<T: Scalar>(
    changes: T,
    round: usize,
    recorded: usize,
    condition: &str,
) -> bool {
    let known = changes.has_value();
    let may = !known && round < recorded;
    let settled = || changes.is_at_most(0.0, condition);
    !(known && round == MOST_ROUNDS) && (may || !settled())
}
