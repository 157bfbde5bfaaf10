//! A matrix with a block for each tree of a forest: without joints between them, bodies have no inertia in common.
//!
//! Its memory is that of the blocks. A robot is one tree, and one block.

use std::ops::{Index, IndexMut, Range};

use nalgebra::DMatrix;

use crate::model::Model;
use crate::scalar::Scalar;

/// A square matrix over the coordinates of a model, zero between its trees.
#[derive(Clone, Debug)]
pub(crate) struct TreeMatrix<T> {
    /// The blocks by columns, one after the other.
    values: Vec<T>,
    columns: Vec<Column>,
}

/// Where the entries of a column are; side by side, so that one look finds all of it.
#[derive(Clone, Copy, Debug)]
struct Column {
    /// Index that the entry in row zero would have.
    start: usize,
    /// First row of its tree, and the one past the last.
    first: usize,
    end: usize,
}

impl Column {
    /// Indices of its entries.
    #[inline(always)]
    fn entries(self) -> Range<usize> {
        self.start + self.first..self.start + self.end
    }
}

/// Where the entries of a tree are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// Number of rows and columns.
    pub(super) size: usize,
    /// Index that the entry in row and column zero would have, which may be before the first of all.
    pub(super) offset: usize,
}

impl Block {
    /// Index of an entry of the tree. One multiplication is less than a look at the start of the column: 5 % of the composite-rigid-body algorithm.
    #[inline(always)]
    pub(super) fn index(self, row: usize, column: usize) -> usize {
        self.offset.wrapping_add(self.size * column + row)
    }
}

impl<T: Scalar> TreeMatrix<T> {
    /// Zeros.
    pub(crate) fn zeros<P: Scalar>(model: &Model<P>) -> Self {
        let (mut columns, mut before) = (Vec::new(), 0);
        for own in trees(model).chunk_by(|a, b| a == b) {
            let (first, size) = (own[0], own.len());
            let end = first + size;
            for k in 0..size {
                // The blocks before have at least as many entries as rows.
                let start = before + size * k - first;
                columns.push(Column { start, first, end });
            }
            before += size * size;
        }
        let values = vec![T::zero(); before];
        Self { values, columns }
    }

    /// Number of rows.
    #[inline(always)]
    pub(crate) fn size(&self) -> usize {
        self.columns.len()
    }

    /// All entries.
    pub(crate) fn values_mut(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// Rows of the tree of a coordinate, with the entries of its column in them.
    pub(crate) fn in_tree(&self, k: usize) -> (Range<usize>, &[T]) {
        let column = self.columns[k];
        (column.first..column.end, &self.values[column.entries()])
    }

    /// Takes the blocks of a matrix.
    pub(crate) fn copy_from(&mut self, matrix: &DMatrix<T>) {
        // One tree: a fifth of the instructions of a small robot's factors went into columns.
        if self.values.len() == matrix.len() {
            return self.values.copy_from_slice(matrix.as_slice());
        }
        for (own, from) in self.columns.iter().zip(matrix.column_iter()) {
            let from = &from.as_slice()[own.first..own.end];
            let all = self.values[own.entries()].iter_mut().zip(from);
            all.for_each(|(own, &x)| *own = x);
        }
    }

    /// Takes the entries of another matrix of the same model.
    pub(crate) fn copy_from_own(&mut self, other: &Self) {
        self.values.copy_from_slice(&other.values);
    }

    /// The entries of a column, by their rows; those before the rows of its tree are no entries.
    #[inline(always)]
    pub(crate) fn column(&self, k: usize) -> &[T] {
        let Column { start, end, .. } = self.columns[k];
        &self.values[start..start + end]
    }

    /// Rows of the tree of a coordinate, the columns of that tree before its own one, and its own one.
    #[inline(always)]
    pub(super) fn split_before(&mut self, k: usize) -> (Range<usize>, &mut [T], &mut [T]) {
        let column = self.columns[k];
        let (rows, own) = (column.first..column.end, column.entries());
        let before = rows.len() * (k - rows.start);
        let (before, own) = self.values[own.start - before..own.end].split_at_mut(before);
        (rows, before, own)
    }

    /// All entries, and where those of the tree of a coordinate are.
    pub(super) fn parts_mut(&mut self) -> (&mut [T], impl Fn(usize) -> Block) {
        let columns = &self.columns;
        let block = |k: usize| {
            let Column { start, first, end } = columns[k];
            let size = end - first;
            let offset = start.wrapping_sub(size * k);
            Block { size, offset }
        };
        (&mut self.values, block)
    }

    /// An entry, zero between trees.
    pub(crate) fn entry(&self, i: usize, j: usize) -> T {
        let Column { first, end, .. } = self.columns[j];
        match (first..end).contains(&i) {
            true => self[(i, j)],
            false => T::zero(),
        }
    }
}

/// Entries of a tree.
impl<T: Scalar> Index<(usize, usize)> for TreeMatrix<T> {
    type Output = T;

