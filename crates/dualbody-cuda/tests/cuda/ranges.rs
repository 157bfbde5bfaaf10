//! Pieces of a batch.

#[path = "../../src/ranges.rs"]
mod pieces;

use pieces::ranges;

const BLOCK: usize = 128;

#[test]
fn pieces_cover_a_batch_once_and_end_where_blocks_end() {
    for count in [1, 5, BLOCK, 1_000, 1_024, 100_003] {
        for most in [BLOCK, 8 * BLOCK, 1 << 20] {
            let all: Vec<_> = ranges(count, most).collect();
            let starts = all.iter().map(|range| range.start);
            let ends = all.iter().map(|range| range.end);
            assert!(starts.skip(1).chain([count]).eq(ends), "{all:?}");
            assert!(
                all.iter().all(|range| (1..=most).contains(&range.len())),
                "{all:?}"
            );
            assert!(all[1..].iter().all(|range| range.len() == most), "{all:?}");
        }
    }
}

// A batch that fits is one piece, however many threads it has.
#[test]
fn a_batch_that_fits_is_one_piece() {
    assert!(ranges(1_003, 1_003).eq(std::iter::once(0..1_003)));
    assert!(ranges(1_003, 2_048).eq(std::iter::once(0..1_003)));
}
