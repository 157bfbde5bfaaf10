//! Sorting of what is sorted seldom: the standard library's sort is 6 to 16 kB of machine code for each type and each order, this one is compiled once.

use std::cmp::Ordering;

/// Sorts indices; those that compare equal keep their order.
pub(crate) fn sort_indices(indices: &mut [usize], compare: &dyn Fn(usize, usize) -> Ordering) {
    indices.sort_by(|&i, &j| compare(i, j));
}

/// Sorts items; those that compare equal keep their order. Allocates.
pub(crate) fn sort_seldom<X>(items: &mut [X], compare: impl Fn(&X, &X) -> Ordering) {
    let mut from: Vec<usize> = (0..items.len()).collect();
    sort_indices(&mut from, &|i, j| compare(&items[i], &items[j]));
    // Along each cycle of the permutation; an index that is its own is done.
    for start in 0..items.len() {
        let mut at = start;
        while from[at] != start {
            let next = from[at];
            items.swap(at, next);
            from[at] = at;
            at = next;
        }
        from[at] = at;
    }
}

#[cfg(test)]
mod tests {
    use super::sort_seldom;
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn items_are_sorted_as_the_standard_library_sorts_them() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        for n in 0..60 {
            let mut items: Vec<(u32, usize)> =
                (0..n).map(|k| (rng.random_range(0..10), k)).collect();
            let mut expected = items.clone();
            expected.sort_by_key(|&(key, _)| key);
            sort_seldom(&mut items, |a, b| a.0.cmp(&b.0));
            assert_eq!(items, expected);
        }
    }
}
