//! Vector instructions that are found when the program runs.
//!
//! A program that is compiled for every CPU of its kind knows only the narrowest vectors, two numbers wide on `x86_64`.
//! What runs under [`vectorized`] is compiled three times, for AVX-512, for AVX2 and for any CPU, and the one that fits
//! is called. Only what is inlined into it is, so the functions on the way are marked to be. Products are fused only
//! where the program as a whole is compiled for a CPU that can: results do not depend on where it runs. Builds with debug
//! assertions, as those of tests are, have one copy: without the optimisations that make vector instructions the others would only
//! take time to compile.
//!
//! Where several slices are gone through at once in such work, and in other loops that are hot, it is by index: what makes an iterator of two is
//! a call that is not inlined everywhere, and the loop then does not know its length.

use super::{Scalar, may_be_f64};

/// Runs `work` with the widest vector instructions that the CPU has.
#[cfg(all(
    target_arch = "x86_64",
    not(target_feature = "avx512f"),
    not(dualbody_one_width),
    not(debug_assertions)
))]
#[inline(always)]
pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// Runs `work`: what the program is compiled for is the widest that there is, or the only one that is asked for (`--cfg dualbody_one_width`, for
/// tools that do not know the instructions of wider ones; debug assertions).
#[cfg(not(all(
    target_arch = "x86_64",
    not(target_feature = "avx512f"),
    not(dualbody_one_width),
    not(debug_assertions)
)))]
#[inline(always)]
pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    work()
}

/// [`vectorized`] for work on many numbers of a type, where vector instructions serve it: three copies of the work are
/// compiled.
#[inline(always)]
pub(crate) fn vectorized_over<T: Scalar, R>(work: impl FnOnce() -> R) -> R {
    if const { may_be_f64::<T>() } {
        vectorized(work)
    } else {
        T::vectorized(work)
    }
}

/// y + a x, for a fixed number of entries: taken out of memory and put back as a whole, they are worked on together
/// also where the compiler cannot know that `x` and `y` lie apart.
#[inline(always)]
pub(crate) fn plus_scaled<T: Scalar, const N: usize>(y: &[T; N], a: T, x: &[T; N]) -> [T; N] {
    let mut sum = *y;
    for i in 0..N {
        sum[i] = a.mul_add(x[i], sum[i]);
    }
    sum
}
