//! The rows of a problem of forces: a Jacobian, what is wanted, and how far each gives way.

use crate::contact::cone::{Block, Certificate, ConeProblem, ConeSolver, Law};
use crate::dynamics::MassMatrixFactor;
use crate::scalar::Scalar;

/// Rows  y = G f + J a − wanted, block after block.
#[derive(Clone, Debug)]
pub(super) struct Rows<T> {
    nv: usize,
    /// How many there are.
    count: usize,
    /// J, row after row, and M⁻¹ Jᵀ, column after column: `nv` numbers each.
    jacobian: Vec<T>,
    response: Vec<T>,
    wanted: Vec<T>,
    blocks: Vec<Block>,
    friction: Vec<T>,
    /// G.
    matrix: Vec<T>,
    regularization: Vec<T>,
    offset: Vec<T>,
    forces: Vec<T>,
    /// The acceleration that rows see.
    seen: Vec<T>,
}

impl<T: Scalar> Rows<T> {
    /// Memory for so many.
    pub(super) fn new(nv: usize, rows: usize, blocks: usize) -> Self {
        Self {
            nv,
            count: 0,
            jacobian: Vec::with_capacity(rows * nv),
            response: Vec::with_capacity(rows * nv),
            wanted: Vec::with_capacity(rows),
            blocks: Vec::with_capacity(blocks),
            friction: Vec::with_capacity(blocks),
            matrix: Vec::with_capacity(rows * rows),
            regularization: Vec::with_capacity(rows),
            offset: Vec::with_capacity(rows),
            forces: Vec::with_capacity(rows),
            seen: Vec::with_capacity(nv),
        }
    }

    pub(super) fn clear(&mut self) {
        self.count = 0;
        self.jacobian.clear();
        self.wanted.clear();
        self.blocks.clear();
        self.friction.clear();
        self.regularization.clear();
    }

    /// More rows of zeros, to be filled.
    pub(super) fn grow(&mut self, rows: usize) -> &mut [T] {
        let start = self.jacobian.len();
        self.count += rows;
        self.jacobian.resize(self.count * self.nv, T::zero());
        &mut self.jacobian[start..]
    }

    /// A row with a single entry.
    pub(super) fn push_unit(&mut self, k: usize, entry: f64) {
        self.grow(1)[k] = T::constant(entry);
    }

    /// What is wanted of the next row that has been added, m/s² or rad/s², and R.
    pub(super) fn push_wanted(&mut self, wanted: T, give: T) {
        self.wanted.push(wanted);
        self.regularization.push(give);
    }

    pub(super) fn push_block(&mut self, block: Block, friction: T) {
        self.blocks.push(block);
        self.friction.push(friction);
    }

    /// How many rows know what is wanted of them.
    pub(super) fn asked(&self) -> usize {
        self.wanted.len()
    }

    pub(super) fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// M⁻¹ Jᵀ and G.
    pub(super) fn respond(&mut self, factor: &MassMatrixFactor<T>) {
        self.response.clear();
        self.matrix.clear();
        self.response.extend_from_slice(&self.jacobian);
        // Without degrees of freedom no row moves.
        let nv = self.nv.max(1);
        for column in self.response.chunks_exact_mut(nv) {
            factor.solve(column);
        }
        self.matrix.resize(self.count * self.count, T::zero());
        let columns = self.response.chunks_exact(nv).enumerate();
        for (j, column) in columns {
            let rows = self.jacobian.chunks_exact(nv).enumerate();
            for (i, row) in rows.take(j + 1) {
                let entry = product(row, column);
                self.matrix[i + self.count * j] = entry;
                self.matrix[j + self.count * i] = entry;
            }
        }
    }

    /// `G_ii`.
    pub(super) fn mobility(&self, row: usize) -> T {
        self.matrix[row * (self.count + 1)]
    }

    /// Starts offsets anew with those of the first rows, which see the acceleration `a`.
    pub(super) fn set_first_offsets(&mut self, rows: usize, a: &[T]) {
        self.offset.clear();
        self.seen.clear();
        self.seen.extend_from_slice(a);
        self.extend_offsets(0..rows);
    }

    /// The acceleration that the other rows see, to be changed.
    pub(super) fn seen_mut(&mut self) -> &mut [T] {
        &mut self.seen
    }

    /// The offsets of the rows that have none yet.
    pub(super) fn set_other_offsets(&mut self) {
        self.extend_offsets(self.offset.len()..self.wanted.len());
    }

    fn extend_offsets(&mut self, rows: std::ops::Range<usize>) {
        for i in rows {
            let row = &self.jacobian[self.nv * i..self.nv * (i + 1)];
            self.offset.push(product(row, &self.seen) - self.wanted[i]);
        }
    }

    /// Finds the forces, from nothing each time: what a step does depends on the state alone, also where forces are not unique.
    pub(super) fn solve(&mut self, law: Law, solver: &mut ConeSolver<T>) -> Certificate {
        self.forces.clear();
        self.forces.resize(self.offset.len(), T::zero());
        let problem = ConeProblem {
            law,
            blocks: &self.blocks,
            friction: &self.friction,
            matrix: &self.matrix,
            regularization: &self.regularization,
            offset: &self.offset,
        };
        solver.solve(&problem, &mut self.forces)
    }

    /// a += M⁻¹ Jᵀ f
    pub(super) fn add_accelerations(&self, a: &mut [T]) {
        let columns = self.response.chunks_exact(self.nv.max(1));
        for (column, &f) in columns.zip(&self.forces) {
            a.iter_mut().zip(column).for_each(|(a, &x)| *a += x * f);
        }
    }

    /// The forces of so many first rows.
    pub(super) fn first_forces(&self, rows: usize) -> &[T] {
        &self.forces[..rows]
    }

    /// The forces of so many last rows.
    pub(super) fn last_forces(&self, rows: usize) -> &[T] {
        &self.forces[self.forces.len() - rows..]
    }
}

fn product<T: Scalar>(a: &[T], b: &[T]) -> T {
    let zero = T::zero();
    a.iter()
        .zip(b)
        .fold(zero, |sum, (&a, &b)| a.mul_add(b, sum))
}
