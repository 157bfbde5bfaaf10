//! Derivatives of ⊕ and ⊖ in the entries of the configuration.

use nalgebra::{DMatrix, DVector};

use super::Model;
use crate::autodiff::Dual;
use crate::scalar::Scalar;

impl<P: Scalar> Model<P> {
    /// Computes the change of the entries of a configuration in tangent directions, `nq` × `nv`: the derivative of
    /// [`integrate`](Self::integrate)(q, dv) in dv at zero. So q̇ = J v. Allocates.
    ///
    /// # Panics
    /// If `q` has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::samples;
    ///
    /// let model = samples::random_tree(8, 1);
    /// let q = model.neutral();
    /// let (J, back) = (model.integrate_jacobian(q.as_slice()), model.difference_jacobian(q.as_slice()));
    /// let one = back * J; // a tangent to numbers and back
    /// assert!((0..model.nv()).all(|k| (one[(k, k)] - 1.0_f64).abs() < 1e-14));
    /// ```
    pub fn integrate_jacobian(&self, q: &[f64]) -> DMatrix<f64> {
        self.check_q(q);
        let q = seeded(q, None);
        columns(self.nq(), self.nv(), |k| {
            self.integrate(&q, &seeded(&vec![0.0; self.nv()], Some(k)))
        })
    }

    /// Computes the tangent vector of a change of the entries of a configuration, `nv` × `nq`: the derivative of
    /// [`difference`](Self::difference)(q, q1) in q1 at q. So v = J q̇ for rates that keep quaternions of unit norm. Allocates.
    ///
    /// # Panics
    /// If `q` has the wrong length.
    pub fn difference_jacobian(&self, q: &[f64]) -> DMatrix<f64> {
        self.check_q(q);
        let from = seeded(q, None);
        columns(self.nv(), self.nq(), |k| {
            self.difference(&from, &seeded(q, Some(k)))
        })
    }
}

/// Numbers of which one, if any, is the variable.
fn seeded(x: &[f64], variable: Option<usize>) -> Vec<Dual<f64, 1>> {
    let slope = |k: usize| if variable == Some(k) { 1.0 } else { 0.0 };
    let numbers = x.iter().enumerate();
    numbers.map(|(k, &x)| Dual::new(x, [slope(k)])).collect()
}

fn columns(
    rows: usize,
    count: usize,
    column: impl Fn(usize) -> DVector<Dual<f64, 1>>,
) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(rows, count);
    for (k, mut out) in out.column_iter_mut().enumerate() {
        out.copy_from(&column(k).map(|x| x.eps[0]));
    }
    out
}
