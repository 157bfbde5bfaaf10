//! Vector instructions that are found when the program runs.
//!
//! A program that is compiled for every CPU of its kind knows only the narrowest vectors, two numbers wide on `x86_64`. What runs
//! under [`vectorized`] is compiled three times, for AVX-512, for AVX2 and for any CPU, and the one that fits is called. Only what
//! is inlined into it is, so the functions on the way are marked to be. Products are fused only where the program as a whole is
//! compiled for a CPU that can: results do not depend on where it runs.

/// Runs `work` with the widest vector instructions that the CPU has.
#[cfg(all(target_arch = "x86_64", not(target_feature = "avx512f")))]
#[inline(always)]
pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// Runs `work`: what the program is compiled for is the widest that there is.
#[cfg(not(all(target_arch = "x86_64", not(target_feature = "avx512f"))))]
#[inline(always)]
pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    work()
}
