//! The functions of θ² that exponential and logarithm of rotations are made of, smooth at 0.
//!
//! Each is even and analytic in θ, hence a smooth function of x = θ². Near 0 the closed form loses digits, more in
//! every derivative, so below a generous threshold the power series is used: it and its first two derivatives are exact
//! to rounding there. Both sides are always evaluated; the closed form gets a harmless argument where the series is
//! chosen.

use crate::scalar::Scalar;

/// Below this θ² (θ < 1 rad) the exponential's functions come from their series; at the threshold the first omitted
/// term is below 1e-17.
const SERIES_BELOW: f64 = 1.0;

/// Below this tan² of the half angle (angles up to 0.39 rad) the logarithm's function comes from its series; at the
/// threshold the first omitted term is below 1e-18.
const LOG_SERIES_BELOW: f64 = 0.04;

/// Σ cₖ yᵏ by Horner's rule.
#[inline(always)]
fn polynomial<T: Scalar>(y: T, coefficients: &[f64]) -> T {
    let mut sum = T::zero();
    for &c in coefficients.iter().rev() {
        sum = sum.mul_add(y, T::constant(c));
    }
    sum
}

/// `x` where the closed form is used, the threshold elsewhere.
#[inline(always)]
fn guarded<T: Scalar>(x: T, threshold: f64) -> T {
    let threshold = T::constant(threshold);
    x.select_lt(threshold, threshold, x)
}

#[inline(always)]
fn blend<T: Scalar>(x: T, threshold: f64, series: T, closed: T) -> T {
    x.select_lt(T::constant(threshold), series, closed)
}

/// (cos θ, sin θ / θ) of x = θ².
#[inline(always)]
pub(crate) fn cos_sinc<T: Scalar>(x: T) -> (T, T) {
    // cos θ = Σ (−x)ᵏ / (2k)!, sin θ / θ = Σ (−x)ᵏ / (2k+1)!
    const COS: [f64; 11] = inverse_factorials(0);
    const SINC: [f64; 11] = inverse_factorials(1);
    let theta = guarded(x, SERIES_BELOW).sqrt();
    let (sin, cos) = theta.sin_cos();
    (
        blend(x, SERIES_BELOW, polynomial(-x, &COS), cos),
        blend(x, SERIES_BELOW, polynomial(-x, &SINC), sin / theta),
    )
}

/// (1 − cos θ) / θ² of x = θ².
pub(crate) fn versine<T: Scalar>(x: T) -> T {
    // Σ (−x)ᵏ / (2k+2)!
    const VERSINE: [f64; 11] = inverse_factorials(2);
    let safe = guarded(x, SERIES_BELOW);
    let (_, cos) = safe.sqrt().sin_cos();
    blend(
        x,
        SERIES_BELOW,
        polynomial(-x, &VERSINE),
        (-cos + 1.0) / safe,
    )
}

/// (1 − sin θ / θ) / θ² of x = θ².
pub(crate) fn one_minus_sinc<T: Scalar>(x: T) -> T {
    // Σ (−x)ᵏ / (2k+3)!
    const TERMS: [f64; 11] = inverse_factorials(3);
    let safe = guarded(x, SERIES_BELOW);
    let theta = safe.sqrt();
    let (sin, _) = theta.sin_cos();
    blend(
        x,
        SERIES_BELOW,
        polynomial(-x, &TERMS),
        (-(sin / theta) + 1.0) / safe,
    )
}

/// (1 − (θ/2) cot(θ/2)) / θ² of x = θ², for θ < 2π.
pub(crate) fn half_cotangent<T: Scalar>(x: T) -> T {
    // Σ |B₂ₖ₊₂| xᵏ / (2k+2)!, B the Bernoulli numbers
    const TERMS: [f64; 11] = [
        1.0 / 12.0,
        1.0 / 720.0,
        1.0 / 30_240.0,
        1.0 / 1_209_600.0,
        1.0 / 47_900_160.0,
        691.0 / 1_307_674_368_000.0,
        1.0 / 74_724_249_600.0,
        3_617.0 / 10_670_622_842_880_000.0,
        43_867.0 / 5_109_094_217_170_944_000.0,
        174_611.0 / 802_857_662_698_291_200_000.0,
        77_683.0 / 14_101_100_039_391_805_440_000.0,
    ];
    let safe = guarded(x, SERIES_BELOW);
    let half = safe.sqrt() * 0.5;
    let (sin, cos) = half.sin_cos();
    blend(
        x,
        SERIES_BELOW,
        polynomial(x, &TERMS),
        (-(half * cos / sin) + 1.0) / safe,
    )
}

