//! The forces of an island: in one piece, or by blocks where it has many rows.

use std::ops::Range;

use super::island_matrix::IslandMatrix;
use super::sparse_rows::SparseRows;
use crate::cone::{
    Block, BlockProblem, Certificate, Columns, ConeOptions, ConeProblem, ConeSolver, Law, Mode,
    Status,
};
use crate::dynamics::MassMatrixFactor;
use crate::scalar::{Linear, Scalar, is_more_than_values};

/// Forces from which a solution starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Start {
    /// None.
    #[default]
    Nothing,
    /// With many rows those of the last solution of this instant, which had fewer rows; else none.
    LastOfInstant,
    /// Those of the last solution.
    Last,
}

impl Start {
    /// Start of solutions after the first one.
    ///
    /// * `stay` – whether forces stay from step to step
    pub(super) fn of(stay: bool) -> Self {
        match stay {
            true => Self::Last,
            false => Self::LastOfInstant,
        }
    }
}

/// Least number of rows of an island of several trees that is solved by blocks; smaller ones are quicker in one piece.
const MANY_ROWS: usize = 48;

/// The problem of an island, with a solver for its derivatives.
///
/// One solver finds the forces of all islands: the memory of a thousand solvers does not fit a cache.
#[derive(Clone, Debug)]
pub(super) struct Island<T: Scalar> {
    rows: Vec<usize>,
    blocks: Vec<usize>,
    kinds: Vec<Block>,
    friction: Vec<T>,
    /// G, where the island is solved in one piece, or derivatives are needed.
    matrix: Vec<T>,
    products: IslandMatrix<T>,
    regularization: Vec<T>,
    free_velocity: Vec<T>,
    forces: Vec<T>,
    weights: Vec<T>,
    by_friction: Vec<T>,
    /// Regularisation that the solver added to the problem.
    added: f64,
    /// From the first derivatives on.
    solver: Option<Box<ConeSolver<T>>>,
    by_blocks: Option<Box<ByBlocks>>,
    is_by_blocks: bool,
}

/// Problems by blocks, lane by lane, and the solution of the last one.
#[derive(Clone, Debug, Default)]
struct ByBlocks {
    given: Given,
    /// That of the solution before.
    last: Given,
    nodes: Vec<usize>,
    forces: Vec<f64>,
    statuses: Vec<Status>,
    modes: Vec<Mode>,
    certificate: Certificate,
    /// As of the island.
    added: f64,
}

/// A lane of a problem by blocks.
#[derive(Clone, Debug, Default, PartialEq)]
struct Given {
    law: Law,
    options: ConeOptions,
    kinds: Vec<Block>,
    columns: Columns,
    friction: Vec<f64>,
    regularization: Vec<f64>,
    free_velocity: Vec<f64>,
}

impl Given {
    fn problem(&self) -> BlockProblem<'_> {
        BlockProblem {
            law: self.law,
            blocks: &self.kinds,
            friction: &self.friction,
            columns: &self.columns,
            regularization: &self.regularization,
            free_velocity: &self.free_velocity,
        }
    }
}

impl<T: Scalar> Island<T> {
    /// Without rows.
    pub(super) fn new() -> Self {
        Self {
            rows: Vec::new(),
            blocks: Vec::new(),
            kinds: Vec::new(),
            friction: Vec::new(),
            matrix: Vec::new(),
            products: IslandMatrix::new(),
            regularization: Vec::new(),
            free_velocity: Vec::new(),
            forces: Vec::new(),
            weights: Vec::new(),
            by_friction: Vec::new(),
            added: 0.0,
            solver: None,
            by_blocks: None,
            is_by_blocks: false,
        }
    }

    /// Forgets its rows.
    pub(super) fn clear(&mut self) {
        self.rows.clear();
        self.blocks.clear();
    }

    /// Discards the last solution.
    pub(super) fn forget(&mut self) {
        if let Some(own) = &mut self.by_blocks {
            own.given.kinds.clear();
        }
    }

    /// Adds the rows of a block.
    pub(super) fn push(&mut self, block: usize, rows: Range<usize>) {
        self.blocks.push(block);
        self.rows.extend(rows);
    }

    /// Takes its part of a problem, and of forces to start from.
    fn load(&mut self, problem: &ConeProblem<'_, T>, f: &[T]) {
        self.kinds.clear();
        (self.kinds).extend(self.blocks.iter().map(|&block| problem.blocks[block]));
        gather(&self.blocks, problem.friction, &mut self.friction);
        gather(&self.rows, problem.regularization, &mut self.regularization);
        gather(&self.rows, problem.free_velocity, &mut self.free_velocity);
        gather(&self.rows, f, &mut self.forces);
    }

