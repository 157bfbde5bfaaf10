//! A Fourier series that keeps bounds at all times.

use std::f64::consts::{PI, TAU};

use nalgebra::DMatrix;

/// Exponent of the norm that approximates the largest of many numbers: smooth, never below it, and for a hundred numbers at most a fourth above.
const POWER: i32 = 20;
/// Moments in a period of the fastest harmonic.
const MOMENTS: usize = 20;

/// Largest sizes of a motion about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) position: f64,
    pub(super) speed: f64,
    pub(super) acceleration: f64,
}

impl Bounds {
    pub(super) fn are_positive(self) -> bool {
        let all = [self.position, self.speed, self.acceleration];
        all.iter().all(|x| *x > 0.0 && x.is_finite())
    }
}

/// Σ aₖ sin(k ω t) + bₖ cos(k ω t) at moments of a period: linear in its coefficients, which are scaled until it keeps its bounds.
#[derive(Clone, Debug)]
pub(super) struct Series {
    /// Position, velocity and acceleration at each moment over the coefficients, one below the other.
    basis: DMatrix<f64>,
    /// `basis` in units of the bounds.
    relative: DMatrix<f64>,
    /// Share of a bound that moments keep, so that the motion keeps it between them: cos(π / moments in a period of the fastest harmonic).
    share: f64,
}

impl Series {
    /// Memory of a series of so many harmonics.
    pub(super) fn bytes(harmonics: usize) -> usize {
        let rows = harmonics.saturating_mul(3 * MOMENTS);
        let numbers = rows.saturating_mul(harmonics.saturating_mul(2));
        // In two units.
        numbers.saturating_mul(2 * size_of::<f64>())
    }

    pub(super) fn new(period: f64, harmonics: usize, bounds: Bounds) -> Self {
        let moments = MOMENTS * harmonics;
        let mut basis = DMatrix::zeros(3 * moments, 2 * harmonics);
        for i in 0..moments {
            for k in 0..harmonics {
                let order = (k + 1) as f64;
                let rate = order * TAU / period;
                let (sin, cos) = (order * TAU * i as f64 / moments as f64).sin_cos();
                let values = [
                    [sin, cos],
                    [rate * cos, -rate * sin],
                    [-rate * rate * sin, -rate * rate * cos],
                ];
                for (d, [a, b]) in values.into_iter().enumerate() {
                    basis[(3 * i + d, 2 * k)] = a;
                    basis[(3 * i + d, 2 * k + 1)] = b;
                }
            }
        }
        let units = [bounds.position, bounds.speed, bounds.acceleration];
        Self {
            relative: DMatrix::from_fn(basis.nrows(), basis.ncols(), |i, k| {
                basis[(i, k)] / units[i % 3]
            }),
            basis,
            share: (PI / MOMENTS as f64).cos(),
        }
    }

    /// Number of moments.
    pub(super) fn n_moments(&self) -> usize {
        self.basis.nrows() / 3
    }

    /// The norm of a motion in units of its bounds, and its derivatives in the coefficients.
    fn size(&self, x: &[f64]) -> (f64, Vec<f64>) {
        let values = &self.relative * nalgebra::DVector::from_column_slice(x);
        let largest = values.amax().max(f64::MIN_POSITIVE);
        let powers: f64 = values.iter().map(|y| (y / largest).powi(POWER)).sum();
        let size = largest * powers.powf(1.0 / f64::from(POWER));
        let inner = values.map(|y| (y / size).powi(POWER - 1));
        let slopes = self.relative.tr_mul(&inner);
        (size, slopes.as_slice().to_vec())
    }

    /// Coefficients in proportion to the variables, within the bounds.
    pub(super) fn bounded(&self, x: &[f64]) -> Vec<f64> {
        let (size, _) = self.size(x);
        x.iter().map(|x| self.share * x / size).collect()
    }

    /// Derivatives in the variables from those in the coefficients c = s x / ‖x‖:  s (g − (g · c / s) ∂‖x‖) / ‖x‖.
    pub(super) fn bounded_derivatives(&self, x: &[f64], slopes: &[f64]) -> Vec<f64> {
        let (size, by_x) = self.size(x);
        let along: f64 = slopes.iter().zip(x).map(|(g, x)| g * x / size).sum();
        let each = slopes.iter().zip(by_x);
        each.map(|(g, n)| self.share * (g - along * n) / size)
            .collect()
    }

    /// Adds the derivatives in the coefficients from those in position, velocity and acceleration at a moment.
    pub(super) fn add_slopes(
        &self,
        moment: usize,
        slopes: [f64; 3],
        out: &mut nalgebra::MatrixViewMut<
            '_,
            f64,
            nalgebra::U1,
            nalgebra::Dyn,
            nalgebra::U1,
            nalgebra::Dyn,
        >,
    ) {
        for (d, slope) in slopes.into_iter().enumerate() {
            let row = self.basis.row(3 * moment + d);
            out.iter_mut()
                .zip(row.iter())
                .for_each(|(out, basis)| *out += slope * basis);
        }
    }
}
