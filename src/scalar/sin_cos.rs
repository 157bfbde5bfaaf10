//! Sine and cosine of several angles at once, without a branch, so that one source serves a number and SIMD lanes
//! alike.
//!
//! The angle is reduced by a multiple of π/2 that is subtracted in three parts (Cody and Waite), so exactly that only
//! the last rounding is felt; the remainder in ±π/4 goes through the minimax polynomials of FDLIBM. Error below one
//! unit in the last place of the library functions for |x| ≤ [`LARGEST`]; beyond it, and for what is not finite, the
//! library functions are called, lane by lane.
//!
//! # References
//! [Cody, Waite 1980]; [FDLIBM, `k_sin.c`, `k_cos.c`, `e_rem_pio2.c`].

use super::widths::ANGLES;
use crate::scalar::from_each;

/// Defines `reduced(x)`, sine and cosine by those of the remainder, for numbers of a type whose `HALF_PI`, `TO_INTEGER` and `kernel` are in scope.
macro_rules! reduction {
    ($float:ident, $bits:ident) => {
        #[inline(always)]
        fn reduced(x: $float) -> ($float, $float) {
            let shifted = x * std::$float::consts::FRAC_2_PI + TO_INTEGER;
            let turns = shifted - TO_INTEGER;
            let r = ((x - turns * HALF_PI[0]) - turns * HALF_PI[1]) - turns * HALF_PI[2];
            let (sin, cos) = kernel(r);
            // The quadrant: odd ones exchange the two, the second bit of n and of n + 1 is the sign.
            let quadrant = shifted.to_bits();
            let exchanged = quadrant & 1 != 0;
            let (s, c) = if exchanged { (cos, sin) } else { (sin, cos) };
            (
                with_sign(s, quadrant),
                with_sign(c, quadrant.wrapping_add(1)),
            )
        }

        /// `x`, negated if the second lowest bit of `bits` is set.
        #[inline(always)]
        fn with_sign(x: $float, bits: $bits) -> $float {
            $float::from_bits(x.to_bits() ^ ((bits & 2) << ($bits::BITS - 2)))
        }
    };
}
pub(super) use reduction;
reduction!(f64, u64);

/// Largest angle up to which the multiple of π/2 has at most 20 bits, so that its product with a part of π/2 of 33 bits
/// is exact.
const LARGEST: f64 = 1e6;

/// π/2 in parts: two of 33 bits, then what is left.
const HALF_PI: [f64; 3] = [
    1.570_796_326_734_125_6,
    6.077_100_506_303_966e-11,
    2.022_266_248_795_950_6e-21,
];

/// sin r ≈ r + r³ P(r²) on ±π/4, from the lowest power.
const SIN: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];

/// cos r ≈ 1 − r²/2 + r⁴ P(r²) on ±π/4, from the lowest power.
const COS: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Added and subtracted, it rounds a number to an integer, whose lowest bits are then those of the sum: 1.5 · 2⁵².
const TO_INTEGER: f64 = 6_755_399_441_055_744.0;

/// Sines and cosines of angles in radians.
#[inline(always)]
pub(crate) fn sin_cos<const N: usize>(x: [f64; N]) -> ([f64; N], [f64; N]) {
    let (mut sin, mut cos) = ([0.0; N], [0.0; N]);
    for i in 0..N {
        (sin[i], cos[i]) = reduced(x[i]);
    }
    // NaN is not within, either.
    let within = x
        .iter()
        .fold(true, |within, x| within & (x.abs() <= LARGEST));
    if within {
        (sin, cos)
    } else {
        by_library(x, sin, cos)
    }
}

/// Sines and cosines of many numbers that are not plain: `angle` takes a number's value, `apply` gives its sine and
/// cosine from those of the value.
#[inline(always)]
pub(crate) fn sin_cos_each<T>(
    x: &[T],
    out: &mut [(T, T)],
    angle: impl Fn(&T) -> f64,
    apply: impl Fn(&T, f64, f64) -> (T, T),
) {
    for first in (0..x.len()).step_by(ANGLES) {
        let count = ANGLES.min(x.len() - first);
        let (x, out) = (&x[first..][..count], &mut out[first..][..count]);
        let mut angles = [0.0; ANGLES];
        for i in 0..count {
            angles[i] = angle(&x[i]);
        }
        let (sin, cos) = sin_cos(angles);
        for i in 0..count {
            out[i] = apply(&x[i], sin[i], cos[i]);
        }
    }
}

