//! Arrays entry by entry.
//!
//! An algorithm is one function with thousands of such arrays. As loops, only to be unrolled, they took LLVM a third of its time for the whole library, so
//! the usual counts are written out. The rest are loops rather than `std::array::from_fn`, whose closures are not always inlined.

use num_traits::Zero;

/// Entries written out one by one, if the array has that many; other counts leave nothing behind in the code for this one.
macro_rules! written_out {
    ($f:ident, $n:literal: $($i:literal)*) => {
        if const { N == $n }
            && let Some(out) = [$($f($i)),*].first_chunk()
        {
            return *out;
        }
    };
}

/// `[f(0), f(1), …]`: directions of a dual number, columns side by side.
///
/// Larger counts stay loops: with 16 directions written out the library took an eighth longer to compile.
#[inline(always)]
pub(crate) fn each<T: Copy + Zero, const N: usize>(f: impl Fn(usize) -> T) -> [T; N] {
    written_out!(f, 1: 0);
    written_out!(f, 2: 0 1);
    written_out!(f, 3: 0 1 2);
    written_out!(f, 4: 0 1 2 3);
    let mut out = [T::zero(); N];
    for i in 0..N {
        out[i] = f(i);
    }
    out
}

/// `[f(0), f(1), …]`: plain numbers side by side, of which the compiler makes vector instructions.
#[inline(always)]
pub(super) fn each_lane<T: Copy + Zero, const N: usize>(f: impl Fn(usize) -> T) -> [T; N] {
    written_out!(f, 8: 0 1 2 3 4 5 6 7);
    written_out!(f, 16: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
    each(f)
}

/// `[f(0), f(1), …]` of any copies, as `std::array::from_fn`, which also has code for dropping what a panic leaves behind: four times as much to compile.
#[inline]
pub(crate) fn from_each<B: Copy, const N: usize>(mut f: impl FnMut(usize) -> B) -> [B; N] {
    const { assert!(N > 0, "an array without entries has no first one") };
    let mut out = [f(0); N];
    for i in 1..N {
        out[i] = f(i);
    }
    out
}

/// Pairs of items, as [`Iterator::zip`]: for loops of a few rounds. The standard library does not mark the constructor of its pairs to be inlined; where the
/// parts of a crate are not optimised with one another it is a call, which takes longer than the loop.
#[inline]
pub(crate) fn pairs<A: IntoIterator, B: IntoIterator>(
    a: A,
    b: B,
) -> impl Iterator<Item = (A::Item, B::Item)> {
    let (mut a, mut b) = (a.into_iter(), b.into_iter());
    std::iter::from_fn(
        #[inline(always)]
        move || Some((a.next()?, b.next()?)),
    )
}

/// Entries of an array one by one: `map` of the standard library for copies, in a sixth of its code.
pub(crate) trait MapEach<A, const N: usize> {
    /// `[f(x[0]), f(x[1]), …]`.
    fn map_each<B: Copy>(self, f: impl FnMut(A) -> B) -> [B; N];
}

impl<A: Copy, const N: usize> MapEach<A, N> for [A; N] {
    #[inline]
    fn map_each<B: Copy>(self, mut f: impl FnMut(A) -> B) -> [B; N] {
        from_each(|i| f(self[i]))
    }
}
