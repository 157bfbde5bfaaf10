//! Constraint rows of the force problem: Jacobian, reference accelerations, and compliance.

use super::dense_rows::{Added, DenseRows};
use super::force_solver::ForceSolver;
use super::island::Start;
use super::islands::Islands;
use super::sparse_rows::SparseRows;
use crate::cone::{Block, Certificate, ConeProblem, Law};
use crate::dynamics::{MassMatrixFactor, trees};
use crate::linalg::product::dot;
use crate::model::Model;
use crate::scalar::{GROUP, Linear, Scalar};

/// Rows  y = G f + J a − reference, block after block.
#[derive(Clone, Debug)]
pub(crate) struct Rows<T> {
    nv: usize,
    /// Number of rows.
    count: usize,
    /// J, X and G; in a world of several trees J and X for derivatives alone.
    dense: DenseRows<T>,
    references: Vec<T>,
    blocks: Vec<Block>,
    friction: Vec<T>,
    regularization: Vec<T>,
    offset: Vec<T>,
    forces: Vec<T>,
    /// J and X of a world of several trees.
    sparse: Option<Box<SparseRows<T>>>,
    /// Acceleration by turning axes there.
    turned: Vec<T>,
    islands: Islands,
    /// Start of the next solution.
    start: Start,
    start_forces: Vec<T>,
}

/// A number of rows and blocks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mark {
    rows: usize,
    blocks: usize,
}

impl<T: Scalar> Rows<T> {
    /// Memory for so many.
    pub(super) fn new<P: Scalar>(model: &Model<P>, rows: usize, blocks: usize) -> Self {
        let nv = model.nv();
        let trees = trees(model);
        // Recorded numbers have no known zeros.
        let are_several = T::HAS_VALUES && trees.iter().any(|&first| first > 0);
        Self {
            nv,
            sparse: are_several.then(|| Box::new(SparseRows::new(&trees))),
            turned: Vec::new(),
            islands: Islands::default(),
            start: Start::Nothing,
            start_forces: Vec::new(),
            count: 0,
            dense: DenseRows::new(nv, if are_several { 0 } else { rows }),
            references: Vec::with_capacity(rows),
            blocks: Vec::with_capacity(blocks),
            friction: Vec::with_capacity(blocks),
            regularization: Vec::with_capacity(rows),
            offset: Vec::with_capacity(rows),
            forces: Vec::with_capacity(rows),
        }
    }

    pub(super) fn clear(&mut self) {
        self.count = 0;
        self.start = Start::Nothing;
        self.dense.truncate(0);
        if let Some(sparse) = &mut self.sparse {
            sparse.truncate(0);
        }
        self.references.clear();
        self.blocks.clear();
        self.friction.clear();
        self.regularization.clear();
        self.forces.clear();
    }

    /// Mark at the present number of rows and blocks.
    pub(super) fn mark(&self) -> Mark {
        Mark {
            rows: self.count,
            blocks: self.blocks.len(),
        }
    }

    /// Takes back what came after a mark.
    pub(super) fn truncate(&mut self, to: Mark) {
        self.count = to.rows;
        self.dense.truncate(to.rows);
        if let Some(sparse) = &mut self.sparse {
            sparse.truncate(to.rows);
        }
        self.references.truncate(to.rows);
        self.regularization.truncate(to.rows);
        self.blocks.truncate(to.blocks);
        self.friction.truncate(to.blocks);
    }

    /// Whether they are those of a world of several trees.
    pub(super) fn are_sparse(&self) -> bool {
        self.sparse.is_some()
    }

    /// Sets the forces from which the next solution starts, after so many rows without any.
    pub(super) fn start_from(&mut self, start: Start, mark: Mark, forces: impl Iterator<Item = T>) {
        self.start = start;
        self.start_forces.clear();
        self.start_forces.resize(mark.rows, T::zero());
        self.start_forces.extend(forces);
    }

