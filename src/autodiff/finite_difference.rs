//! Derivatives by finite differences: slower and less exact, but independent of dual numbers.
//!
//! Each input is varied up and down by decreasing steps. The first step is smaller than the input itself, so positive inputs stay positive; the last
//! is where rounding dominates. The central differences are extrapolated to step zero as in Ridders' method, from any consecutive steps: near a
//! nonsmooth point or a pole those are the small ones. Each entry keeps the extrapolation with the least estimated error, and the error is part of
//! the result.
//!
//! At a nonsmooth point, the central difference is the mean of the slopes of both sides, for all steps. One-sided slopes are extrapolated as well; if
//! they differ, the error estimate contains half the difference.
//!
//! # References
//! [Ridders 1982].

use nalgebra::DMatrix;

use super::VectorFunction;
use crate::scalar::{MapEach, from_each};

/// Largest step, relative to the size of the input.
const FIRST_STEP: f64 = 1.0 / 32.0;

/// Number of steps, and the factor by which each is smaller than the one before: down to 3e-8 of the size.
const LEVELS: usize = 11;
const RATIO: f64 = 4.0;

/// Index of the step below which differences of a smooth function differ by rounding alone.
const SMOOTH: usize = 7;

/// Slopes of two sides differ where their difference is so many times its own error.
const KINK: f64 = 8.0;

/// Scales of the inputs for difference steps.
///
/// # Examples
/// ```
/// # use dualbody::{Scalar, autodiff::{VectorFunction, finite_difference::{Options, estimate}}};
/// # struct Inverse;
/// # impl VectorFunction for Inverse {
/// #     fn n_outputs(&self) -> usize { 1 }
/// #     fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) { y[0] = T::one() / x[0]; }
/// # }
/// // d(1/x)/dx = −1/x² at 0.1 mm: a step of some millimetres would lead across the pole
/// let at = estimate(&Inverse, &[1e-4], &Options::default());
/// assert!((at.jacobian[0] + 1e8).abs() < 1e-2 && at.error[0] < 1e-2);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Size below which an input counts as zero and does not scale its steps; default 1e-6. A larger value gains digits for angles or lengths that
    /// happen to be small; a smaller value is for positive parameters of that size.
    pub zero: f64,
    /// Scale of inputs that count as zero; default 1/32. A larger value gains digits if the function is smooth over such a distance. Positive and finite.
    pub size_of_zero: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            zero: 1e-6,
            size_of_zero: 1.0 / 32.0,
        }
    }
}

impl Options {
    /// The largest step of an input: a power of two, so that most steps are taken without rounding.
    fn first_step(&self, x: f64) -> f64 {
        let size = x.abs();
        // Not `<`, for an input that is NaN shall not make the step one.
        let size = if size >= self.zero.max(f64::MIN_POSITIVE) {
            size
        } else {
            self.size_of_zero
        };
        FIRST_STEP * size.log2().floor().exp2()
    }
}

/// A Jacobian by finite differences, with error estimates.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// The Jacobian, outputs × inputs.
    pub jacobian: DMatrix<f64>,
    /// The estimated error of each entry, not negative: the difference of extrapolations, the rounding error, and half the difference of the
    /// one-sided slopes. It may be too small by a factor of two.
    pub error: DMatrix<f64>,
}

/// Computes the Jacobian at `x`, outputs × inputs, by central differences extrapolated to step zero.
///
/// Takes the arguments of [`super::jacobian`]. It has about eleven digits for smooth functions, at 23 evaluations per input; [`estimate`] returns the
/// error. Allocates.
///
/// * `x` – the inputs, as many as `f` takes
pub fn jacobian<F: VectorFunction>(f: &F, x: &[f64]) -> DMatrix<f64> {
    estimate(f, x, &Options::default()).jacobian
}

/// Computes the Jacobian at `x` with an estimate of the error of each entry. Allocates.
///
/// * `x` – the inputs, as many as `f` takes
pub fn estimate<F: VectorFunction>(f: &F, x: &[f64], options: &Options) -> Estimate {
    estimate_of(f.n_outputs(), |x, y| f.eval(x, y), x, options)
}

