//! Numbers of a lane: in double or in single precision.

use super::sin_cos::sin_cos;
use super::single_sin_cos::single_sin_cos;

/// A number of a lane.
pub(super) trait Float: Copy {
    /// The number next to one in double precision.
    fn of(x: f64) -> Self;

    /// Converts it to double precision.
    fn widened(self) -> f64;

    /// `self * factor + term`, rounded once where the target has such an instruction.
    fn fused(self, factor: Self, term: Self) -> Self;

    /// Sines and cosines of angles in radians.
    fn sines_and_cosines<const N: usize>(x: [Self; N]) -> ([Self; N], [Self; N]);
}

macro_rules! floats {
    ($($float:ident $sin_cos:ident;)*) => {$(
        impl Float for $float {
            #[inline(always)]
            #[allow(clippy::cast_possible_truncation, reason = "that is what single precision is")]
            fn of(x: f64) -> Self {
                x as Self
            }

            #[inline(always)]
            fn widened(self) -> f64 {
                self.into()
            }

            #[inline(always)]
            fn fused(self, factor: Self, term: Self) -> Self {
                if cfg!(target_feature = "fma") {
                    self.mul_add(factor, term)
                } else {
                    self * factor + term
                }
            }

            #[inline(always)]
            fn sines_and_cosines<const N: usize>(x: [Self; N]) -> ([Self; N], [Self; N]) {
                $sin_cos(x)
            }
        }
    )*};
}
floats! {
    f64 sin_cos;
    f32 single_sin_cos;
}
