//! Eigenvalues of a square matrix that need not be symmetric.

use nalgebra::{Complex, DMatrix, DVector, Dyn, Schur};

/// QR sweeps per row before a decomposition is given up; two or three are usual.
const SWEEPS_PER_ROW: usize = 100;

/// Computes the eigenvalues of a square matrix, in no order; none where it is not finite or the iteration fails.
pub(crate) fn eigenvalues(m: DMatrix<f64>) -> Vec<Complex<f64>> {
    if m.is_empty() || m.iter().any(|x| !x.is_finite()) {
        return Vec::new();
    }
    let schur = schur(m.clone()).or_else(|| schur(reflected(&m)));
    schur.map_or_else(Vec::new, |s| {
        s.complex_eigenvalues().iter().copied().collect()
    })
}

fn schur(m: DMatrix<f64>) -> Option<Schur<f64, Dyn>> {
    let sweeps = SWEEPS_PER_ROW * m.nrows();
    Schur::try_new(m, f64::EPSILON, sweeps)
}

/// The similar matrix S M S with a reflection S. The shifts of the QR iteration stand still on some structured
/// matrices, such as cyclic permutations; mixing the coordinates breaks the tie.
fn reflected(m: &DMatrix<f64>) -> DMatrix<f64> {
    let n = m.nrows();
    let v = DVector::from_fn(n, |i, _| 1.0 / (1.0 + i as f64)).normalize();
    let s = DMatrix::identity(n, n) - &v * v.transpose() * 2.0;
    &s * m * &s
}