    /// More rows of zeros, to be filled: they act on the same bodies or coordinates.
    pub(super) fn grow(&mut self, rows: usize) -> NewRows<'_, T> {
        let first = self.count;
        self.count += rows;
        match &mut self.sparse {
            None => NewRows::Dense(self.nv, self.dense.grow(first..self.count)),
            Some(sparse) => {
                sparse.grow(rows);
                NewRows::Sparse(rows, sparse)
            }
        }
    }

    /// So many more rows, all of whose entries are given, row by row. A robot without freedom has rows without entries.
    pub(super) fn push_dense(&mut self, rows: usize, entries: &[T]) {
        if self.sparse.is_none() {
            for row in 0..rows {
                let (own, marks) = self.dense.grow(self.count..self.count + 1);
                marks.fill(true);
                own.copy_from_slice(&entries[self.nv * row..][..self.nv]);
                self.count += 1;
            }
            return;
        }
        for row in entries.chunks_exact(self.nv.max(1)) {
            let mut own = self.grow(1);
            let entries = row.iter().enumerate().filter(|(_, x)| !x.is_zero());
            entries.for_each(|(k, &x)| own.add(k, x));
        }
    }

    /// A row with a single entry.
    pub(super) fn push_unit(&mut self, k: usize, entry: f64) {
        self.grow(1).add(k, T::constant(entry));
    }

    /// Sets the reference acceleration (m/s² or rad/s²) and the regularisation R of the next row that has been added.
    pub(super) fn push_reference(&mut self, reference: T, compliance: T) {
        self.references.push(reference);
        self.regularization.push(compliance);
    }

    /// Adds a block of rows.
    ///
    /// * `friction` – that of a cone, the bound of an interval
    pub(super) fn push_block(&mut self, block: Block, friction: T) {
        self.blocks.push(block);
        self.friction.push(friction);
    }

    /// Number of rows that have a reference acceleration.
    pub(super) fn n_references(&self) -> usize {
        self.references.len()
    }

    /// Number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// G, and J M⁻¹ τ for the forces τ along the coordinates.
    ///
    /// With M = Lᵀ D L and Lᵀ X = Jᵀ, which keeps the zeros of J,  G = Xᵀ D⁻¹ X: half of each solution is enough.
    pub(super) fn form_delassus(&mut self, factor: &MassMatrixFactor<T>, tau: &[T]) {
        match &mut self.sparse {
            None => (self.dense).form(factor, self.count, tau, &mut self.offset),
            Some(sparse) => {
                sparse.form(factor, tau, &mut self.offset);
                self.turned.clear();
                self.turned.resize(self.nv, T::zero());
            }
        }
    }

    /// Number of rows.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Writes J and X for derivatives, and readies the solver for them, in a world of several trees.
    pub(super) fn prepare_slopes(&mut self, law: Law, solver: &mut ForceSolver<T>) {
        if let Some(sparse) = &self.sparse {
            self.dense.take(sparse, self.count);
            solver.prepare_slopes(&self.problem(law), sparse);
        }
    }

    /// J of a coordinate times the forces of the rows.
    pub(super) fn force_along(&self, k: usize) -> impl Iterator<Item = (T, T)> + '_ {
        let forces = self.forces.iter().enumerate();
        forces.map(move |(row, &f)| match &self.sparse {
            None => (self.dense.entry(row, k), f),
            Some(sparse) => (sparse.entry(row, k), f),
        })
    }

    /// The entries of J in so many first rows, in sequence; in a world of several trees once derivatives are prepared.
    pub(crate) fn first_rows(&self, rows: usize) -> &[T] {
        self.dense.first_rows(rows)
    }

    /// X with Lᵀ X = Jᵀ, for each group of rows: their entries for each coordinate. Entries after the last row are not rows.
    pub(crate) fn halves(&self) -> impl Iterator<Item = &[[T; GROUP]]> {
        self.dense.halves()
    }

    /// X of one row, coordinate after coordinate.
    pub(crate) fn half(&self, row: usize) -> impl Iterator<Item = T> {
        self.dense.half(row)
    }

    /// The forces of the last solution.
    pub(crate) fn forces(&self) -> &[T] {
        &self.forces
    }

    /// `G_ii`.
    pub(crate) fn delassus(&self, row: usize) -> T {
        match &self.sparse {
            None => self.dense.matrix()[row * (self.count + 1)],
            Some(sparse) => sparse.delassus(row),
        }
    }

    /// n M⁻¹ nᵀ of a row n under a matrix M of which the factors are given.
    pub(super) fn delassus_of(
        &self,
        factor: &MassMatrixFactor<T>,
        row: usize,
        memory: &mut Vec<T>,
    ) -> T {
        match &self.sparse {
            None => self.dense.delassus_of(factor, row, memory),
            Some(sparse) => sparse.delassus_of(factor, row, memory),
        }
    }

    /// All rows see another acceleration, by `x` along the coordinate `k`.
    pub(super) fn turn(&mut self, k: usize, x: T) {
        match self.sparse {
            None => self.dense.turn(k, x, &mut self.offset),
            Some(_) => self.turned[k] += x,
        }
    }

    /// J `a_free` − reference.
    pub(super) fn subtract_references(&mut self) {
        if let Some(sparse) = &self.sparse {
            let rows = self.offset.iter_mut().enumerate();
            rows.for_each(|(row, offset)| *offset += sparse.dot(row, &self.turned));
        }
        let rows = self.offset.iter_mut().zip(&self.references);
        rows.for_each(|(offset, &reference)| *offset -= reference);
    }

    /// Finds the forces f for which the laws hold for s f and s y, with the scale s > 0: what has a unit of force or velocity goes into the problem s times.
    pub(super) fn solve_scaled(
        &mut self,
        law: Law,
        factor: &MassMatrixFactor<T>,
        solver: &mut ForceSolver<T>,
        scale: T,
    ) -> Certificate {
        self.scale(scale);
        let certificate = self.solve(law, factor, solver);
        let back = T::one() / scale;
        self.scale(back);
        self.forces.iter_mut().for_each(|f| *f *= back);
        certificate
    }

    /// Multiplies what has a unit of force or velocity, bounds of forces among it.
    fn scale(&mut self, scale: T) {
        self.offset.iter_mut().for_each(|x| *x *= scale);
        for (&block, x) in self.blocks.iter().zip(&mut self.friction) {
            if is_bound(block, x) {
                *x *= scale;
            }
        }
    }

    /// Slope of weighted forces in the scale at 1, see [`solve_scaled`](Self::solve_scaled).
    ///
    /// * `by_velocity`, `by_friction` – weights of y and of the entries at blocks, which replace the weights of the forces
    /// * `weighted` – the forces, weighted
    pub(crate) fn by_scale(&self, by_velocity: &[T], by_friction: &[T], weighted: T) -> T {
        let mut sum = dot(by_velocity, &self.offset) - weighted;
        for ((&block, x), &weight) in self.blocks.iter().zip(&self.friction).zip(by_friction) {
            if is_bound(block, x) {
                sum += *x * weight;
            }
        }
        sum
    }

    /// Finds the forces. Without a start that is kept, a step depends only on the state, even if forces are not unique.
    pub(super) fn solve(
        &mut self,
        law: Law,
        factor: &MassMatrixFactor<T>,
        solver: &mut ForceSolver<T>,
    ) -> Certificate {
        let mut forces = std::mem::take(&mut self.forces);
        forces.clear();
        forces.resize(self.offset.len(), T::zero());
        if self.start != Start::Nothing {
            forces.copy_from_slice(&self.start_forces);
        }
        let certificate = match &self.sparse {
            None => solver.solve(&self.problem(law), &mut forces),
            Some(sparse) => {
                self.islands.find(sparse, &self.blocks);
                let (problem, islands) = (self.problem(law), &self.islands);
                let start = self.start;
                solver.solve_islands(&problem, sparse, factor, islands, start, &mut forces)
            }
        };
        self.forces = forces;
        certificate
    }

    fn problem(&self, law: Law) -> ConeProblem<'_, T> {
        ConeProblem {
            law,
            blocks: &self.blocks,
            friction: &self.friction,
            matrix: self.dense.matrix(),
            regularization: &self.regularization,
            free_velocity: &self.offset,
        }
    }

    /// See [`respond_transposed`](crate::cone::ConeSolver::respond_transposed) of the solver.
    pub(super) fn respond_transposed(
        &self,
        law: Law,
        solver: &mut ForceSolver<T>,
        weights: &mut [T],
        by_friction: &mut [T],
    ) {
        solver.respond_transposed(&self.problem(law), &self.forces, weights, by_friction);
    }

    /// See [`apply_sensitivity`](crate::cone::ConeSolver::apply_sensitivity) of the solver.
    pub(super) fn respond<'x, S: Linear<T>>(
        &self,
        law: Law,
        solver: &mut ForceSolver<T>,
        changes: impl Iterator<Item = &'x mut [S]>,
        memory: &mut Vec<S>,
    ) {
        solver.respond(&self.problem(law), &self.forces, changes, memory);
    }

    /// a = M⁻¹ (τ + Jᵀ f)
    pub(super) fn accelerations(&self, factor: &MassMatrixFactor<T>, a: &mut [T]) {
        match &self.sparse {
            None => self.dense.accelerations(factor, &self.forces, a),
            Some(sparse) => sparse.accelerations(factor, &self.forces, a),
        }
    }

    /// Sets the forces, as of a solution.
    pub(super) fn set_forces(&mut self, forces: impl Iterator<Item = T>) {
        self.forces.clear();
        self.forces.extend(forces);
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

/// Rows that have just been added.
pub(super) enum NewRows<'a, T> {
    /// The number of coordinates, and the rows.
    Dense(usize, Added<'a, T>),
    /// How many they are.
    Sparse(usize, &'a mut SparseRows<T>),
}

impl<T: Scalar> NewRows<'_, T> {
    /// Adds to an entry of the first of them.
    pub(super) fn add(&mut self, k: usize, x: T) {
        self.add_column(k, std::iter::once(x));
    }

    /// Adds to the entries of a coordinate, from the first row on.
    #[inline(always)]
    pub(super) fn add_column(&mut self, k: usize, column: impl IntoIterator<Item = T>) {
        let column = column.into_iter();
        match self {
            Self::Dense(nv, (rows, marks)) => {
                if let Some(mark) = marks.get_mut(k) {
                    *mark = true;
                }
                for (row, x) in column.enumerate() {
                    rows[*nv * row + k] += x;
                }
            }
            Self::Sparse(rows, sparse) => sparse.add(*rows, k, column),
        }
    }
}

/// Whether the bound of a block limits its force.
fn is_bound<T: Scalar>(block: Block, x: &T) -> bool {
    block == Block::Interval && !(x.has_value() && x.value(0).is_infinite())
}
