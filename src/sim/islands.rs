//! Islands of rows: groups of trees of joints that no row connects.
//!
//! G = J M⁻¹ Jᵀ then has a block for each such island, and the forces of each are a problem of their own: the cost is that of the islands, not that of all
//! rows together. A robot is one tree, and one island.

use super::sparse_rows::SparseRows;
use crate::cone::Block;
use crate::nested::IntoNested;
use crate::scalar::Scalar;

/// The islands of the rows of an instant.
#[derive(Clone, Debug, Default)]
pub(super) struct Islands {
    /// Another tree with which rows connect each tree, or itself; then the island of each.
    joined: Vec<usize>,
    /// Island of each block.
    of_blocks: Vec<usize>,
    count: usize,
}

impl Islands {
    /// Finds the islands of rows.
    pub(super) fn find<T: Scalar>(&mut self, rows: &SparseRows<T>, blocks: &[Block]) {
        self.joined.clear();
        self.joined.extend(0..rows.n_trees());
        self.of_blocks.clear();
        let mut row = 0;
        for block in blocks {
            let mut own = None;
            for tree in (row..row + block.rows()).nested(|row| rows.trees_of(row)) {
                own = Some(self.join(own.unwrap_or(tree), tree));
            }
            row += block.rows();
            self.of_blocks.push(own.unwrap_or(0));
        }
        self.number();
    }

    /// Number of islands.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Island of each block, from zero in the order of the blocks.
    pub(super) fn of_blocks(&self) -> &[usize] {
        &self.of_blocks
    }

    /// Joins two trees, and all that is joined with them.
    fn join(&mut self, a: usize, b: usize) -> usize {
        let (a, b) = (self.root(a), self.root(b));
        let (first, second) = (a.min(b), a.max(b));
        self.joined[second] = first;
        first
    }

    fn root(&mut self, mut tree: usize) -> usize {
        while self.joined[tree] != tree {
            // Half of the way is skipped the next time.
            self.joined[tree] = self.joined[self.joined[tree]];
            tree = self.joined[tree];
        }
        tree
    }

    /// From a tree of each block to its island, numbered from zero in the order of the blocks.
    fn number(&mut self) {
        for k in 0..self.of_blocks.len() {
            self.of_blocks[k] = self.root(self.of_blocks[k]);
        }
        let none = self.joined.len();
        self.joined.fill(none);
        self.count = 0;
        for own in &mut self.of_blocks {
            let number = &mut self.joined[*own];
            if *number == none {
                *number = self.count;
                self.count += 1;
            }
            *own = *number;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Trees {0, 1}, {2}, {3, 4}, {5}: a cone on the first two, a ray on the third, a pair of bilateral rows of which one is on the first and one on the last.
    #[test]
    fn rows_that_share_no_tree_even_through_others_are_islands_of_their_own() {
        let mut rows = SparseRows::new(&[0, 0, 2, 3, 3, 5]);
        rows.grow(3);
        for (k, column) in [
            (1, [1.0, 0.0, 0.0]),
            (0, [0.0, 1.0, 0.0]),
            (2, [0.0, 1.0, 1.0]),
        ] {
            rows.add(3, k, column.into_iter());
        }
        for k in [4, 0, 5] {
            rows.grow(1);
            rows.add(1, k, std::iter::once(1.0));
        }
        let mut islands = Islands::default();
        islands.find(&rows, &[Block::Cone, Block::Ray, Block::Free(2)]);
        assert_eq!((islands.count, &islands.of_blocks[..]), (2, &[0, 1, 0][..]));
        rows.truncate(3);
        islands.find(&rows, &[Block::Cone]);
        assert_eq!((islands.count, &islands.of_blocks[..]), (1, &[0][..]));
    }
}
