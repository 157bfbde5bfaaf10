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
        "a Hessian is that of a function of one output"
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
