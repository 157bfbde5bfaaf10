//! Factors of equations with constraints: those of the velocity of a step, and those of the velocity at its end.

use nalgebra::DMatrix;

use crate::scalar::{Linear, Scalar};
use crate::sim::integrators::bilateral::Bilateral;
use crate::sim::integrators::tree_lu::TreeLu;
use crate::sim::simulator::Simulator;

/// Factors of  K x − Gᵀ λ = f,  D x = r.  Without constraints, of K x = f.
#[derive(Clone, Debug)]
pub(super) struct Saddle<T> {
    matrix: TreeLu<T>,
    rows: Bilateral<T>,
}

impl<T: Scalar> Saddle<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let model = simulator.model();
        Self {
            matrix: TreeLu::new(model),
            rows: Bilateral::new(simulator.bilateral_rows(), model.nv()),
        }
    }

    /// Takes K, which has the zeros of the tree, and D and G, row by row.
    pub(super) fn factorize(&mut self, k: &DMatrix<T>, d: &[T], g: &[T]) {
        self.matrix.factorize(|i, j| k[(i, j)]);
        self.rows.factorize(&self.matrix, d, g);
    }

    /// f becomes x, and r becomes λ.
    pub(super) fn solve<S: Linear<T>>(&self, x: &mut [S], rows: &mut [S]) {
        self.matrix.solve(x);
        self.rows.solve(x, rows);
    }

    /// Weights of x become those of f, and weights of λ those of r.
    pub(super) fn solve_transposed(&self, x: &mut [T], rows: &mut [T]) {
        self.rows.solve_transposed(x, rows);
        self.matrix.solve_transposed(x);
    }
}
