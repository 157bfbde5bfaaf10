//! Functions to be minimised, with their derivatives.

use argmin::core::{Error, Jacobian, Operator};
use nalgebra::{DMatrix, DVector};

use super::status::Status;
use crate::autodiff::{VectorFunction, gradient, hessian, jacobian};

/// A function ℝⁿ → ℝ with its derivatives, for [`minimize`](super::minimize).
///
/// [`Differentiated`] makes one from any function over the scalar. A function with its own gradient, for example an adjoint, implements this trait.
pub trait Objective {
    /// The value; infinite or NaN where there is none.
    fn value(&self, x: &[f64]) -> f64;

    /// The gradient, length n.
    fn gradient(&self, x: &[f64]) -> DVector<f64>;

    /// The Hessian, n × n, which [`NewtonCg`](super::Minimizer::NewtonCg) and
    /// [`TrustRegion`](super::Minimizer::TrustRegion) ask for. By central differences of the gradient unless a function
    /// knows better: 2 n gradients, about 10 digits.
    fn hessian(&self, x: &[f64]) -> DMatrix<f64> {
        /// Cube root of the rounding error: where that and the error of the difference are equal.
        const STEP: f64 = 6e-6;
        let mut moved = x.to_vec();
        let mut out = DMatrix::zeros(x.len(), x.len());
        for (j, mut column) in out.column_iter_mut().enumerate() {
            let step = STEP * x[j].abs().max(1.0);
            let mut gradient_at = |by: f64| {
                moved[j] = x[j] + by;
                self.gradient(&moved)
            };
            let difference = gradient_at(step) - gradient_at(-step);
            column.copy_from(&(difference / (2.0 * step)));
            moved[j] = x[j];
        }
        let transposed = out.transpose();
        (out + transposed) * 0.5
    }

    /// [`hessian`](Self::hessian), where a function may have none.
    ///
    /// # Errors
    /// If there is none: why.
    fn try_hessian(&self, x: &[f64]) -> Result<DMatrix<f64>, Status> {
        Ok(self.hessian(x))
    }
}

/// Implements argmin's traits of a function of one output for a type and for references to it, by [`Objective`].
macro_rules! objective_for_argmin {
    ([$($generic:tt)*] $function:ty) => {
        $crate::minimize::objective_for_argmin!(@ [$($generic)*] $function);
        $crate::minimize::objective_for_argmin!(@ [$($generic)*] &$function);
    };
    (@ [$($generic:tt)*] $function:ty) => {
        impl<$($generic)*> argmin::core::CostFunction for $function {
            type Param = Vec<f64>;
            type Output = f64;

            fn cost(&self, x: &Vec<f64>) -> Result<f64, argmin::core::Error> {
                Ok($crate::minimize::Objective::value(self, x))
            }
        }

        impl<$($generic)*> argmin::core::Gradient for $function {
            type Param = Vec<f64>;
            type Gradient = Vec<f64>;

            fn gradient(&self, x: &Vec<f64>) -> Result<Vec<f64>, argmin::core::Error> {
                Ok($crate::minimize::Objective::gradient(self, x).data.into())
            }
        }

        impl<$($generic)*> argmin::core::Hessian for $function {
            type Param = Vec<f64>;
            type Hessian = Vec<Vec<f64>>;

            fn hessian(&self, x: &Vec<f64>) -> Result<Vec<Vec<f64>>, argmin::core::Error> {
                let hessian = $crate::minimize::Objective::try_hessian(self, x);
                let hessian = hessian.map_err(argmin::core::Error::msg)?;
                Ok($crate::minimize::columns_of(&hessian))
            }
        }
    };
}
pub(crate) use objective_for_argmin;

impl<F: Objective + ?Sized> Objective for &F {
    fn value(&self, x: &[f64]) -> f64 {
        (**self).value(x)
    }

    fn gradient(&self, x: &[f64]) -> DVector<f64> {
        (**self).gradient(x)
    }