/// [`estimate`] of a function f(x, y) of `n` outputs on plain numbers.
pub(crate) fn estimate_of(
    n: usize,
    mut f: impl FnMut(&[f64], &mut [f64]),
    x: &[f64],
    options: &Options,
) -> Estimate {
    let mut out = Estimate {
        jacobian: DMatrix::zeros(n, x.len()),
        error: DMatrix::zeros(n, x.len()),
    };
    let mut ladder = Ladder::new(n);
    let mut moved = x.to_vec();
    f(x, &mut ladder.middle);
    for i in 0..x.len() {
        let mut h = options.first_step(x[i]);
        for rung in &mut ladder.rungs {
            rung.plus_at = x[i] + h;
            rung.minus_at = x[i] - h;
            moved[i] = rung.plus_at;
            f(&moved, &mut rung.plus);
            moved[i] = rung.minus_at;
            f(&moved, &mut rung.minus);
            h /= RATIO;
        }
        moved[i] = x[i];
        for row in 0..n {
            let (slope, error) = ladder.slope(row);
            out.jacobian[(row, i)] = slope;
            out.error[(row, i)] = error;
        }
    }
    out
}

/// The function on both sides of a place.
#[derive(Clone, Debug)]
struct Ladder {
    middle: Vec<f64>,
    rungs: [Rung; LEVELS],
}

/// A step up and down.
#[derive(Clone, Debug)]
struct Rung {
    plus_at: f64,
    minus_at: f64,
    plus: Vec<f64>,
    minus: Vec<f64>,
}

impl Ladder {
    fn new(outputs: usize) -> Self {
        Self {
            middle: vec![0.0; outputs],
            rungs: std::array::from_fn(|_| Rung {
                plus_at: 0.0,
                minus_at: 0.0,
                plus: vec![0.0; outputs],
                minus: vec![0.0; outputs],
            }),
        }
    }

    /// The slope of an output, and its error.
    fn slope(&self, row: usize) -> (f64, f64) {
        let noise = self.noise(row);
        let central = extrapolate(2, |level| {
            let rung = &self.rungs[level];
            Sample::new(rung.central(row), noise / rung.width())
        });
        // (f(x + h) − 2 f(x) + f(x − h)) / h, the slope of the right less that of the left, in odd powers of h
        let middle = self.middle[row];
        let jump = extrapolate(1, |level| {
            let rung = &self.rungs[level];
            let half = 0.5 * rung.width();
            let value = ((rung.plus[row] - middle) - (middle - rung.minus[row])) / half;
            Sample::new(value, 2.0 * noise / half)
        });
        if jump.value.abs() > KINK * jump.error {
            let sides = 0.5 * (jump.value.abs() + jump.error);
            (central.value, central.error + sides)
        } else {
            (central.value, central.error)
        }
    }

    /// Rounding error of the difference of an output over a step: the least that rounding makes, or what is seen where
    /// steps are so small that nothing else is left, which includes rounding inside the function, if that is larger.
    fn noise(&self, row: usize) -> f64 {
        let (mut noise, mut last) = (0.0, None);
        for rung in &self.rungs {
            let largest = rung.plus[row].abs().max(rung.minus[row].abs());
            noise = f64::max(noise, f64::EPSILON * largest);
        }
        for rung in &self.rungs[SMOOTH..] {
            let slope = rung.central(row);
            let change = last.map_or(0.0, |last: f64| (slope - last).abs());
            noise = noise.max(change * rung.width());
            last = Some(slope);
        }
        noise
    }
}

impl Rung {
    /// 2h as it came out.
    fn width(&self) -> f64 {
        self.plus_at - self.minus_at
    }

    /// (f(x + h) − f(x − h)) / 2h, the slope in even powers of h.
    fn central(&self, row: usize) -> f64 {
        (self.plus[row] - self.minus[row]) / self.width()
    }
}

/// A number with its error.
#[derive(Clone, Copy, Debug)]
struct Sample {
    value: f64,
    error: f64,
}

impl Sample {
    fn new(value: f64, error: f64) -> Self {
        Self { value, error }
    }
}

