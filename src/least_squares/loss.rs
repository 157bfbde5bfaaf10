//! Loss functions, which limit the influence of outliers.

/// Loss ρ(s) of the square s = r² of a residual: s for small residuals, less for large ones.
///
/// The parameter δ > 0 is the residual above which the loss grows more slowly, in the unit of the residual. All except the first are for data with
/// outliers. The solution depends on δ; use for example twice the noise of good residuals.
///
/// # References
/// [Huber 1964; Triggs et al. 2000, section 4.3].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Loss {
    /// ρ = s.
    #[default]
    Square,
    /// The square up to δ, then linear: ρ = 2 δ √s − δ². Convex.
    Huber(f64),
    /// A smooth form of [`Huber`](Self::Huber): ρ = 2 δ² (√(1 + s/δ²) − 1). Convex.
    SoftL1(f64),
    /// ρ = δ² ln(1 + s/δ²): outliers have almost no influence, and there may be several minima.
    Cauchy(f64),
}

impl Loss {
    /// ρ(s).
    pub fn value(self, s: f64) -> f64 {
        match self {
            Self::Square => s,
            Self::Huber(delta) if s <= delta * delta => s,
            Self::Huber(delta) => 2.0 * delta * s.sqrt() - delta * delta,
            Self::SoftL1(delta) => {
                let square = delta * delta;
                // √(1 + x) − 1 without cancellation.
                2.0 * s / ((1.0 + s / square).sqrt() + 1.0)
            }
            Self::Cauchy(delta) => delta * delta * (s / (delta * delta)).ln_1p(),
        }
    }

    /// ρ'(s), the weight of a residual relative to the square: 1 for small ones, less for large ones.
    pub fn weight(self, s: f64) -> f64 {
        match self {
            Self::Square => 1.0,
            Self::Huber(delta) if s <= delta * delta => 1.0,
            Self::Huber(delta) => delta / s.sqrt(),
            Self::SoftL1(delta) => (1.0 + s / (delta * delta)).sqrt().recip(),
            Self::Cauchy(delta) => (1.0 + s / (delta * delta)).recip(),
        }
    }

    /// Panics unless δ is positive.
    pub(super) fn check(self) {
        if let Self::Huber(delta) | Self::SoftL1(delta) | Self::Cauchy(delta) = self {
            assert!(
                delta > 0.0 && delta.is_finite(),
                "the residual {delta} beyond which a loss counts less is not positive"
            );
        }
    }
}