/// Sines and cosines with the library's results where an angle is too large: a lane does not feel what is in the
/// others.
#[cold]
fn by_library<const N: usize>(x: [f64; N], sin: [f64; N], cos: [f64; N]) -> ([f64; N], [f64; N]) {
    let choose = |i: usize, own: f64, library: fn(f64) -> f64| {
        if x[i].abs() <= LARGEST {
            own
        } else {
            library(x[i])
        }
    };
    (
        from_each(|i| choose(i, sin[i], f64::sin)),
        from_each(|i| choose(i, cos[i], f64::cos)),
    )
}

/// Sine and cosine on ±π/4.
#[inline(always)]
fn kernel(r: f64) -> (f64, f64) {
    let z = r * r;
    let sin = r + r * z * polynomial(&SIN, z);
    let half = z * 0.5;
    let w = 1.0 - half;
    // The higher powers restore the rounding of 1 − z/2.
    let cos = w + (((1.0 - w) - half) + z * z * polynomial(&COS, z));
    (sin, cos)
}

/// Horner's scheme in two halves, which depend on each other less.
#[inline(always)]
fn polynomial(c: &[f64; 6], z: f64) -> f64 {
    let w = z * z;
    (c[0] + z * (c[1] + z * c[2])) + z * w * (c[3] + z * (c[4] + z * c[5]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance in units in the last place of the expected number, not less than those of the smallest normal one.
    fn ulps(actual: f64, expected: f64) -> f64 {
        let exponent = expected.abs().max(f64::MIN_POSITIVE).log2().floor();
        (actual - expected).abs() / (exponent - 52.0).exp2()
    }

    fn largest_error(angles: impl Iterator<Item = f64>) -> f64 {
        angles.fold(0.0, |largest, x| {
            let ([s], [c]) = sin_cos([x]);
            f64::max(largest, ulps(s, x.sin()).max(ulps(c, x.cos())))
        })
    }

    #[test]
    fn sin_cos_equals_the_library_to_two_units_in_the_last_place() {
        const STEPS: i32 = 400_000;
        for largest in [1e-3, 1.0, 10.0, 1e3, LARGEST] {
            let angles = (-STEPS..=STEPS).map(|i| largest * f64::from(i) / f64::from(STEPS));
            let error = largest_error(angles);
            assert!(error <= 2.0, "up to {largest}: {error} units");
        }
    }

    // Where sine or cosine nearly vanish, a small error of the angle would be a large one of the result.
    #[test]
    fn sin_cos_equals_the_library_next_to_multiples_of_a_right_angle() {
        let angles = (-600_000..600_000)
            .map(|k| f64::from(k) * std::f64::consts::FRAC_PI_2)
            .flat_map(|x| [x, x.next_up(), x.next_down()]);
        let error = largest_error(angles);
        assert!(error <= 2.0, "{error} units");
    }

    #[test]
    fn lanes_equal_single_angles() {
        let x = [0.3, -2.0, 1e5, -0.0, 700.0, 1e-300, 3.2, -9.0];
        let (s, c) = sin_cos(x);
        for i in 0..8 {
            let ([s1], [c1]) = sin_cos([x[i]]);
            assert_eq!(
                (s[i].to_bits(), c[i].to_bits()),
                (s1.to_bits(), c1.to_bits()),
                "{}",
                x[i]
            );
        }
    }

    // A state that diverges next to others must not change a bit of them.
    #[test]
    fn lanes_do_not_feel_large_angles_next_to_them() {
        let x = [0.3, 1e9, -2.0, f64::NAN, 1e-300, f64::INFINITY];
        let (s, c) = sin_cos(x);
        for i in [0, 1, 2, 4] {
            let ([s1], [c1]) = sin_cos([x[i]]);
            assert_eq!((s[i], c[i]), (s1, c1), "{}", x[i]);
        }
    }

    #[test]
    fn large_angles_and_what_is_not_finite_go_to_the_library() {
        let ([s, _, _], [c, nan, infinite]) = sin_cos([1e15, f64::NAN, f64::INFINITY]);
        assert_eq!((s, c), (1e15_f64.sin(), 1e15_f64.cos()));
        assert!(nan.is_nan() && infinite.is_nan());
    }
}
