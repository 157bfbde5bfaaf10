//! Activations: smooth scalar functions of the entries of a residual.

use num_dual::HyperDual64;

use crate::scalar::Scalar;

/// A function a(r) = Σᵢ aᵢ(rᵢ) of a residual: its cost.
///
/// # Examples
/// ```
/// use dualbody::trajopt::Activation;
///
/// assert_eq!(Activation::Quadratic.value(&[3.0, 4.0]), 12.5);
/// let within = Activation::barrier(&[-1.0], &[1.0]);
/// assert_eq!((within.value(&[0.5]), within.value(&[3.0])), (0.0, 2.0));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Activation {
    /// ½ r².
    #[default]
    Quadratic,
    /// ½ wᵢ r², with a weight for each entry.
    Weighted(Vec<f64>),
    /// √(r² + ε²) − ε: ½ r²/ε near zero, |r| far away.
    SmoothAbs {
        /// ε, where the one goes over into the other.
        width: f64,
    },
    /// ½ dist(r, [lower, upper])²: free inside, quadratic outside. Infinite for no bound.
    Barrier {
        /// Lower bound of each entry.
        lower: Vec<f64>,
        /// Upper bound of each entry.
        upper: Vec<f64>,
    },
    /// 1 − exp(−½ r²/ε²): ½ r²/ε² near zero, constant far away, so outliers have no influence.
    Flat {
        /// ε, the width.
        width: f64,
    },
}

impl Activation {
    /// Makes a barrier between two bounds, one pair for each entry of the residual.
    pub fn barrier(lower: &[f64], upper: &[f64]) -> Self {
        Self::Barrier {
            lower: lower.to_vec(),
            upper: upper.to_vec(),
        }
    }

    /// a(r).
    ///
    /// # Panics
    /// If `r` is longer than the weights or bounds.
    pub fn value<T: Scalar>(&self, r: &[T]) -> T {
        let entries = r.iter().enumerate();
        entries.fold(T::zero(), |sum, (i, &r)| sum + self.entry(i, r))
    }

    /// aᵢ(r).
    fn entry<T: Scalar>(&self, i: usize, r: T) -> T {
        match self {
            Self::Quadratic => r * r * 0.5,
            Self::Weighted(weights) => r * r * (0.5 * weights[i]),
            Self::SmoothAbs { width } => (r * r + width * width).sqrt() - *width,
            Self::Barrier { lower, upper } => outside(r, lower[i], upper[i]),
            Self::Flat { width } => -((r * r * (-0.5 / (width * width))).exp()) + 1.0,
        }
    }

    /// The derivative of aᵢ, and a curvature that is not negative: the second derivative where that is positive, else
    /// zero.
    pub(super) fn slope_and_curvature(&self, i: usize, r: f64) -> (f64, f64) {
        match self {
            Self::Quadratic => (r, 1.0),
            _ => {
                let a = self.entry(i, HyperDual64::new(r, 1.0, 1.0, 0.0));
                (a.eps1, a.eps1eps2.max(0.0))
            }
        }
    }

    /// Its number of entries, if fixed.
    pub(super) fn dim(&self) -> Option<usize> {
        match self {
            Self::Weighted(weights) => Some(weights.len()),
            Self::Barrier { lower, upper } => Some(lower.len().min(upper.len())),
            _ => None,
        }
    }
}

/// ½ dist(r, [lower, upper])².
pub(super) fn outside<T: Scalar>(r: T, lower: f64, upper: f64) -> T {
    let beyond = |excess: T| excess.max(T::zero());
    // An infinite bound would make infinite excesses, whose products with zero are NaN.
    let above = if upper < f64::INFINITY {
        beyond(r - upper)
    } else {
        T::zero()
    };
    let below = if lower > f64::NEG_INFINITY {
        beyond(-r + lower)
    } else {
        T::zero()
    };
    (above * above + below * below) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> [Activation; 5] {
        [
            Activation::Quadratic,
            Activation::Weighted(vec![3.0]),
            Activation::SmoothAbs { width: 0.3 },
            Activation::barrier(&[-0.5], &[0.2]),
            Activation::Flat { width: 0.8 },
        ]
    }

    #[test]
    fn slope_and_curvature_equal_finite_differences() {
        const STEP: f64 = 1e-4;
        for activation in all() {
            for r in [-2.0, -0.3, 0.0, 0.1, 1.7] {
                let at = |r: f64| activation.value(&[r]);
                let slope = (at(r + STEP) - at(r - STEP)) / (2.0 * STEP);
                let curvature = (at(r + STEP) - 2.0 * at(r) + at(r - STEP)) / (STEP * STEP);
                let (da, dda) = activation.slope_and_curvature(0, r);
                assert!((da - slope).abs() < 1e-7, "{activation:?} at {r}");
                assert!(
                    (dda - curvature.max(0.0)).abs() < 1e-6,
                    "{activation:?} at {r}"
                );
            }
        }
    }

    #[test]
    fn every_activation_is_zero_at_zero_and_flat_ones_stay_below_their_limit() {
        for activation in all() {
            assert_eq!(activation.value(&[0.0]), 0.0, "{activation:?}");
        }
        assert!(Activation::Flat { width: 0.8 }.value(&[1e3]) <= 1.0);
        let one_sided = Activation::barrier(&[f64::NEG_INFINITY], &[1.0]);
        assert_eq!(one_sided.slope_and_curvature(0, 3.0), (2.0, 1.0));
        assert_eq!(one_sided.slope_and_curvature(0, -3.0), (0.0, 0.0));
    }
}
