//! Reachable decomposition: the part of a system that its input does not reach, found without eigenvalues.
//!
//! Rank tests at an eigenvalue λ need λ, and a chain of k equal eigenvalues (a free body: spin turns it, turned it falls
//! another way, falling it moves) is known only to the k-th root of the rounding error. The reachable subspace itself,
//! spanned by B, A B, A² B, …, has no such weakness. It is built by orthonormal blocks; what is perpendicular to it
//! evolves by itself.
//!
//! # References
//! [Van Dooren 1981].

use crate::linalg::{svd, symmetric_eigen};
use nalgebra::{Complex, DMatrix, DVector};

use super::doubling::TimeDomain;
use super::riccati::Riccati;
use super::stability;
use crate::nested::IntoNested;

/// Size of a new direction, relative to A or to B, below which it counts as rounding.
const NEW_DIRECTION: f64 = 1e-9;

/// The least stable mode of the part that the input does not reach, if that part is not stable.
pub(super) fn unreachable_mode(riccati: &Riccati) -> Option<Complex<f64>> {
    let outside = complement(&reachable_basis(&riccati.a, &riccati.b));
    let alone = outside.tr_mul(&riccati.a) * &outside;
    let modes = stability::eigenvalues(riccati.time, &alone);
    let worst = *modes.first()?;
    let scale = match riccati.time {
        TimeDomain::Discrete => 1.0,
        TimeDomain::Continuous => riccati.a.norm(),
    };
    // A chain of all these modes at the boundary would blur them by this much.
    let blur = scale * f64::EPSILON.powf(1.0 / modes.len() as f64);
    let excess = match riccati.time {
        TimeDomain::Discrete => worst.norm() - 1.0,
        TimeDomain::Continuous => worst.re,
    };
    (excess >= -blur).then_some(worst)
}

/// Computes orthonormal columns that span the reachable subspace.
pub(super) fn reachable_basis(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut basis = DMatrix::zeros(a.nrows(), 0);
    let mut block = new_directions(&basis, b.clone(), b.norm());
    while block.ncols() > 0 && basis.ncols() < a.nrows() {
        let first = basis.ncols();
        // Rounding may promise more directions than there are.
        let block_size = block.ncols().min(a.nrows() - first);
        block = block.columns(0, block_size).into_owned();
        basis = basis.resize_horizontally(first + block.ncols(), 0.0);
        basis.columns_mut(first, block.ncols()).copy_from(&block);
        block = new_directions(&basis, a * block, a.norm());
    }
    basis
}

/// Orthonormal columns that span what the candidates add to a basis.
fn new_directions(basis: &DMatrix<f64>, mut candidates: DMatrix<f64>, size: f64) -> DMatrix<f64> {
    // Twice, because the first projection leaves roundings of the size of the candidates.
    for _ in 0..2 {
        candidates -= basis * basis.tr_mul(&candidates);
    }
    let n = candidates.nrows();
    let threshold = NEW_DIRECTION * size;
    match svd(candidates, [true, false]) {
        Some(svd) => again(basis, leading(svd.u, &svd.singular_values, threshold, n)),
        None => DMatrix::zeros(n, 0),
    }
}

/// New directions once more orthonormal, to a basis and among each other: they came of what was small, so that its roundings are large beside them.
fn again(basis: &DMatrix<f64>, mut new: DMatrix<f64>) -> DMatrix<f64> {
    new -= basis * basis.tr_mul(&new);
    if new.is_empty() {
        return new;
    }
    new.qr().q()
}

/// Orthonormal columns perpendicular to a basis.
pub(super) fn complement(basis: &DMatrix<f64>) -> DMatrix<f64> {
    let n = basis.nrows();
    // The projector's eigenvalues are zero and one.
    match symmetric_eigen(DMatrix::identity(n, n) - basis * basis.transpose()) {
        Some((values, vectors)) => leading(Some(vectors), &values, 0.5, n),
        None => DMatrix::zeros(n, 0),
    }
}

/// The columns whose value is above a threshold.
fn leading(
    vectors: Option<DMatrix<f64>>,
    values: &DVector<f64>,
    threshold: f64,
    rows: usize,
) -> DMatrix<f64> {
    let columns: Vec<_> = vectors
        .iter()
        .nested(|v| v.column_iter())
        .zip(values)
        .filter(|&(_, &value)| value > threshold)
        .map(|(column, _)| column)
        .collect();
    if columns.is_empty() {
        return DMatrix::zeros(rows, 0);
    }
    DMatrix::from_columns(&columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::SAME_ALGEBRA;

    /// Two integrators in a row; the input pushes the first or none.
    fn riccati(b: [f64; 4]) -> Riccati {
        let mut a = DMatrix::identity(4, 4);
        (a[(0, 1)], a[(1, 2)], a[(2, 3)]) = (0.01, 0.01, 0.01);
        let one = nalgebra::Cholesky::new(DMatrix::identity(1, 1)).unwrap();
        let b = DMatrix::from_column_slice(4, 1, &b);
        Riccati::new(
            TimeDomain::Discrete,
            [&a, &b, &DMatrix::identity(4, 4)],
            &one,
        )
    }

    #[test]
    fn reachable_chain_has_no_unreachable_mode() {
        assert_eq!(unreachable_mode(&riccati([0.0, 0.0, 0.0, 1.0])), None);
    }

    // Pushed in the middle, the chain's fast end stays out of reach, at the eigenvalue one.
    #[test]
    fn chain_pushed_in_the_middle_keeps_its_end_out_of_reach() {
        let mode = unreachable_mode(&riccati([0.0, 0.0, 1.0, 0.0])).unwrap();
        assert!((mode - Complex::from(1.0)).norm() < SAME_ALGEBRA, "{mode}");
        assert!(unreachable_mode(&riccati([0.0; 4])).is_some());
    }
}
