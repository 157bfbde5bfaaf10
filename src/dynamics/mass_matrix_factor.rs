//! Factorisation of the mass matrix that keeps the zeros of the tree.

use nalgebra::DMatrix;

use crate::model::Model;
use crate::model::manifold::v_range;
use crate::scalar::Scalar;

/// The factors of M = Lᵀ D L, L unit lower triangular with a non-zero only where one joint carries the other.
///
/// Solves  M x = b  without forming an inverse, in O(nv · depth) an M and a right-hand side.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::{MassMatrixFactor, mass_matrix}, model::samples};
///
/// let model = samples::arm();
/// let m = mass_matrix(&model, &[0.1; 7]);
/// let mut x = [1.0; 7];
/// MassMatrixFactor::new(&model, &m).solve(&mut x);
/// let b = &m * nalgebra::DVector::from_column_slice(&x);
/// assert!(b.iter().all(|b| (b - 1.0).abs() < 1e-10));
/// ```
///
/// # References
/// [Featherstone 2005]; [Featherstone 2008, table 6.3].
#[derive(Clone, Debug)]
pub struct MassMatrixFactor<T> {
    /// L below the diagonal, D on it.
    factors: DMatrix<T>,
    /// The coordinate that carries each coordinate next.
    carrier: Vec<Option<usize>>,
}

impl<T: Scalar> MassMatrixFactor<T> {
    /// Factorises a mass matrix of the model. Allocates.
    ///
    /// A matrix that is not positive definite gives factors that are not finite or not positive.
    ///
    /// # Panics
    /// If the matrix is not `nv` × `nv`.
    pub fn new<P: Scalar>(model: &Model<P>, mass_matrix: &DMatrix<T>) -> Self {
        let mut factor = Self {
            factors: DMatrix::zeros(model.nv(), model.nv()),
            carrier: carriers(model),
        };
        factor.refactor(mass_matrix);
        factor
    }

    /// Factorises another mass matrix of the same model, without allocation.
    ///
    /// # Panics
    /// If the matrix is not `nv` × `nv`.
    pub fn refactor(&mut self, mass_matrix: &DMatrix<T>) {
        self.factors.copy_from(mass_matrix);
        let m = &mut self.factors;
        for k in (0..self.carrier.len()).rev() {
            let mut at_i = self.carrier[k];
            while let Some(i) = at_i {
                let ratio = m[(k, i)] / m[(k, k)];
                let mut at_j = Some(i);
                while let Some(j) = at_j {
                    let change = ratio * m[(k, j)];
                    m[(i, j)] -= change;
                    at_j = self.carrier[j];
                }
                m[(k, i)] = ratio;
                at_i = self.carrier[i];
            }
        }
    }

    /// Solves M x = b in place: `x` holds b (length `nv`) and becomes the solution.
    ///
    /// # Panics
    /// If `x` has the wrong length.
    pub fn solve(&self, x: &mut [T]) {
        assert_eq!(
            x.len(),
            self.carrier.len(),
            "a right-hand side has nv entries"
        );
        // Lᵀ y = b, from the tips
        for i in (0..x.len()).rev() {
            let mut at = self.carrier[i];
            while let Some(j) = at {
                let change = self.factors[(i, j)] * x[i];
                x[j] -= change;
                at = self.carrier[j];
            }
        }
        // D z = y
        for (i, x) in x.iter_mut().enumerate() {
            *x /= self.factors[(i, i)];
        }
        // L x = z, from the world
        for i in 0..x.len() {
            let mut at = self.carrier[i];
            while let Some(j) = at {
                let change = self.factors[(i, j)] * x[j];
                x[i] -= change;
                at = self.carrier[j];
            }
        }
    }
}

/// For each velocity coordinate the one before it on the way to the world: in its own joint, else the last of the parent's.
///
/// A follower ties branches together, so with followers every coordinate counts as carrying the next.
fn carriers<P: Scalar>(model: &Model<P>) -> Vec<Option<usize>> {
    if model.has_coupling() {
        return (0..model.nv()).map(|k| k.checked_sub(1)).collect();
    }
    let mut out = vec![None; model.nv()];
    for body in model.bodies() {
        let below = body.parent.map(|p| v_range(model.body(p)).end - 1);
        for k in v_range(body) {
            out[k] = if k == body.v { below } else { Some(k - 1) };
        }
    }
    out
}
