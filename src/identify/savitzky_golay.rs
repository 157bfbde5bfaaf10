//! Savitzky–Golay filter: smoothing and derivatives by a polynomial about each sample.
//!
//! A polynomial of degree d is fitted to the 2 m + 1 samples about each, and its value, slope and curvature in the middle are taken: a symmetric
//! finite impulse response, so that nothing is delayed. On a curved joint the samples are measured from the one in the middle, along the tangent there,
//! where first and second derivatives of exponential coordinates are velocity and acceleration.

use nalgebra::{DMatrix, DVector};

use super::error::IdentifyError;
use crate::memory;

/// Least squares fit of a polynomial about each sample.
///
/// Larger windows and lower degrees smooth more: the gain is 71 % near `f = rate (d + 1) / (6.4 m − 9.2)` for windows of 50 samples and more
/// \[Schafer 2011\]; [`gain`](Self::gain) is exact. White noise of standard deviation σ in a velocity causes noise of σ rate √(3 / (m (m + 1) (2 m +
/// 1))) in the acceleration of degree 1 or 2.
///
/// # Examples
/// ```
/// use dualbody::identify::SavitzkyGolay;
///
/// // The slope of a parabola over five samples is (−2, −1, 0, 1, 2) / 10 of these.
/// let filter = SavitzkyGolay::new(2, 2)?;
/// assert!((filter.weights(1)[4] - 0.2).abs() < 1e-14);
/// // Slow motion keeps its amplitude.
/// assert!((filter.gain(0, 0.1, 100.0) - 1.0).abs() < 1e-4);
/// # Ok::<(), dualbody::identify::IdentifyError>(())
/// ```
///
/// # References
/// [Savitzky, Golay 1964; Schafer 2011].
#[derive(Clone, Debug, PartialEq)]
pub struct SavitzkyGolay {
    half_width: usize,
    degree: usize,
    /// Weights of the samples, for value, slope and curvature, in units of one sample.
    weights: [Vec<f64>; 3],
}

impl SavitzkyGolay {
    /// Makes a filter over `half_width` samples on either side, with a polynomial of this degree.
    ///
    /// # Errors
    /// If the degree is below 2 (no curvature), not less than the number of samples, or above 8 (loss of digits). If the samples would need more
    /// memory than the [limit](crate::memory).
    pub fn new(half_width: usize, degree: usize) -> Result<Self, IdentifyError> {
        const MOST: usize = 8;
        let samples = half_width.saturating_mul(2).saturating_add(1);
        if !(2..=MOST).contains(&degree) || degree >= samples {
            return Err(IdentifyError::Filter {
                reason: format!(
                    "a polynomial of degree {degree} over {samples} samples; the degree is from 2 to {MOST}, and less than the number of samples"
                ),
            });
        }
        check_memory(samples, degree)?;
        let m = half_width as f64;
        // Powers of numbers within 1.
        let powers = DMatrix::from_fn(samples, degree + 1, |i, k| {
            ((i as f64 - m) / m).powi(k as i32)
        });
        let qr = powers.qr();
        let (q, r) = (qr.q(), qr.r());
        // The coefficient of a power is a row of R⁻¹ Qᵀ; the factorial makes a derivative of it.
        let row = |power: usize, factorial: f64| {
            let mut unit = DVector::zeros(degree + 1);
            unit[power] = factorial / m.powi(power as i32);
            let solved = r.tr_solve_upper_triangular(&unit);
            let solved = solved.unwrap_or_else(|| unreachable!("powers are independent"));
            (&q * solved).as_slice().to_vec()
        };
        Ok(Self {
            half_width,
            degree,
            weights: [row(0, 1.0), row(1, 1.0), row(2, 2.0)],
        })
    }

    /// Number m of samples on either side.
    pub fn half_width(&self) -> usize {
        self.half_width
    }

    /// Degree of the polynomial.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Weights of the 2 m + 1 samples, in units of one sample.
    ///
    /// * `derivative` – 0 for the value, 1 for the slope, 2 for the curvature
    ///
    /// # Panics
    /// If the derivative is larger than 2.
    pub fn weights(&self, derivative: usize) -> &[f64] {
        assert!(
            derivative <= 2,
            "derivatives of order 0 to 2 exist, got {derivative}"
        );
        &self.weights[derivative]
    }

    /// Computes the gain at a frequency: the ratio of the filtered to the true amplitude of a harmonic, or of its derivative. The phase is zero.
    ///
    /// * `derivative` – 0 for the value, 1 for the slope, 2 for the curvature
    /// * `frequency` – of the harmonic, Hz
    /// * `rate` – samples per second
    ///
    /// # Panics
    /// If the derivative is larger than 2.
    pub fn gain(&self, derivative: usize, frequency: f64, rate: f64) -> f64 {
        let turn = std::f64::consts::TAU * frequency / rate;
        let weights = self.weights(derivative).iter().enumerate();
        let m = self.half_width as f64;
        let angle = |i: usize| turn * (i as f64 - m);
        match derivative {
            1 if turn != 0.0 => weights.map(|(i, w)| w * angle(i).sin()).sum::<f64>() / turn,
            2 if turn != 0.0 => {
                -weights.map(|(i, w)| w * angle(i).cos()).sum::<f64>() / turn.powi(2)
            }
            0 => weights.map(|(i, w)| w * angle(i).cos()).sum(),
            _ => 1.0,
        }
    }

