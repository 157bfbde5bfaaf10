//! Factors of a symmetric positive definite matrix over any scalar.

use super::factors::Factors;
use super::small_matrix;
use crate::scalar::Scalar;

/// A = L D Lᵀ without pivoting, as no decision may depend on a value: for a matrix that is positive definite, it needs
/// none [Golub, Van Loan 2013, section 4.1].
#[derive(Clone, Debug)]
pub(crate) struct Symmetric<T> {
    /// Columns, or by symmetry rows.
    columns: Vec<Vec<T>>,
}

impl<T> Default for Symmetric<T> {
    fn default() -> Self {
        Self {
            columns: Vec::new(),
        }
    }
}

impl<T: Scalar> Factors<T> for Symmetric<T> {
    fn start(&mut self, n: usize) {
        self.columns.clear();
        self.columns.resize(n, vec![T::zero(); n]);
    }

    fn column_mut(&mut self, j: usize) -> &mut [T] {
        &mut self.columns[j]
    }

    fn factorize(&mut self) {
        small_matrix::factorize(&mut self.columns);
    }

    fn solve(&self, x: &mut [T]) {
        small_matrix::solve(&self.columns, x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // A with 4 on the diagonal and 1 beside it.
    #[test]
    fn solution_times_the_matrix_is_the_right_side() {
        let n = 5;
        let entry =
            |i: usize, j: usize| f64::from(4 * u8::from(i == j) + u8::from(i.abs_diff(j) == 1));
        let mut factors = Symmetric::default();
        factors.start(n);
        for j in 0..n {
            (0..n).for_each(|i| factors.column_mut(j)[i] = entry(i, j));
        }
        factors.factorize();
        let right = [1.0, -2.0, 0.5, 3.0, -1.0];
        let mut x = right;
        factors.solve(&mut x);
        for (i, b) in right.into_iter().enumerate() {
            let product: f64 = (0..n).map(|j| entry(i, j) * x[j]).sum();
            assert!((product - b).abs() < 1e-14);
        }
    }
}
