//! Pieces of a batch.

use std::ops::Range;

/// Ranges of a batch, which are computed in sequence in the same workspace: none has more states than `most`, a multiple of the threads of a block, and all but the first
/// have as many.
///
/// All ranges except the first end where a block ends. The last block of the first may also compute states of the next range, with the same results both times.
pub(crate) fn ranges(count: usize, most: usize) -> impl Iterator<Item = Range<usize>> {
    let most = most.max(1);
    let first = count - count.saturating_sub(1) / most * most;
    let others = (first..count).step_by(most);
    std::iter::once(0..first).chain(others.map(move |start| start..start + most))
}
