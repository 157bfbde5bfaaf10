//! Conditions on the weights of a regulator: Q symmetric positive semidefinite, R symmetric positive definite.

use std::fmt;

use nalgebra::{Cholesky, DMatrix, Dyn};

use super::doubling::symmetrized;

/// Asymmetry of a weight, its negative curvature, and the smallest pivot of R that are taken for rounding, relative to
/// the size of the weight.
const WEIGHT_TOLERANCE: f64 = 1e-12;

/// Defect that makes a weight invalid. Relative deviations up to 1e-12 are accepted as rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WeightDefect {
    /// Q differs from Qᵀ.
    StateNotSymmetric,
    /// Q has a negative eigenvalue.
    StateIndefinite,
    /// R differs from Rᵀ.
    InputNotSymmetric,
    /// R has an eigenvalue that is not positive.
    InputNotPositiveDefinite,
}

/// The Cholesky factor of R, if Q and R are valid weights.
pub(super) fn input_factor(
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<Cholesky<f64, Dyn>, WeightDefect> {
    if !is_symmetric(q) {
        return Err(WeightDefect::StateNotSymmetric);
    }
    if !is_positive_semidefinite(q) {
        return Err(WeightDefect::StateIndefinite);
    }
    if !is_symmetric(r) {
        return Err(WeightDefect::InputNotSymmetric);
    }
    positive_definite_factor(r).ok_or(WeightDefect::InputNotPositiveDefinite)
}

fn is_symmetric(m: &DMatrix<f64>) -> bool {
    m.is_empty() || (m - m.transpose()).amax() <= WEIGHT_TOLERANCE * m.amax()
}

/// Whether M + ε I has a Cholesky factor, with ε of the size of rounding.
fn is_positive_semidefinite(m: &DMatrix<f64>) -> bool {
    let n = m.nrows();
    let size = m.amax();
    let shift = DMatrix::identity(n, n) * (WEIGHT_TOLERANCE * size);
    size == 0.0 || Cholesky::new(symmetrized(m.clone()) + shift).is_some()
}

/// The Cholesky factor, if no pivot is lost against the diagonal entry it comes from.
fn positive_definite_factor(m: &DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    let factor = Cholesky::new(symmetrized(m.clone()))?;
    let pivots = factor.l_dirty().diagonal();
    let kept = |(pivot, entry): (&f64, &f64)| pivot * pivot > WEIGHT_TOLERANCE * entry;
    pivots
        .iter()
        .zip(m.diagonal().iter())
        .all(kept)
        .then_some(factor)
}

impl fmt::Display for WeightDefect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::StateNotSymmetric => "Q is not symmetric",
            Self::StateIndefinite => "Q is not positive semidefinite",
            Self::InputNotSymmetric => "R is not symmetric",
            Self::InputNotPositiveDefinite => "R is not positive definite",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::ROUNDING;
    use approx::assert_relative_eq;
    use nalgebra::dmatrix;

    fn defect(q: &DMatrix<f64>, r: &DMatrix<f64>) -> Option<WeightDefect> {
        input_factor(q, r).err()
    }

    #[test]
    fn input_factor_squared_equals_the_input_weight() {
        let r = dmatrix![2.0, 0.5; 0.5, 1.0];
        let l = input_factor(&r, &r).unwrap().l();
        assert_relative_eq!(&l * l.transpose(), r, epsilon = ROUNDING);
    }

    #[test]
    fn each_defect_is_named() {
        let one = DMatrix::identity(2, 2);
        let skewed = dmatrix![1.0, 0.1; 0.0, 1.0];
        let not_definite = Some(WeightDefect::InputNotPositiveDefinite);
        assert_eq!(defect(&skewed, &one), Some(WeightDefect::StateNotSymmetric));
        assert_eq!(defect(&one, &skewed), Some(WeightDefect::InputNotSymmetric));
        let indefinite = dmatrix![1.0, 2.0; 2.0, 1.0];
        assert_eq!(
            defect(&indefinite, &one),
            Some(WeightDefect::StateIndefinite)
        );
        assert_eq!(defect(&one, &indefinite), not_definite);
        assert_eq!(defect(&one, &dmatrix![1.0, 1.0; 1.0, 1.0]), not_definite);
        assert_eq!(defect(&one, &DMatrix::zeros(2, 2)), not_definite);
    }

    #[test]
    fn weights_with_rounding_errors_are_valid() {
        let q = dmatrix![1.0, 0.3; 0.3 * (1.0 + 1e-15), 0.09 * (1.0 - 1e-15)];
        assert_eq!(defect(&q, &DMatrix::identity(2, 2)), None);
    }

    #[test]
    fn weights_of_very_different_size_are_valid() {
        let spread = dmatrix![1e-15, 0.0; 0.0, 1e12];
        assert_eq!(defect(&spread, &spread), None);
        assert_eq!(defect(&DMatrix::zeros(2, 2), &spread), None);
    }
}
