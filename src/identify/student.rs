//! Quantiles of Student's t distribution.

use crate::special::ln_gamma;

/// # Panics
/// If the probability that an interval holds the true value is not between 0 and 1.
pub(super) fn check_level(level: f64) {
    let is_probability = level > 0.0 && level < 1.0;
    assert!(is_probability, "the level {level} is not between 0 and 1");
}

/// Half of the width, in deviations, of an interval that holds the true value with a probability.
pub(super) fn two_sided(level: f64, freedom: f64) -> f64 {
    quantile(0.5 + 0.5 * level, freedom)
}

/// Computes the number below which Student's t lies with a probability.
///
/// * `probability` – between 0 and 1
/// * `freedom` – degrees of freedom, positive
///
/// # References
/// [Abramowitz, Stegun 1964, 26.7.1].
fn quantile(probability: f64, freedom: f64) -> f64 {
    /// Bisections after which a double has no more digits.
    const BISECTIONS: usize = 200;
    if probability < 0.5 {
        return -quantile(1.0 - probability, freedom);
    }
    let (mut low, mut high) = (0.0, 1.0);
    while cumulative(high, freedom) < probability && high < f64::MAX / 2.0 {
        high *= 2.0;
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        match cumulative(middle, freedom) < probability {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

/// Computes the probability that Student's t lies below a number that is not negative:  1 − ½ I(ν / (ν + t²); ν/2, ½).
fn cumulative(t: f64, freedom: f64) -> f64 {
    let x = freedom / (freedom + t * t);
    1.0 - 0.5 * incomplete_beta(x, 0.5 * freedom, 0.5)
}

/// Computes the regularised incomplete beta function I(x; a, b).
///
/// # References
/// [Abramowitz, Stegun 1964, 26.5.8].
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    let log_beta = ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b);
    let front = (a * x.ln() + b * (-x).ln_1p() - log_beta).exp();
    // The fraction converges fast below the mean.
    match x < (a + 1.0) / (a + b + 2.0) {
        true => front * beta_fraction(x, a, b) / a,
        false => 1.0 - front * beta_fraction(1.0 - x, b, a) / b,
    }
}

/// Evaluates the continued fraction of the incomplete beta function, from its front, by the recurrences of numerators and denominators.
fn beta_fraction(x: f64, a: f64, b: f64) -> f64 {
    /// Some √max(a, b) terms are needed; this is enough for 10⁸ degrees of freedom.
    const TERMS: usize = 20_000;
    let (mut p0, mut p1, mut q0, mut q1) = (0.0, 1.0, 1.0, 1.0);
    let mut last = 0.0;
    for k in 1..TERMS {
        let m = (k / 2) as f64;
        let d = match k % 2 {
            0 => m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)),
            _ => -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)),
        };
        (p0, p1) = (p1, p1 + d * p0);
        (q0, q1) = (q1, q1 + d * q0);
        (p0, p1, q0, q1) = (p0 / q1, p1 / q1, q0 / q1, 1.0);
        if (p1 - last).abs() <= f64::EPSILON * p1.abs() {
            break;
        }
        last = p1;
    }
    p1
}

#[cfg(test)]
mod tests {
    use super::*;

    // Cauchy's distribution is that of one degree of freedom, t = tan(π (p − ½)); with two, t = (2 p − 1) √(2 / (4 p (1 − p))).
    #[test]
    fn quantiles_equal_closed_forms() {
        for p in [0.55, 0.9, 0.975, 0.999] {
            let cauchy = (std::f64::consts::PI * (p - 0.5)).tan();
            assert!((quantile(p, 1.0) / cauchy - 1.0).abs() < 1e-12, "{p}");
            let two = (2.0 * p - 1.0) * (2.0 / (4.0 * p * (1.0 - p))).sqrt();
            assert!((quantile(p, 2.0) / two - 1.0).abs() < 1e-12, "{p}");
            assert!((quantile(1.0 - p, 2.0) / two + 1.0).abs() < 1e-12, "{p}");
        }
    }

    // Table 26.10 of [Abramowitz, Stegun 1964], and the normal distribution in the limit.
    #[test]
    fn quantiles_equal_the_printed_table() {
        for (freedom, expected) in [(5.0, 2.571), (10.0, 2.228), (30.0, 2.042), (120.0, 1.980)] {
            assert!(
                (quantile(0.975, freedom) - expected).abs() < 5e-4,
                "{freedom}"
            );
        }
        for freedom in [1e6, 1e8] {
            assert!((quantile(0.975, freedom) - 1.959_963_985).abs() < 3e-6);
        }
    }
}