    /// G of its rows.
    fn form_matrix(&mut self, rows: &SparseRows<T>) {
        let n = self.rows.len();
        self.matrix.resize(n * n, T::zero());
        if self.products.form(rows, &self.rows, &mut self.matrix) {
            return;
        }
        for i in 0..n {
            let (before, rest) = self.matrix.split_at_mut(n * i);
            rows.products(self.rows[i], &self.rows[..=i], &mut rest[..=i]);
            let column = before.iter_mut().skip(i).step_by(n.max(1));
            column.zip(&*rest).for_each(|(out, &x)| *out = x);
        }
    }

    /// Its problem.
    fn problem(&self, of: &ConeProblem<'_, T>) -> ConeProblem<'_, T> {
        ConeProblem {
            law: of.law,
            blocks: &self.kinds,
            friction: &self.friction,
            matrix: &self.matrix,
            regularization: &self.regularization,
            free_velocity: &self.free_velocity,
        }
    }

    /// Finds its forces, among those of all rows.
    pub(super) fn solve(
        &mut self,
        of: &ConeProblem<'_, T>,
        solver: &mut ConeSolver<T>,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
        start: Start,
        f: &mut [T],
    ) -> Certificate {
        self.load(of, f);
        let certificate = self.find_forces(of, solver, rows, factor, start);
        scatter(&self.rows, &self.forces, f);
        certificate
    }

    fn find_forces(
        &mut self,
        of: &ConeProblem<'_, T>,
        solver: &mut ConeSolver<T>,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
        start: Start,
    ) -> Certificate {
        let are_many = self.most_rows() > MANY_ROWS && !rows.are_on_one_tree(&self.rows);
        let has_moments = self.kinds.iter().any(|kind| kind.is_moment());
        self.is_by_blocks = are_many && !has_moments && solver.options.smoothing == 0.0;
        if self.is_by_blocks {
            return self.solve_by_blocks(of, solver, rows, factor, start);
        }
        self.form_matrix(rows);
        if start != Start::Last {
            self.forces.fill(T::zero());
        }
        let mut forces = std::mem::take(&mut self.forces);
        let certificate = solver.solve(&self.problem(of), &mut forces);
        self.added = solver.added_regularization();
        self.forces = forces;
        certificate
    }

    /// Number of rows that take part, in the lane that has most.
    fn most_rows(&self) -> usize {
        if T::LANES == 1 {
            return self.rows.len();
        }
        let takes_part = |r: &T, lane| r.value(lane) != f64::INFINITY;
        let own = |lane| {
            let rows = self.regularization.iter();
            rows.filter(|r| takes_part(r, lane)).count()
        };
        (0..T::LANES).map(own).max().unwrap_or(0)
    }

    /// Finds its forces by blocks, lane by lane, then their derivatives. Where the problem is that of the last solution, so are the forces.
    fn solve_by_blocks(
        &mut self,
        of: &ConeProblem<'_, T>,
        solver: &mut ConeSolver<T>,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
        start: Start,
    ) -> Certificate {
        let mut own = self.by_blocks.take().unwrap_or_default();
        let is_one = T::LANES == 1 && !is_more_than_values::<T>();
        let mut worst = Certificate::default();
        for lane in 0..T::LANES {
            std::mem::swap(&mut own.given, &mut own.last);
            (own.given.law, own.given.options) = (of.law, solver.options);
            self.fill_lane(rows, factor, lane, &mut own);
            let is_same = is_one && start != Start::Nothing && own.given == own.last;
            if !is_same {
                self.solve_lane(solver, lane, &mut own);
            }
            worst = worst.worse(own.certificate);
            for (f, &value) in self.forces.iter_mut().zip(&own.forces) {
                let others = *f;
                *f = T::from_values(|l| if l == lane { value } else { others.value(l) });
            }
        }
        if is_more_than_values::<T>() && worst.status != Status::NotFinite {
            self.form_matrix(rows);
            let mut forces = std::mem::take(&mut self.forces);
            solver.adopt(&self.problem(of), own.added, &mut forces);
            self.forces = forces;
        }
        self.added = own.added;
        self.by_blocks = Some(own);
        worst
    }

    /// Writes a lane of the problem.
    fn fill_lane(
        &self,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
        lane: usize,
        own: &mut ByBlocks,
    ) {
        let ByBlocks { given, nodes, .. } = own;
        given.kinds.clone_from(&self.kinds);
        rows.fill_columns(factor, &self.rows, lane, nodes, &mut given.columns);
        values(&self.friction, lane, &mut given.friction);
        values(&self.regularization, lane, &mut given.regularization);
        values(&self.free_velocity, lane, &mut given.free_velocity);
    }

    /// Finds the forces of a lane from those that there are.
    fn solve_lane(&self, solver: &mut ConeSolver<T>, lane: usize, own: &mut ByBlocks) {
        values(&self.forces, lane, &mut own.forces);
        let problem = own.given.problem();
        own.certificate = solver.solve_blocks(&problem, &mut own.forces);
        own.statuses.resize(T::LANES, Status::default());
        own.statuses[lane] = own.certificate.status;
        own.added = solver.added_regularization();
        own.modes.clear();
        own.modes.extend_from_slice(solver.modes());
    }

    fn take_solver(&mut self) -> Box<ConeSolver<T>> {
        let new = || Box::new(ConeSolver::new(0, 0));
        self.solver.take().unwrap_or_else(new)
    }

    /// Readies a solver for derivatives: with the rows in one piece, and the forces that were found.
    pub(super) fn prepare_slopes(
        &mut self,
        of: &ConeProblem<'_, T>,
        options: ConeOptions,
        rows: &SparseRows<T>,
    ) {
        if self.is_by_blocks {
            self.form_matrix(rows);
        }
        let mut solver = self.take_solver();
        let mut forces = std::mem::take(&mut self.forces);
        solver.options = options;
        solver.adopt(&self.problem(of), self.added, &mut forces);
        (self.solver, self.forces) = (Some(solver), forces);
    }

    /// Status of the last solution in each lane.
    pub(super) fn statuses<'a>(&'a self, solver: &'a ConeSolver<T>) -> &'a [Status] {
        match self.by_blocks.as_deref().filter(|_| self.is_by_blocks) {
            Some(own) => &own.statuses,
            None => solver.statuses(),
        }
    }

    /// Hands the mode of each of its blocks in the first lane to `each`.
    pub(super) fn each_mode(&self, solver: &ConeSolver<T>, mut each: impl FnMut(usize, Mode)) {
        let own = self.by_blocks.as_deref().filter(|_| self.is_by_blocks);
        let modes = own.map_or(solver.modes(), |own| &own.modes);
        let modes = self.blocks.iter().zip(modes);
        modes.for_each(|(&block, &mode)| each(block, mode));
    }

    /// See [`ConeSolver::respond_transposed`].
    pub(super) fn respond_transposed(
        &mut self,
        of: &ConeProblem<'_, T>,
        weights: &mut [T],
        by_friction: &mut [T],
    ) {
        let forces = std::mem::take(&mut self.forces);
        let (mut own, mut slopes) = (
            std::mem::take(&mut self.weights),
            std::mem::take(&mut self.by_friction),
        );
        gather(&self.rows, weights, &mut own);
        slopes.clear();
        if !by_friction.is_empty() {
            gather(&self.blocks, by_friction, &mut slopes);
        }
        let mut solver = self.take_solver();
        solver.respond_transposed(&self.problem(of), &forces, &mut own, &mut slopes);
        self.solver = Some(solver);
        scatter(&self.rows, &own, weights);
        if !by_friction.is_empty() {
            scatter(&self.blocks, &slopes, by_friction);
        }
        (self.forces, self.weights, self.by_friction) = (forces, own, slopes);
    }

    /// See [`ConeSolver::apply_sensitivity`].
    pub(super) fn respond<S: Linear<T>>(
        &mut self,
        of: &ConeProblem<'_, T>,
        change: &mut [S],
        memory: &mut Vec<S>,
    ) {
        let own = self.rows.iter().map(|&row| change[row]);
        if own.clone().all(|x| x.is_zero()) {
            return;
        }
        memory.clear();
        memory.extend(own);
        let n = self.rows.len();
        memory.resize(3 * n, S::zero());
        let (changed, rest) = memory.split_at_mut(n);
        let forces = std::mem::take(&mut self.forces);
        let mut solver = self.take_solver();
        let one = std::iter::once(&mut *changed);
        solver.apply_sensitivity(&self.problem(of), &forces, one, rest);
        self.solver = Some(solver);
        scatter(&self.rows, changed, change);
        self.forces = forces;
    }
}

/// The entries of some indices.
fn gather<T: Copy>(at: &[usize], from: &[T], to: &mut Vec<T>) {
    to.clear();
    to.extend(at.iter().map(|&k| from[k]));
}

/// The values of a lane.
fn values<T: Scalar>(of: &[T], lane: usize, to: &mut Vec<f64>) {
    to.clear();
    to.extend(of.iter().map(|x| x.value(lane)));
}

/// Puts entries where they belong.
fn scatter<T: Copy>(at: &[usize], from: &[T], to: &mut [T]) {
    for (&k, &x) in at.iter().zip(from) {
        to[k] = x;
    }
}
