//! Vector instructions that are found when the program runs, on `x86_64`.
//!
//! Work that is inlined into [`Avx2::run`] or [`Avx512::run`] is compiled with the instructions of that width, and runs only on a CPU that has them. This
//! crate is apart from `dualbody`, which has no unsafe code. The crate `pulp` offers the same among much else; with its dependencies it takes 11 seconds
//! of processor time to compile, this crate a tenth of one.

#![cfg(target_arch = "x86_64")]

use std::sync::atomic::{AtomicU8, Ordering};

/// The result of [`level`]: 0 before its first call, then 1 for neither, 2 for AVX2, 3 for AVX-512 too.
static FOUND: AtomicU8 = AtomicU8::new(0);

/// A kind of vector instructions that this CPU has: a value exists only where they do.
macro_rules! width {
    ($(#[$words:meta])* $name:ident from $level:literal, $run:ident with $features:literal) => {
        $(#[$words])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub struct $name(());

        impl $name {
            /// These instructions, if this CPU has them.
            #[inline]
            pub fn find() -> Option<Self> {
                (level() >= $level).then_some(Self(()))
            }

            /// Runs `work`. Only inlined code is compiled for this width, so mark the functions that it calls.
            #[inline(always)]
            #[allow(unsafe_code, reason = "the compiler cannot know the CPU")]
            pub fn run<R>(self, work: impl FnOnce() -> R) -> R {
                // SAFETY: `self` was made by `find`, on a CPU that has these instructions.
                unsafe { $run(work) }
            }
        }

        #[target_feature(enable = $features)]
        #[inline]
        fn $run<R>(work: impl FnOnce() -> R) -> R {
            work()
        }
    };
}

width! {
    /// Registers of 256 bits: `x86-64-v3`.
    Avx2 from 2, with_avx2 with "avx2,bmi1,bmi2,f16c,fma,lzcnt,movbe,popcnt"
}
width! {
    /// Registers of 512 bits: `x86-64-v4`.
    Avx512 from 3, with_avx512 with "avx2,bmi1,bmi2,f16c,fma,lzcnt,movbe,popcnt,avx512bw,avx512cd,avx512dq,avx512f,avx512vl"
}

#[inline]
fn level() -> u8 {
    match FOUND.load(Ordering::Relaxed) {
        0 => ask(),
        found => found,
    }
}

/// Asks the CPU and the operating system, which has to save the registers.
#[cold]
fn ask() -> u8 {
    macro_rules! has {
        ($($feature:tt)*) => { true $(&& is_x86_feature_detected!($feature))* };
    }
    let mut found = 1;
    if has!("avx2" "bmi1" "bmi2" "f16c" "fma" "lzcnt" "movbe" "popcnt") {
        found = 2;
        if has!("avx512bw" "avx512cd" "avx512dq" "avx512f" "avx512vl") {
            found = 3;
        }
    }
    FOUND.store(found, Ordering::Relaxed);
    found
}

#[cfg(test)]
mod tests {
    use super::{Avx2, Avx512};

    #[test]
    fn work_gives_its_result_with_each_width() {
        let x: Vec<f64> = (0..37).map(f64::from).collect();
        let sum = || x.iter().map(|x| x * x).sum::<f64>();
        if let Some(width) = Avx2::find() {
            assert_eq!(width.run(sum), 16_206.0);
        }
        if let Some(width) = Avx512::find() {
            assert_eq!(width.run(sum), 16_206.0);
        }
    }

    #[test]
    fn widths_are_those_of_the_cpu() {
        for _ in 0..2 {
            assert_eq!(
                Avx2::find().is_some(),
                is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
            );
            assert_eq!(
                Avx512::find().is_some(),
                is_x86_feature_detected!("avx512vl") && is_x86_feature_detected!("avx512dq")
            );
        }
    }
}
