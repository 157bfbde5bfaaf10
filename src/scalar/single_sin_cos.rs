//! Sine and cosine of several angles at once in single precision, as in `sin_cos.rs`: without a branch, the angle reduced by a multiple of π/2 in
//! three parts, the remainder through minimax polynomials.
//!
//! Results are within 1.2e-7 of the exact ones for |x| ≤ [`LARGEST`]; beyond it, and for what is not finite, they come from the functions in
//! double precision, lane by lane.
//!
//! # References
//! [Moshier 1989] for the parts of π/2 and the polynomials.

use super::sin_cos::reduction;

reduction!(f32, u32);

/// Largest angle up to which the multiple of π/2 has at most 13 bits, so that its products with the first two parts of π/2, of 8 and 11 bits, are
/// exact.
const LARGEST: f32 = 1e4;

/// π/2 in parts.
const HALF_PI: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];

/// sin r ≈ r + r³ P(r²) on ±π/4, from the lowest power.
const SIN: [f32; 3] = [-1.666_665_5e-1, 8.332_161e-3, -1.951_529_6e-4];

/// cos r ≈ 1 − r²/2 + r⁴ P(r²) on ±π/4, from the lowest power.
const COS: [f32; 3] = [4.166_664_6e-2, -1.388_731_6e-3, 2.443_315_7e-5];

/// Added and subtracted, it rounds a number to an integer, whose lowest bits are then those of the sum: 1.5 · 2²³.
const TO_INTEGER: f32 = 12_582_912.0;

/// Sines and cosines of angles in radians.
#[inline(always)]
pub(super) fn single_sin_cos<const N: usize>(x: [f32; N]) -> ([f32; N], [f32; N]) {
    let (mut sin, mut cos) = ([0.0; N], [0.0; N]);
    for i in 0..N {
        (sin[i], cos[i]) = reduced(x[i]);
    }
    // NaN is not within, either.
    let within = x.iter().fold(true, |all, x| all & (x.abs() <= LARGEST));
    if !within {
        by_library(&x, &mut sin, &mut cos);
    }
    (sin, cos)
}

/// Takes the library's results where an angle is too large: a lane does not feel what is in the others.
#[cold]
#[allow(
    clippy::cast_possible_truncation,
    reason = "results in single precision"
)]
fn by_library(x: &[f32], sin: &mut [f32], cos: &mut [f32]) {
    for ((&x, sin), cos) in x.iter().zip(sin).zip(cos) {
        if x.is_nan() || x.abs() > LARGEST {
            let (s, c) = f64::from(x).sin_cos();
            (*sin, *cos) = (s as f32, c as f32);
        }
    }
}

/// Sine and cosine on ±π/4.
#[inline(always)]
fn kernel(r: f32) -> (f32, f32) {
    let z = r * r;
    let sin = r + r * z * (SIN[0] + z * (SIN[1] + z * SIN[2]));
    let cos = (1.0 - z * 0.5) + z * z * (COS[0] + z * (COS[1] + z * COS[2]));
    (sin, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEAR: f64 = 1.2e-7;

    #[test]
    fn single_sin_cos_equals_the_library_in_double_precision() {
        for largest in [1e-3_f32, 1.0, 10.0, 300.0, LARGEST] {
            for k in -100_000..=100_000_i32 {
                let x = largest * (k as f32) / 100_000.0;
                let ([s], [c]) = single_sin_cos([x]);
                let (sin, cos) = f64::from(x).sin_cos();
                let off = (f64::from(s) - sin).abs().max((f64::from(c) - cos).abs());
                assert!(off < NEAR, "{x}: {off}");
            }
        }
    }

    #[test]
    fn small_angles_are_their_own_sines() {
        for x in [1e-30_f32, -1e-10, 1e-5] {
            assert_eq!(single_sin_cos([x]), ([x], [1.0]));
        }
    }

    #[test]
    fn large_angles_and_what_is_not_finite_leave_other_lanes_alone() {
        let x = [0.3, 1e9, -2.0, f32::NAN, f32::INFINITY];
        let (s, c) = single_sin_cos(x);
        for i in [0, 2] {
            assert_eq!(([s[i]], [c[i]]), single_sin_cos([x[i]]));
        }
        assert!((f64::from(s[1]) - 1e9_f64.sin()).abs() < NEAR);
        assert!(s[3].is_nan() && c[4].is_nan());
    }
}