    /// Filters a row of numbers; the result is shorter by m at either end.
    ///
    /// * `rate` – samples per second
    pub(super) fn apply(&self, derivative: usize, rate: f64, x: &[f64], out: &mut Vec<f64>) {
        let weights = self.weights(derivative);
        let scale = rate.powi(derivative as i32);
        out.clear();
        out.extend(x.windows(weights.len()).map(|window| {
            let products = window.iter().zip(weights).map(|(x, w)| x * w);
            scale * products.sum::<f64>()
        }));
    }
}

/// Refuses a filter whose fit has no memory: its powers, and their two factors.
fn check_memory(samples: usize, degree: usize) -> Result<(), IdentifyError> {
    let bytes = samples.saturating_mul(3 * (degree + 1) * size_of::<f64>());
    let checked = memory::check(format_args!("filters over {samples} samples"), bytes);
    checked.map_err(|error| IdentifyError::Filter {
        reason: error.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    // The tables of the paper: value and slope of a parabola over five samples.
    #[test]
    fn weights_equal_the_printed_tables() {
        let filter = SavitzkyGolay::new(2, 2).unwrap();
        let tables = [
            [-3.0, 12.0, 17.0, 12.0, -3.0].map(|x| x / 35.0),
            [-2.0, -1.0, 0.0, 1.0, 2.0].map(|x| x / 10.0),
            [2.0, -1.0, -2.0, -1.0, 2.0].map(|x| x / 7.0),
        ];
        for (derivative, table) in tables.iter().enumerate() {
            for (found, expected) in filter.weights(derivative).iter().zip(table) {
                assert!((found - expected).abs() < 1e-14, "{derivative}: {found}");
            }
        }
    }

    #[test]
    fn filtered_harmonic_equals_the_true_one_times_the_gain() {
        let (rate, frequency) = (200.0, 7.0);
        let turn = std::f64::consts::TAU * frequency;
        for (half_width, degree) in [(5, 2), (10, 4), (20, 3)] {
            let filter = SavitzkyGolay::new(half_width, degree).unwrap();
            let time = |k: usize| k as f64 / rate;
            let x: Vec<f64> = (0..200).map(|k| (turn * time(k)).sin()).collect();
            let mut out = Vec::new();
            for derivative in 0..3 {
                filter.apply(derivative, rate, &x, &mut out);
                let gain = filter.gain(derivative, frequency, rate);
                for (k, found) in out.iter().enumerate() {
                    let angle = turn * time(k + half_width);
                    let expected = match derivative {
                        0 => angle.sin(),
                        1 => turn * angle.cos(),
                        _ => -turn * turn * angle.sin(),
                    };
                    let scale = turn.powi(derivative as i32);
                    assert!((found - gain * expected).abs() < 1e-11 * scale);
                }
            }
        }
    }

    #[test]
    fn polynomials_up_to_the_degree_pass_unchanged() {
        let filter = SavitzkyGolay::new(12, 4).unwrap();
        let t: Vec<f64> = (0..60).map(|k| 0.01 * f64::from(k)).collect();
        let x: Vec<f64> = t
            .iter()
            .map(|t| 1.0 - t + 3.0 * t.powi(3) + t.powi(4))
            .collect();
        let mut out = Vec::new();
        filter.apply(2, 100.0, &x, &mut out);
        for (found, t) in out.iter().zip(&t[12..]) {
            assert!((found - (18.0 * t + 12.0 * t * t)).abs() < 1e-9, "{found}");
        }
    }

    // Where the gain of the value is √½: the rule of [Schafer 2011], good to some percent for long windows.
    #[test]
    fn gain_falls_to_three_decibels_near_the_published_rule() {
        for (half_width, degree) in [(25, 2), (40, 4), (60, 4)] {
            let filter = SavitzkyGolay::new(half_width, degree).unwrap();
            let cutoff = (degree as f64 + 1.0) / (6.4 * half_width as f64 - 9.2);
            let gain = filter.gain(0, cutoff, 1.0);
            assert!(
                (gain - 0.5_f64.sqrt()).abs() < 0.06,
                "{half_width} {degree}: {gain}"
            );
        }
    }

    #[test]
    fn degrees_that_do_not_fit_are_refused() {
        assert!(SavitzkyGolay::new(1, 3).is_err());
        assert!(SavitzkyGolay::new(10, 1).is_err());
        assert!(SavitzkyGolay::new(10, 9).is_err());
        for half_width in [1 << 60, usize::MAX] {
            let text = SavitzkyGolay::new(half_width, 2).unwrap_err().to_string();
            assert!(text.starts_with("filter: filters over"), "{text}");
        }
    }
}
