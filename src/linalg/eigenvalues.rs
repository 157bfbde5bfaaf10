//! Eigenvalues of a square matrix that need not be symmetric; eigenvalues and axes of a symmetric one; singular values. All end.

use nalgebra::{Complex, DMatrix, DVector, Dyn, Matrix3, SVD, Schur, SymmetricEigen, Vector3};

/// QR sweeps per row before a decomposition is given up; two or three are usual.
const SWEEPS_PER_ROW: usize = 100;

/// Computes the eigenvalues of a square matrix, in no order; none where it is not finite or the iteration fails.
pub(crate) fn eigenvalues(m: DMatrix<f64>) -> Vec<Complex<f64>> {
    if m.is_empty() || m.iter().any(|x| !x.is_finite()) {
        return Vec::new();
    }
    let center = m.trace() / m.nrows() as f64;
    schur(m.clone())
        .or_else(|| schur(reflected(&m)))
        .or_else(|| {
            // Rounding of a multiple of the identity hides what is next to it, and the iteration finds no end there.
            let next_to_it = &m - DMatrix::from_diagonal_element(m.nrows(), m.nrows(), center);
            let found = schur(next_to_it)?;
            Some(found.into_iter().map(|z| z + center).collect())
        })
        .unwrap_or_default()
}

fn schur(m: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let sweeps = SWEEPS_PER_ROW * m.nrows();
    let found = Schur::try_new(m, f64::EPSILON, sweeps)?;
    Some(found.complex_eigenvalues().iter().copied().collect())
}

/// The similar matrix S M S with a reflection S. The shifts of the QR iteration stand still on some structured
/// matrices, such as cyclic permutations; mixing the coordinates breaks the tie.
fn reflected(m: &DMatrix<f64>) -> DMatrix<f64> {
    let n = m.nrows();
    let v = DVector::from_fn(n, |i, _| 1.0 / (1.0 + i as f64)).normalize();
    let s = DMatrix::identity(n, n) - &v * v.transpose() * 2.0;
    &s * m * &s
}

/// The singular value decomposition, with the left or right vectors that are asked for; `None` where the iteration does not end.
pub(crate) fn svd(m: DMatrix<f64>, [left, right]: [bool; 2]) -> Option<SVD<f64, Dyn, Dyn>> {
    let steps = SWEEPS_PER_ROW * m.nrows().max(m.ncols());
    m.try_svd(left, right, f64::EPSILON, steps)
}

/// Computes eigenvalues and orthonormal eigenvectors, the columns of the second, of a symmetric matrix, in no order; `None` where the iteration does not end.
pub(crate) fn symmetric_eigen(m: DMatrix<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let sweeps = SWEEPS_PER_ROW * m.nrows();
    let found = SymmetricEigen::try_new(m, f64::EPSILON, sweeps)?;
    Some((found.eigenvalues, found.eigenvectors))
}

/// The same of a 3 × 3 matrix, by the code for all sizes: a decomposition of its own would be as much code again.
pub(crate) fn symmetric_eigen3(m: &Matrix3<f64>) -> Option<(Vector3<f64>, Matrix3<f64>)> {
    let (values, vectors) = symmetric_eigen(DMatrix::from_column_slice(3, 3, m.as_slice()))?;
    Some((
        Vector3::from_column_slice(values.as_slice()),
        Matrix3::from_column_slice(vectors.as_slice()),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    // A unipotent part, as that of directions that no input reaches: I + 1e-9 N with random N.
    #[test]
    fn eigenvalues_next_to_the_identity_are_found() {
        for seed in 0..200 {
            for n in [2, 3, 6] {
                let noise = |i: usize, j: usize| ((seed * 91 + i * 17 + j * 5) as f64).sin() * 1e-9;
                let found = eigenvalues(DMatrix::identity(n, n) + DMatrix::from_fn(n, n, noise));
                assert_eq!(found.len(), n, "seed {seed}");
                assert!(found.iter().all(|z| (z - 1.0).norm() < 1e-8), "{found:?}");
            }
        }
    }
}