/// arctan(√y) / √y of y = tan²(angle) ≥ 0, given as y = n² / w² with w ≥ 0: returns arctan2(n, w) / n.
pub(crate) fn arc_over_sine<T: Scalar>(n_squared: T, w: T) -> T {
    // arctan(t) / n = (1/w) Σ (−t²)ᵏ / (2k+1), t = n/w
    const ARC: [f64; 13] = odd_reciprocals();
    let threshold = w * w * LOG_SERIES_BELOW;
    let w_safe = n_squared.select_lt(threshold, w, T::one());
    let ratio = n_squared / (w_safe * w_safe);
    let series = polynomial(-ratio.min(T::constant(LOG_SERIES_BELOW)), &ARC) / w_safe;
    let n = n_squared.select_lt(threshold, T::one(), n_squared).sqrt();
    n_squared.select_lt(threshold, series, n.atan2(w) / n)
}

/// 1 / (2k + offset)! for k = 0, 1, …
const fn inverse_factorials<const K: usize>(offset: usize) -> [f64; K] {
    let mut out = [0.0; K];
    let mut factorial = 1.0;
    let mut k = 1;
    while k <= offset {
        factorial *= k as f64;
        k += 1;
    }
    k = 0;
    while k < K {
        out[k] = 1.0 / factorial;
        let n = 2 * k + offset;
        factorial *= ((n + 1) * (n + 2)) as f64;
        k += 1;
    }
    out
}

/// 1 / (2k + 1) for k = 0, 1, …
const fn odd_reciprocals<const K: usize>() -> [f64; K] {
    let mut out = [0.0; K];
    let mut k = 0;
    while k < K {
        out[k] = 1.0 / (2 * k + 1) as f64;
        k += 1;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{ROUNDING, SAME_ALGEBRA};
    use num_dual::{HyperDual64, second_derivative};

    /// Seeds both parts of a hyper-dual number: value, first and second derivative come back.
    fn derivatives(f: impl Fn(HyperDual64) -> HyperDual64, x: f64) -> (f64, f64, f64) {
        let y = f(HyperDual64::new(x, 1.0, 1.0, 0.0));
        (y.re, y.eps1, y.eps1eps2)
    }

    // sinc(√x) has the derivatives of its series: f(0) = 1, f'(0) = −1/6, f''(0) = 2/120.
    #[test]
    fn sinc_at_zero_equals_its_series_coefficients() {
        let (f, df, ddf) = derivatives(|x| cos_sinc(x).1, 0.0);
        assert_eq!((f, df), (1.0, -1.0 / 6.0));
        assert!((ddf - 2.0 / 120.0).abs() < 1e-16);
    }

    #[test]
    fn series_and_closed_form_meet_at_the_threshold_with_two_derivatives() {
        let functions: [fn(HyperDual64) -> HyperDual64; 3] =
            [|x| cos_sinc(x).0, |x| cos_sinc(x).1, versine];
        for f in functions {
            let below = derivatives(f, SERIES_BELOW - 1e-12);
            let above = derivatives(f, SERIES_BELOW + 1e-12);
            for (b, a) in [(below.0, above.0), (below.1, above.1), (below.2, above.2)] {
                assert!((b - a).abs() < SAME_ALGEBRA, "{b} against {a}");
            }
        }
    }

    #[test]
    fn arc_over_sine_meets_at_the_threshold_with_two_derivatives() {
        let f = |y: HyperDual64| arc_over_sine(y, HyperDual64::from(1.0));
        let below = derivatives(f, LOG_SERIES_BELOW - 1e-13);
        let above = derivatives(f, LOG_SERIES_BELOW + 1e-13);
        for (b, a, tolerance) in [
            (below.0, above.0, 1e-12),
            (below.1, above.1, 1e-11),
            (below.2, above.2, 1e-9),
        ] {
            assert!((b - a).abs() < tolerance, "{b} against {a}");
        }
    }

    #[test]
    fn versine_equals_second_derivative_of_closed_form_away_from_zero() {
        let (f, df, ddf) = derivatives(versine, 2.5);
        let (g, dg, ddg) = second_derivative(
            |x| (-num_dual::DualNum::cos(&num_dual::DualNum::sqrt(&x)) + 1.0) / x,
            2.5,
        );
        assert!(
            (f - g).abs() < ROUNDING
                && (df - dg).abs() < ROUNDING
                && (ddf - ddg).abs() < 10.0 * ROUNDING
        );
    }
}
