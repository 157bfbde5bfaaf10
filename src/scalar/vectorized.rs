//! Vector instructions that are found when the program runs.
//!
//! A program that is compiled for every CPU of its kind knows only the narrowest vectors, two numbers wide on `x86_64`.
//! Code under [`vectorized`] is compiled three times, for AVX-512, for AVX2 and for any CPU, and the one that fits
//! is called; over [`Lanes`](super::Lanes) there is none for any CPU, since work on them pays only where registers hold several numbers. Only what is inlined into it is, so the functions on the way are marked to be. Products are fused only
//! where the program as a whole is compiled for a CPU that can: results do not depend on where it runs. Builds with debug
//! assertions, as those of tests are, have one copy: without the optimisations that make vector instructions the others would only
//! take time to compile.
//!
//! Where several slices are gone through at once in such work, and in other loops that are hot, it is by index: what makes an iterator of two is
//! a call that is not inlined everywhere, and the loop then does not know its length.

use super::{Scalar, may_be_f64};

/// Dispatch by the CPU: the vector instructions are chosen when the program runs.
#[cfg(all(
    target_arch = "x86_64",
    not(target_feature = "avx512f"),
    not(dualbody_one_width),
    not(debug_assertions)
))]
mod dispatch {
    use dualbody_dispatch::{Avx2, Avx512};

    /// Runs `work` with the widest vector instructions that the CPU has.
    #[inline(always)]
    pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
        if let Some(avx512) = Avx512::find() {
            avx512.run(work)
        } else if let Some(avx2) = Avx2::find() {
            avx2.run(work)
        } else {
            work()
        }
    }

    /// Runs `work` on as many lanes, with AVX-512 or AVX2. There is no copy for other CPUs, which would be a sixth of the code of the library.
    #[inline(always)]
    pub(crate) fn vectorized_lanes<R, const N: usize>(work: impl FnOnce() -> R) -> R {
        // Four lanes fill the registers of AVX2.
        if N > 4
            && let Some(avx512) = Avx512::find()
        {
            return avx512.run(work);
        }
        match Avx2::find() {
            Some(avx2) => avx2.run(work),
            None => without_registers(),
        }
    }

    /// Whether [`vectorized_lanes`] can run.
    #[inline]
    pub(crate) fn has_lanes() -> bool {
        Avx2::find().is_some()
    }

    #[cold]
    fn without_registers() -> ! {
        panic!(
            "dynamics over `Lanes` need a CPU with AVX2; ask `Lanes::is_supported`, or take `f64`, which gives the same bits"
        )
    }
}

/// No dispatch: the program is compiled for the widest instructions, or for one width only (debug assertions, or `--cfg dualbody_one_width` for
/// tools that do not know wider ones).
#[cfg(not(all(
    target_arch = "x86_64",
    not(target_feature = "avx512f"),
    not(dualbody_one_width),
    not(debug_assertions)
)))]
mod dispatch {
    #[inline(always)]
    pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
        work()
    }

    #[inline(always)]
    pub(crate) fn vectorized_lanes<R, const N: usize>(work: impl FnOnce() -> R) -> R {
        work()
    }

    #[inline]
    pub(crate) fn has_lanes() -> bool {
        true
    }
}

pub(crate) use dispatch::{has_lanes, vectorized, vectorized_lanes};

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
