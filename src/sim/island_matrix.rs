//! G of a few rows on few trees: all its entries by groups of rows, as of a robot that is one tree.

use super::dense_rows::products;
use super::sparse_rows::SparseRows;
use crate::nested::IntoNested;
use crate::scalar::{GROUP, Scalar, TILE, vectorized};

/// Most trees: with more of them most entries of X are zero.
const FEW_TREES: usize = 4;
/// Most rows for which products one by one are as quick.
const FEW_ROWS: usize = 3;

/// Working memory.
#[derive(Clone, Debug)]
pub(super) struct IslandMatrix<T> {
    /// The trees on which the rows act, each with its first coordinate here.
    trees: Vec<(usize, usize)>,
    /// X and D⁻¹ X, filled up with zeros: for each group of rows, coordinate after coordinate.
    half: Vec<[T; GROUP]>,
    scaled: Vec<[T; GROUP]>,
    /// Number of coordinates.
    width: usize,
}

impl<T: Scalar> IslandMatrix<T> {
    pub(super) fn new() -> Self {
        Self {
            trees: Vec::new(),
            half: Vec::new(),
            scaled: Vec::new(),
            width: 0,
        }
    }

    /// Writes G of some rows, by columns. `false` where products one by one are quicker: nothing is written then.
    pub(super) fn form(&mut self, of: &SparseRows<T>, rows: &[usize], out: &mut [T]) -> bool {
        if rows.len() <= FEW_ROWS || !self.list_trees(of, rows) {
            return false;
        }
        let size = self.width * rows.len().div_ceil(GROUP);
        for x in [&mut self.half, &mut self.scaled] {
            x.clear();
            x.resize(size, [T::zero(); GROUP]);
        }
        for (i, &row) in rows.iter().enumerate() {
            of.each_half(row, |tree, k, x, scaled| {
                let mut trees = self.trees.iter();
                let first = trees.find(|own| own.0 == tree).map_or(0, |own| own.1);
                let at = self.width * (i / GROUP) + first + k;
                self.half[at][i % GROUP] = x;
                self.scaled[at][i % GROUP] = scaled;
            });
        }
        vectorized(
            #[inline(always)]
            || self.multiply(rows.len(), out),
        );
        true
    }

    /// Lists the trees of rows. `false` if there are many.
    fn list_trees(&mut self, of: &SparseRows<T>, rows: &[usize]) -> bool {
        self.trees.clear();
        self.width = 0;
        for tree in rows.iter().nested(|&row| of.trees_of(row)) {
            if self.trees.iter().all(|own| own.0 != tree) {
                self.trees.push((tree, self.width));
                self.width += of.coordinates(tree);
            }
        }
        self.trees.len() <= FEW_TREES
    }

    #[inline(always)]
    fn multiply(&self, n: usize, out: &mut [T]) {
        for first in (0..n).step_by(GROUP) {
            let scaled = &self.scaled[self.width * (first / GROUP)..][..self.width];
            for from in (first..n).step_by(GROUP) {
                let x = &self.half[self.width * (from / GROUP)..][..self.width];
                for column in (first..n.min(first + GROUP)).step_by(TILE) {
                    let tile = products(x, scaled, column - first);
                    for j in column..n.min(column + TILE) {
                        for i in j.max(from)..n.min(from + GROUP) {
                            let entry = tile[j - column][i - from];
                            (out[i + n * j], out[j + n * i]) = (entry, entry);
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{MassMatrixFactor, mass_matrix};
    use crate::model::{Mass, Object, World};
    use crate::spatial::Transform;

    // Eleven rows on three free bodies, of which each acts on one or two: the products one by one are G.
    #[test]
    fn groups_of_rows_have_the_products_of_the_rows() {
        let mut world = World::default();
        for k in 0..3 {
            let at = Transform::from_translation([f64::from(k), 0.0, 0.0].into());
            let object = Object::free(Mass::Kilograms(1.0)).at(at);
            let name = format!("ball {k}");
            world.add_sphere(&name, 0.1, &object).expect("a ball");
        }
        let model = world.build().expect("three balls");
        let mass = mass_matrix(&model, model.neutral().as_slice());
        let factor = MassMatrixFactor::new(&model, &mass);
        let first: Vec<usize> = (0..18).map(|k| k - k % 6).collect();
        let mut rows = SparseRows::<f64>::new(&first);
        for row in 0..11 {
            rows.grow(1);
            for k in 0..12 {
                let k = (6 * row + k) % 18;
                let x = ((row + 1) * (k + 1)) as f64 % 7.0 - 3.0;
                rows.add(1, k, std::iter::once(x));
            }
        }
        rows.form(&factor, &[0.0; 18], &mut Vec::new());
        let all: Vec<usize> = (0..11).collect();
        let mut found = vec![0.0; 121];
        assert!(IslandMatrix::new().form(&rows, &all, &mut found));
        for (row, found) in found.chunks_exact(11).enumerate() {
            let mut expected = [0.0; 11];
            rows.products(row, &all, &mut expected);
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() <= 1e-13 * (1.0 + expected.abs()));
            }
        }
    }
}
