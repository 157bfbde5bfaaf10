//! First derivatives by dual numbers, several directions at a time.

use super::{Dual, VectorFunction, seed};
use nalgebra::{DMatrix, DVector};

pub use crate::scalar::CHUNK;

/// Working memory of [`jacobian_into`]: inputs and outputs on dual numbers of width `N`.
#[derive(Clone, Debug)]
pub struct JacobianScratch<const N: usize> {
    x: Vec<Dual<f64, N>>,
    y: Vec<Dual<f64, N>>,
}

impl<const N: usize> JacobianScratch<N> {
    /// Memory for a function of `n_inputs` and `n_outputs`.
    pub fn new(n_inputs: usize, n_outputs: usize) -> Self {
        Self {
            x: vec![Dual::from(0.0); n_inputs],
            y: vec![Dual::from(0.0); n_outputs],
        }
    }
}

/// Computes the Jacobian at `x`, outputs × inputs, exact to rounding. Allocates.
///
/// * `x` – the inputs, as many as `f` takes
///
/// The example of [`VectorFunction`] makes one.
pub fn jacobian<F: VectorFunction>(f: &F, x: &[f64]) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(f.n_outputs(), x.len());
    let mut scratch = JacobianScratch::<CHUNK>::new(x.len(), f.n_outputs());
    jacobian_into(x, |x, y| f.eval(x, y), &mut scratch, &mut out);
    out
}

/// Computes the gradient of a function of one output at `x`, exact to rounding. Allocates.
///
/// * `x` – the inputs, as many as `f` takes
///
/// # Panics
/// If the function has not exactly one output.
///
/// # Examples
/// ```
/// # use dualbody::{Scalar, autodiff::{VectorFunction, gradient}};
/// # struct Product;
/// # impl VectorFunction for Product {
/// #     fn n_outputs(&self) -> usize { 1 }
/// #     fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) { y[0] = x[0] * x[0] * x[1]; }
/// # }
/// // x² y at (3, 5)
/// assert_eq!(gradient(&Product, &[3.0, 5.0]).as_slice(), [30.0, 9.0]); // 2 x y, x²
/// ```
pub fn gradient<F: VectorFunction>(f: &F, x: &[f64]) -> DVector<f64> {
    assert_eq!(
        f.n_outputs(),
        1,
        "a gradient needs a function with one output"
    );
    DVector::from_column_slice(jacobian(f, x).as_slice())
}

/// Fills `out` with the Jacobian of `f` at `x`, in ⌈n / N⌉ evaluations, without allocating anything itself.
///
/// * `f(x, y)` – the function on dual numbers
/// * `out` – output, outputs × inputs
///
/// # Panics
/// If scratch or output have the wrong size.
pub fn jacobian_into<const N: usize>(
    x: &[f64],
    mut f: impl FnMut(&[Dual<f64, N>], &mut [Dual<f64, N>]),
    scratch: &mut JacobianScratch<N>,
    out: &mut DMatrix<f64>,
) {
    assert_eq!(
        (scratch.y.len(), scratch.x.len()),
        out.shape(),
        "the Jacobian is outputs × inputs"
    );
    assert_eq!(
        x.len(),
        scratch.x.len(),
        "the scratch is for {} inputs",
        scratch.x.len()
    );
    for first in (0..x.len()).step_by(N) {
        let values = scratch.x.iter_mut().zip(x);
        values.for_each(|(out, &x)| *out = Dual::from(x));
        seed(&mut scratch.x, &(first..first + N), 1.0);
        f(&scratch.x, &mut scratch.y);
        for (row, y) in scratch.y.iter().enumerate() {
            for column in first..x.len().min(first + N) {
                out[(row, column)] = y.eps[column - first];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Scalar;
    use crate::tests::SAME_ALGEBRA;

    /// y₀ = Π xᵢ,  y₁ = Σ (i + 1) xᵢ².
    struct ProductAndSquares;
    impl VectorFunction for ProductAndSquares {
        fn n_outputs(&self) -> usize {
            2
        }
        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            y[0] = x.iter().fold(T::one(), |product, &x| product * x);
            let squares = x.iter().enumerate().map(|(i, &x)| x * x * (i as f64 + 1.0));
            y[1] = squares.fold(T::zero(), |sum, x| sum + x);
        }
    }

    fn inputs(n: usize) -> Vec<f64> {
        (0..n).map(|i| 0.7 + 0.1 * i as f64).collect()
    }

    // ∂y₀/∂xⱼ = y₀ / xⱼ,  ∂y₁/∂xⱼ = 2 (j + 1) xⱼ
    fn expected(x: &[f64]) -> DMatrix<f64> {
        let product: f64 = x.iter().product();
        DMatrix::from_fn(2, x.len(), |row, j| match row {
            0 => product / x[j],
            _ => 2.0 * (j as f64 + 1.0) * x[j],
        })
    }

    #[test]
    fn jacobian_equals_the_closed_form_for_full_and_partial_chunks() {
        for n in 0..=2 * CHUNK + 1 {
            let x = inputs(n);
            let error = jacobian(&ProductAndSquares, &x) - expected(&x);
            assert!(error.iter().all(|e| e.abs() < SAME_ALGEBRA), "{n}: {error}");
        }
    }

    fn by_chunks_of<const N: usize>(x: &[f64]) -> DMatrix<f64> {
        let mut scratch = JacobianScratch::<N>::new(x.len(), 2);
        let mut out = DMatrix::from_element(2, x.len(), f64::NAN);
        let f = |x: &[Dual<f64, N>], y: &mut [Dual<f64, N>]| ProductAndSquares.eval(x, y);
        jacobian_into(x, f, &mut scratch, &mut out);
        // Once more: nothing is left of the first call.
        jacobian_into(x, f, &mut scratch, &mut out);
        out
    }

    #[test]
    fn width_of_chunks_does_not_change_a_bit() {
        let x = inputs(7);
        let one_by_one = by_chunks_of::<1>(&x);
        assert_eq!(by_chunks_of::<3>(&x), one_by_one);
        assert_eq!(by_chunks_of::<7>(&x), one_by_one);
        assert_eq!(by_chunks_of::<16>(&x), one_by_one);
    }

    #[test]
    #[should_panic(expected = "a gradient needs a function with one output")]
    fn gradient_of_two_outputs_is_refused() {
        gradient(&ProductAndSquares, &[1.0]);
    }

    #[test]
    #[should_panic(expected = "the scratch is for 2 inputs")]
    fn scratch_of_another_size_is_refused() {
        let mut scratch = JacobianScratch::<CHUNK>::new(2, 1);
        let mut out = DMatrix::zeros(1, 2);
        jacobian_into(&[1.0], |x, y| y[0] = x[0], &mut scratch, &mut out);
    }
}
