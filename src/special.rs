//! Special functions of analysis.

/// Computes ln Γ(x) for positive x: Stirling's series, after the recurrence has made the argument large.
///
/// # References
/// [Abramowitz, Stegun 1964, 6.1.40].
pub(crate) fn ln_gamma(mut x: f64) -> f64 {
    /// From where on six terms are exact to rounding.
    const LARGE: f64 = 15.0;
    const TERMS: [f64; 6] = [
        1.0 / 12.0,
        -1.0 / 360.0,
        1.0 / 1260.0,
        -1.0 / 1680.0,
        1.0 / 1188.0,
        -691.0 / 360_360.0,
    ];
    let mut product = 1.0;
    while x < LARGE {
        product *= x;
        x += 1.0;
    }
    let inverse = x.recip();
    let series = TERMS
        .iter()
        .rev()
        .fold(0.0, |sum, c| sum * inverse * inverse + c);
    let half_log = 0.5 * std::f64::consts::TAU.ln();
    (x - 0.5) * x.ln() - x + half_log + series * inverse - product.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    // Γ(½) = √π, Γ(1) = Γ(2) = 1, Γ(5) = 24.
    #[test]
    fn logarithm_of_the_gamma_function_has_its_known_values() {
        let half = 0.5 * std::f64::consts::PI.ln();
        let known = [(0.5, half), (1.0, 0.0), (2.0, 0.0), (5.0, 24_f64.ln())];
        for (x, expected) in known {
            assert!((ln_gamma(x) - expected).abs() < 1e-13, "{x}");
        }
    }
}
