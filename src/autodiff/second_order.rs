//! Second derivatives by hyper-dual numbers.

use nalgebra::{DMatrix, DVector};
use num_dual::HyperDual64;

use super::VectorFunction;

/// Value, gradient and Hessian of a function of one output.
#[derive(Clone, Debug, PartialEq)]
pub struct SecondOrder {
    /// The value.
    pub value: f64,
    /// The gradient, length n.
    pub gradient: DVector<f64>,
    /// The Hessian, n × n, symmetric.
    pub hessian: DMatrix<f64>,
}

/// Computes value, gradient and Hessian of a function of one output in n (n + 1) / 2 evaluations. Allocates.
///
/// * `x` – the inputs, as many as `f` takes
///
/// # Panics
/// If the function has not exactly one output.
///
/// # Examples
/// ```
/// # use dualbody::{Scalar, autodiff::{VectorFunction, hessian}};
/// # struct Product;
/// # impl VectorFunction for Product {
/// #     fn n_outputs(&self) -> usize { 1 }
/// #     fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) { y[0] = x[0] * x[0] * x[1]; }
/// # }
/// // x² y at (3, 5)
/// let of = hessian(&Product, &[3.0, 5.0]);
/// assert_eq!((of.value, of.gradient.as_slice()), (45.0, &[30.0, 9.0][..]));
/// assert_eq!(of.hessian.as_slice(), [10.0, 6.0, 6.0, 0.0]); // 2 y, 2 x
/// ```
///
/// # References
/// [Fike, Alonso 2011].
pub fn hessian<F: VectorFunction>(f: &F, x: &[f64]) -> SecondOrder {
    assert_eq!(
        f.n_outputs(),
        1,
        "a Hessian needs a function with one output"
    );
    let n = x.len();
    let mut seeded: Vec<HyperDual64> = x.iter().map(|&x| x.into()).collect();
    let mut y = [HyperDual64::from(0.0)];
    f.eval(&seeded, &mut y);
    let mut out = SecondOrder {
        value: y[0].re,
        gradient: DVector::zeros(n),
        hessian: DMatrix::zeros(n, n),
    };
    for i in 0..n {
        seeded[i].eps1 = 1.0;
        for k in 0..=i {
            seeded[k].eps2 = 1.0;
            f.eval(&seeded, &mut y);
            seeded[k].eps2 = 0.0;
            out.gradient[i] = y[0].eps1;
            out.hessian[(i, k)] = y[0].eps1eps2;
            out.hessian[(k, i)] = y[0].eps1eps2;
        }
        seeded[i].eps1 = 0.0;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autodiff::gradient;
    use crate::scalar::Scalar;
    use crate::tests::SAME_ALGEBRA;

    /// ½ xᵀ A x + x₀, with the symmetric matrix  `A_ij` = 1 / (i + j + 1).
    struct Quadratic;
    fn entry(i: usize, j: usize) -> f64 {
        1.0 / (i + j + 1) as f64
    }
    impl VectorFunction for Quadratic {
        fn n_outputs(&self) -> usize {
            1
        }
        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            y[0] = x[0];
            for (i, &a) in x.iter().enumerate() {
                for (j, &b) in x.iter().enumerate() {
                    y[0] += a * b * (0.5 * entry(i, j));
                }
            }
        }
    }

    #[test]
    fn hessian_of_a_quadratic_equals_its_matrix_everywhere() {
        for n in 1..6 {
            for at in [0.0, 1.5] {
                let x = vec![at; n];
                let of = hessian(&Quadratic, &x);
                let error = of.hessian - DMatrix::from_fn(n, n, entry);
                assert!(error.amax() < SAME_ALGEBRA, "{n}: {error}");
                let error = of.gradient - gradient(&Quadratic, &x);
                assert!(error.amax() < SAME_ALGEBRA, "{n}: {error}");
            }
        }
    }

    /// eˣ sin y.
    struct Wave;
    impl VectorFunction for Wave {
        fn n_outputs(&self) -> usize {
            1
        }
        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            y[0] = x[0].exp() * x[1].sin_cos().0;
        }
    }

    // f_x = f, f_y = eˣ cos y, f_xx = f, f_xy = f_y, f_yy = −f
    #[test]
    fn derivatives_of_a_growing_wave_equal_the_closed_form() {
        let (x, y) = (0.4_f64, 1.1_f64);
        let (f, f_y) = (x.exp() * y.sin(), x.exp() * y.cos());
        let of = hessian(&Wave, &[x, y]);
        assert!((of.value - f).abs() < SAME_ALGEBRA);
        assert!((of.gradient - DVector::from_vec(vec![f, f_y])).amax() < SAME_ALGEBRA);
        let expected = DMatrix::from_row_slice(2, 2, &[f, f_y, f_y, -f]);
        assert!((of.hessian - expected).amax() < SAME_ALGEBRA);
    }

    /// A function of two outputs.
    struct Pair;
    impl VectorFunction for Pair {
        fn n_outputs(&self) -> usize {
            2
        }
        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            y.fill(x[0]);
        }
    }

    #[test]
    #[should_panic(expected = "a Hessian needs a function with one output")]
    fn hessian_of_two_outputs_is_refused() {
        hessian(&Pair, &[1.0]);
    }
}