    fn hessian(&self, x: &[f64]) -> DMatrix<f64> {
        (**self).hessian(x)
    }

    fn try_hessian(&self, x: &[f64]) -> Result<DMatrix<f64>, Status> {
        (**self).try_hessian(x)
    }
}

/// A function over the scalar, of one output, as an [`Objective`]: gradient and Hessian by dual numbers, exact to
/// rounding.
///
/// It also implements argmin's `CostFunction`, `Gradient` and `Hessian`, for direct use of argmin, which has no guard against functions that overflow
/// or have no minimum; [`minimize`](super::minimize) has. For functions of several outputs it implements `Operator` and `Jacobian`;
/// [`least_squares`](crate::least_squares) minimises their squares.
#[derive(Clone, Copy, Debug)]
pub struct Differentiated<F>(pub F);

impl<F: VectorFunction> Objective for Differentiated<F> {
    fn value(&self, x: &[f64]) -> f64 {
        let mut y = [0.0];
        self.0.eval(x, &mut y);
        y[0]
    }

    fn gradient(&self, x: &[f64]) -> DVector<f64> {
        gradient(&self.0, x)
    }

    fn hessian(&self, x: &[f64]) -> DMatrix<f64> {
        hessian(&self.0, x).hessian
    }
}

objective_for_argmin!([F: VectorFunction] Differentiated<F>);

impl<F: VectorFunction> Operator for Differentiated<F> {
    type Param = Vec<f64>;
    type Output = Vec<f64>;

    fn apply(&self, x: &Vec<f64>) -> Result<Vec<f64>, Error> {
        let mut y = vec![0.0; self.0.n_outputs()];
        self.0.eval(x, &mut y);
        Ok(y)
    }
}

impl<F: VectorFunction> Jacobian for Differentiated<F> {
    type Param = Vec<f64>;
    /// Row by row.
    type Jacobian = Vec<Vec<f64>>;

    fn jacobian(&self, x: &Vec<f64>) -> Result<Vec<Vec<f64>>, Error> {
        Ok(columns_of(&jacobian(&self.0, x).transpose()))
    }
}

/// The columns of a matrix, as argmin takes it.
pub(crate) fn columns_of(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let columns = matrix.column_iter();
    columns
        .map(|column| column.iter().copied().collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Scalar;
    use crate::tests::FINITE_DIFFERENCE;

    /// sin(x y) + x³
    struct Wave;

    impl VectorFunction for Wave {
        fn n_outputs(&self) -> usize {
            1
        }
        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            y[0] = (x[0] * x[1]).sin_cos().0 + x[0] * x[0] * x[0];
        }
    }

    /// [`Wave`] with the gradient alone.
    struct WaveWithoutHessian;

    impl Objective for WaveWithoutHessian {
        fn value(&self, x: &[f64]) -> f64 {
            Differentiated(Wave).value(x)
        }
        fn gradient(&self, x: &[f64]) -> DVector<f64> {
            Objective::gradient(&Differentiated(Wave), x)
        }
    }

    /// (x², x y)
    struct Products;

    impl VectorFunction for Products {
        fn n_outputs(&self) -> usize {
            2
        }
        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            (y[0], y[1]) = (x[0] * x[0], x[0] * x[1]);
        }
    }

    #[test]
    fn several_outputs_have_values_and_a_jacobian_row_after_row() {
        let (of, x) = (Differentiated(Products), vec![3.0, 5.0]);
        assert_eq!(of.apply(&x).expect("values"), [9.0, 15.0]);
        let rows = Jacobian::jacobian(&of, &x).expect("a Jacobian");
        assert_eq!(rows, [[6.0, 0.0], [5.0, 3.0]]);
    }

    #[test]
    fn hessian_by_differences_equals_the_exact_one() {
        let x = [0.7, -1.3];
        let exact = Objective::hessian(&Differentiated(Wave), &x);
        let differences = WaveWithoutHessian.hessian(&x);
        assert!((exact - differences).amax() < FINITE_DIFFERENCE);
    }
}
