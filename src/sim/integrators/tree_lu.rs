//! LU factorisation of matrices that have the zeros of the tree and no symmetry.

#![expect(non_snake_case, reason = "A: monogram notation, see the conventions")]

use crate::dynamics::{Ancestors, TreeMatrix};
use crate::model::Model;
use crate::scalar::{Linear, Scalar};

/// Factors of a matrix with entries only where one joint is an ancestor of the other, A = U L with U unit upper and L
/// lower triangular, from the leaves to the world without pivoting: no zero is lost.
///
/// # References
/// [Featherstone 2005], without the symmetry.
#[derive(Clone, Debug)]
pub(super) struct TreeLu<T> {
    /// L on and below the diagonal, U above it.
    factors: TreeMatrix<T>,
    /// Ancestors of each coordinate, nearest first, one list after the other.
    ancestors: Vec<usize>,
    /// Start of the list of each coordinate, and the end of the last.
    starts: Vec<usize>,
}

impl<T: Scalar> TreeLu<T> {
    /// Makes memory for a model.
    pub(super) fn new<P: Scalar>(model: &Model<P>) -> Self {
        let Ancestors { lists, starts, .. } = Ancestors::of(model);
        Self {
            factors: TreeMatrix::zeros(model),
            ancestors: lists,
            starts,
        }
    }

    /// Factorises the matrix with the entries (row, column) that `entry` gives.
    pub(super) fn factorize(&mut self, entry: impl Fn(usize, usize) -> T) {
        let Self {
            factors: A,
            ancestors,
            starts,
        } = self;
        let of = |k: usize| &ancestors[starts[k]..starts[k + 1]];
        for k in 0..A.size() {
            A[(k, k)] = entry(k, k);
            for &i in of(k) {
                A[(i, k)] = entry(i, k);
                A[(k, i)] = entry(k, i);
            }
        }
        for k in (0..A.size()).rev() {
            let own = of(k);
            let reciprocal = T::one() / A[(k, k)];
            for &i in own {
                // A_ij −= A_ik A_kj / A_kk
                let ratio = A[(i, k)] * reciprocal;
                A[(i, k)] = ratio;
                for &j in own {
                    let product = ratio * A[(k, j)];
                    A[(i, j)] -= product;
                }
            }
        }
    }

    /// Solves A x = b in place: `x` holds b (length `nv`) and becomes the solution. Over lanes, for several right-hand
    /// sides.
    pub(super) fn solve<S: Linear<T>>(&self, x: &mut [S]) {
        for k in (0..x.len()).rev() {
            let known = x[k];
            for &i in self.ancestors_of(k) {
                x[i] = (-known).times_plus(self.factors[(i, k)], x[i]);
            }
        }
        for k in 0..x.len() {
            let mut sum = x[k];
            for &j in self.ancestors_of(k) {
                sum = (-x[j]).times_plus(self.factors[(k, j)], sum);
            }
            x[k] = sum * (T::one() / self.factors[(k, k)]);
        }
    }

    /// Solves Aᵀ x = b in place: `x` holds b (length `nv`) and becomes the solution.
    pub(super) fn solve_transposed(&self, x: &mut [T]) {
        for k in (0..x.len()).rev() {
            let known = x[k] / self.factors[(k, k)];
            x[k] = known;
            for &j in self.ancestors_of(k) {
                x[j] = (-known).mul_add(self.factors[(k, j)], x[j]);
            }
        }
        for k in 0..x.len() {
            let mut sum = x[k];
            for &i in self.ancestors_of(k) {
                sum = (-x[i]).mul_add(self.factors[(i, k)], sum);
            }
            x[k] = sum;
        }
    }

    /// Ancestors of a coordinate, nearest first: with it and them are all entries.
    pub(super) fn ancestors_of(&self, k: usize) -> &[usize] {
        &self.ancestors[self.starts[k]..self.starts[k + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{coriolis_matrix, mass_matrix};
    use crate::model::samples;
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    #[test]
    fn solutions_equal_those_of_dense_elimination_with_pivots() {
        for seed in 0..20 {
            let model = samples::random_tree(3 + seed as usize % 9, seed);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let q = model.random_configuration(&mut rng);
            let v = model.random_velocity(&mut rng, 3.0);
            let c = coriolis_matrix(&model, q.as_slice(), v.as_slice());
            let A = mass_matrix(&model, q.as_slice()) + c * 0.05;
            let mut lu = TreeLu::new(&model);
            lu.factorize(|i, j| A[(i, j)]);
            let mut x = v.clone();
            lu.solve(x.as_mut_slice());
            let expected = A.clone().lu().solve(&v).unwrap();
            let error = (&x - &expected).amax() / expected.amax();
            assert!(error < 1e-10, "tree {seed}: {error:e}");
            let mut x = v.clone();
            lu.solve_transposed(x.as_mut_slice());
            let expected = A.transpose().lu().solve(&v).unwrap();
            let error = (&x - &expected).amax() / expected.amax();
            assert!(error < 1e-10, "tree {seed}, transposed: {error:e}");
        }
    }
}
