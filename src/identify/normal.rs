//! Normal matrices, scaled to a diagonal of ones.

use nalgebra::{DMatrix, DVector};

/// A normal matrix N = Aᵀ A as S, whose diagonal is one, and the lengths lᵢ of the columns of A:  Nᵢₖ = lᵢ Sᵢₖ lₖ.
pub(super) struct Normal {
    pub(super) scaled: DMatrix<f64>,
    pub(super) lengths: DVector<f64>,
}

impl Normal {
    pub(super) fn new(matrix: &DMatrix<f64>) -> Self {
        let lengths = matrix.diagonal().map(f64::sqrt);
        Self {
            scaled: divided(matrix, &lengths),
            lengths,
        }
    }

    /// Mᵢₖ / (lᵢ lₖ): N⁻¹ of the inverse of S.
    pub(super) fn divide(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        divided(matrix, &self.lengths)
    }
}

fn divided(matrix: &DMatrix<f64>, lengths: &DVector<f64>) -> DMatrix<f64> {
    let n = lengths.len();
    DMatrix::from_fn(n, n, |i, k| matrix[(i, k)] / (lengths[i] * lengths[k]))
}