/// Neville's tableau for what has the powers `first`, `first` + 2, … of the step; the answer is the entry that differs
/// least from the two it was made of, but by no less than rounding makes.
fn extrapolate(first: i32, sample: impl Fn(usize) -> Sample) -> Sample {
    let samples: [Sample; LEVELS] = from_each(sample);
    let mut column = samples.map_each(|sample| sample.value);
    let mut best = Sample::new(column[0], f64::INFINITY);
    let mut factor = RATIO.powi(first - 2);
    for order in 1..LEVELS {
        factor *= RATIO * RATIO;
        for level in (order..LEVELS).rev() {
            let (coarse, fine) = (column[level - 1], column[level]);
            let value = fine + (fine - coarse) / (factor - 1.0);
            let apart = (value - fine).abs().max((value - coarse).abs());
            let error = if value.is_finite() {
                apart.max(samples[level].error)
            } else {
                f64::INFINITY
            };
            // Of equals the coarser.
            if error <= best.error {
                best = Sample::new(value, error);
            }
            column[level] = value;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Scalar;
    use crate::tests::{FINITE_DIFFERENCE, OTHER_ALGORITHM};

    /// (sin ωx, 1 / (x + 1/ω²)) with very different curvatures.
    struct Wiggle;
    impl VectorFunction for Wiggle {
        fn n_outputs(&self) -> usize {
            2
        }
        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            y[0] = (x[0] * 20.0).sin_cos().0;
            y[1] = T::one() / (x[0] + 0.05);
        }
    }

    #[test]
    fn extrapolated_differences_equal_closed_form_despite_large_curvature() {
        let j = jacobian(&Wiggle, &[0.1]);
        assert!((j[0] - 20.0 * 2.0_f64.cos()).abs() < OTHER_ALGORITHM, "{j}");
        assert!(
            (j[1] + 1.0 / (0.15 * 0.15)).abs() < FINITE_DIFFERENCE,
            "{j}"
        );
    }

    /// (1 / x, √x, 7) of a positive number of any size; a negative one is refused.
    struct Positive;
    impl VectorFunction for Positive {
        fn n_outputs(&self) -> usize {
            3
        }
        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            assert!(x[0].value(0) > 0.0, "{x:?}");
            y[0] = T::one() / x[0];
            y[1] = x[0].sqrt();
            y[2] = T::constant(7.0);
        }
    }

    #[test]
    fn steps_follow_the_size_of_the_input_and_never_cross_zero() {
        for exponent in -5..9 {
            let x = 1.3 * 10.0_f64.powi(exponent);
            let at = estimate(&Positive, &[x], &Options::default());
            let expected = [-1.0 / (x * x), 0.5 / x.sqrt(), 0.0];
            for (row, expected) in expected.into_iter().enumerate() {
                let (value, error) = (at.jacobian[row], at.error[row]);
                let off = (value - expected).abs();
                assert!(
                    off <= 1e-10 * expected.abs(),
                    "{x}: {value}, not {expected}"
                );
                assert!(
                    error <= OTHER_ALGORITHM * expected.abs() + f64::EPSILON * 7e9 / x,
                    "{x}: {error}"
                );
                assert!(off <= 2.0 * error, "{x}: off by {off}, said {error}");
            }
        }
        let smaller = Options {
            zero: 1e-12,
            ..Options::default()
        };
        let at = estimate(&Positive, &[1e-9], &smaller);
        assert!((at.jacobian[0] + 1e18).abs() < 1e8, "{}", at.jacobian);
    }

    /// A ramp that starts at a place, and its smooth part.
    struct Ramp(f64);
    impl VectorFunction for Ramp {
        fn n_outputs(&self) -> usize {
            2
        }
        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            let along = x[0] - self.0;
            y[0] = Scalar::max(along, T::zero()) * 3.0 + x[0].sin_cos().0;
            y[1] = x[0].exp();
        }
    }

    #[test]
    fn error_at_a_kink_is_half_the_difference_of_the_slopes() {
        let at = estimate(&Ramp(0.0), &[0.0], &Options::default());
        assert!(
            (at.jacobian[0] - 2.5).abs() < OTHER_ALGORITHM,
            "{}",
            at.jacobian
        );
        assert!((at.error[0] - 1.5).abs() < 1e-6, "{}", at.error);
        assert!(
            (at.jacobian[1] - 1.0).abs() < 1e-10 && at.error[1] < OTHER_ALGORITHM,
            "{at:?}"
        );
    }

    #[test]
    fn slopes_beside_a_kink_are_those_of_their_side_or_the_error_says_so() {
        for distance in [1e-2, 1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-12] {
            for (place, slope) in [(distance, 1.0), (-distance, 4.0)] {
                let at = estimate(&Ramp(place), &[0.0], &Options::default());
                let (off, error) = ((at.jacobian[0] - slope).abs(), at.error[0]);
                assert!(off <= 2.0 * error, "{place}: off by {off}, said {error}");
                let trusted = distance < 1e-6 || error < 1e-6;
                assert!(trusted, "{place}: error {error}");
            }
        }
    }

    #[test]
    fn what_is_not_finite_has_an_infinite_error() {
        for x in [f64::INFINITY, f64::NAN] {
            let at = estimate(&Wiggle, &[x], &Options::default());
            assert_eq!(at.error[0], f64::INFINITY, "{x}: {}", at.jacobian);
        }
    }
}