    #[inline(always)]
    fn index(&self, (i, j): (usize, usize)) -> &T {
        &self.values[self.columns[j].start + i]
    }
}

impl<T: Scalar> IndexMut<(usize, usize)> for TreeMatrix<T> {
    #[inline(always)]
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut T {
        &mut self.values[self.columns[j].start + i]
    }
}

/// First coordinate of what is connected with each one, by joints or by joints that follow others.
pub(crate) fn trees<P: Scalar>(model: &Model<P>) -> Vec<usize> {
    let mut trees: Vec<usize> = (0..model.nv()).collect();
    let root = |trees: &[usize], mut k: usize| {
        while trees[k] != k {
            k = trees[k];
        }
        k
    };
    // Of a body without coordinates those of the bodies before it.
    let mut own: Vec<Option<usize>> = Vec::with_capacity(model.n_bodies());
    for body in model.bodies() {
        let mut first = body.parent.and_then(|parent| own[parent.0]);
        for k in body.v..body.v + body.joint.nv() {
            let k = root(&trees, k);
            let other = first.map_or(k, |first| root(&trees, first));
            let (low, high) = (k.min(other), k.max(other));
            trees[high] = low;
            first = Some(low);
        }
        own.push(first);
    }
    let roots = (0..trees.len()).map(|k| root(&trees, k));
    with_what_is_between(roots.collect())
}

/// Connects what is between connected coordinates with them.
///
/// * `trees` – first coordinate of what is connected with each one
fn with_what_is_between(mut trees: Vec<usize>) -> Vec<usize> {
    for k in (1..trees.len()).rev() {
        if trees[k] < k {
            trees[k - 1] = trees[k - 1].min(trees[k]);
        }
    }
    // Of those that reach into one another the first one counts.
    for k in 0..trees.len() {
        trees[k] = trees[trees[k]];
    }
    trees
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::mass_matrix;
    use crate::model::{Mass, Object, World, samples};

    /// A world of two balls.
    fn balls() -> Model {
        let mut world = World::default();
        for name in ["a", "b"] {
            let ball = Object::free(Mass::Kilograms(1.0));
            world.add_sphere(name, 0.1, &ball).expect("a member");
        }
        world.build().expect("a world")
    }

    #[test]
    fn a_robot_is_one_tree_and_free_bodies_are_many() {
        assert!(trees(&samples::arm()).iter().all(|&first| first == 0));
        let expected: Vec<usize> = (0..12).map(|k| k / 6 * 6).collect();
        assert_eq!(trees(&balls()), expected);
    }

    // {0, 3} around {1, 2}; {1, 4} and {2, 5}, which reach into one another, around {3}.
    #[test]
    fn connected_coordinates_take_those_between_them_along() {
        assert_eq!(with_what_is_between(vec![0, 1, 1, 0]), [0; 4]);
        let chained = with_what_is_between(vec![0, 1, 2, 3, 1, 2]);
        assert_eq!(chained, [0, 1, 1, 1, 1, 1]);
    }

    #[test]
    fn entries_are_those_of_the_matrix_and_memory_is_that_of_the_blocks() {
        let model = balls();
        let q = model.neutral();
        let full = mass_matrix(&model, q.as_slice());
        let mut own = TreeMatrix::zeros(&model);
        own.copy_from(&full);
        for (i, j) in (0..12).flat_map(|i| (0..12).map(move |j| (i, j))) {
            assert_eq!(own.entry(i, j), full[(i, j)], "{i} {j}");
        }
        assert_eq!(own.values.len(), 2 * 36);
    }
}
