//! The forces of an island: in one piece, or by blocks where it has many rows.

use std::ops::Range;

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

/// The problem of an island, with its solver.
#[derive(Clone, Debug)]
pub(super) struct Island<T: Scalar> {
    rows: Vec<usize>,
    blocks: Vec<usize>,
    kinds: Vec<Block>,
    friction: Vec<T>,
    /// G, where the island is solved in one piece, or derivatives are needed.
    matrix: Vec<T>,
    regularization: Vec<T>,
    free_velocity: Vec<T>,
    forces: Vec<T>,
    weights: Vec<T>,
    by_friction: Vec<T>,
    solver: ConeSolver<T>,
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
    certificate: Certificate,
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
    pub(super) fn new(options: ConeOptions) -> Self {
        Self {
            rows: Vec::new(),
            blocks: Vec::new(),
            kinds: Vec::new(),
            friction: Vec::new(),
            matrix: Vec::new(),
            regularization: Vec::new(),
            free_velocity: Vec::new(),
            forces: Vec::new(),
            weights: Vec::new(),
            by_friction: Vec::new(),
            solver: ConeSolver::new(0, 0).with_options(options),
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
        for i in 0..n {
            let (before, rest) = self.matrix.split_at_mut(n * i);
            rows.products(self.rows[i], &self.rows[..=i], &mut rest[..=i]);
            let column = before.iter_mut().skip(i).step_by(n.max(1));
            column.zip(&*rest).for_each(|(out, &x)| *out = x);
        }
    }

    /// Its problem, the solver beside it.
    fn parts<'a>(
        &'a mut self,
        of: &ConeProblem<'_, T>,
    ) -> (ConeProblem<'a, T>, &'a mut ConeSolver<T>) {
        let problem = ConeProblem {
            law: of.law,
            blocks: &self.kinds,
            friction: &self.friction,
            matrix: &self.matrix,
            regularization: &self.regularization,
            free_velocity: &self.free_velocity,
        };
        (problem, &mut self.solver)
    }

    /// Finds its forces, among those of all rows.
    pub(super) fn solve(
        &mut self,
        of: &ConeProblem<'_, T>,
        options: ConeOptions,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
        start: Start,
        f: &mut [T],
    ) -> Certificate {
        self.solver.options = options;
        self.load(of, f);
        let certificate = self.find_forces(of, rows, factor, start);
        scatter(&self.rows, &self.forces, f);
        certificate
    }

    fn find_forces(
        &mut self,
        of: &ConeProblem<'_, T>,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
        start: Start,
    ) -> Certificate {
        let are_many = self.rows.len() > MANY_ROWS && !rows.are_on_one_tree(&self.rows);
        let has_moments = self.kinds.iter().any(|kind| kind.is_moment());
        self.is_by_blocks = are_many && !has_moments && self.solver.options.smoothing == 0.0;
        if self.is_by_blocks {
            return self.solve_by_blocks(of, rows, factor, start);
        }
        self.form_matrix(rows);
        if start != Start::Last {
            self.forces.fill(T::zero());
        }
        let mut forces = std::mem::take(&mut self.forces);
        let (problem, solver) = self.parts(of);
        let certificate = solver.solve(&problem, &mut forces);
        self.forces = forces;
        certificate
    }

    /// Finds its forces by blocks, lane by lane, then their derivatives. Where the problem is that of the last solution, so are the forces.
    fn solve_by_blocks(
        &mut self,
        of: &ConeProblem<'_, T>,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
        start: Start,
    ) -> Certificate {
        let mut own = self.by_blocks.take().unwrap_or_default();
        let is_one = T::LANES == 1 && !is_more_than_values::<T>();
        let mut worst = Certificate::default();
        for lane in 0..T::LANES {
            std::mem::swap(&mut own.given, &mut own.last);
            self.fill_lane(of.law, rows, factor, lane, &mut own);
            let is_same = is_one && start != Start::Nothing && own.given == own.last;
            if !is_same {
                self.solve_lane(lane, &mut own);
            }
            worst = worst.worse(own.certificate);
            for (f, &value) in self.forces.iter_mut().zip(&own.forces) {
                let others = *f;
                *f = T::from_values(|l| if l == lane { value } else { others.value(l) });
            }
        }
        self.by_blocks = Some(own);
        if is_more_than_values::<T>() && worst.status != Status::NotFinite {
            self.form_matrix(rows);
            self.adopt(of);
        }
        worst
    }

    /// Writes a lane of the problem.
    fn fill_lane(
        &self,
        law: Law,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
        lane: usize,
        own: &mut ByBlocks,
    ) {
        let ByBlocks { given, nodes, .. } = own;
        (given.law, given.options) = (law, self.solver.options);
        given.kinds.clone_from(&self.kinds);
        rows.fill_columns(factor, &self.rows, lane, nodes, &mut given.columns);
        values(&self.friction, lane, &mut given.friction);
        values(&self.regularization, lane, &mut given.regularization);
        values(&self.free_velocity, lane, &mut given.free_velocity);
    }

    /// Finds the forces of a lane from those that there are.
    fn solve_lane(&mut self, lane: usize, own: &mut ByBlocks) {
        values(&self.forces, lane, &mut own.forces);
        let problem = own.given.problem();
        own.certificate = self.solver.solve_blocks(&problem, &mut own.forces);
        own.statuses.resize(T::LANES, Status::default());
        own.statuses[lane] = own.certificate.status;
    }

    /// Readies what was solved by blocks for derivatives, which take the rows in one piece.
    pub(super) fn prepare_slopes(&mut self, of: &ConeProblem<'_, T>, rows: &SparseRows<T>) {
        if self.is_by_blocks {
            self.form_matrix(rows);
            self.adopt(of);
        }
    }

    /// Lets the solver take its forces for those of the problem in one piece.
    fn adopt(&mut self, of: &ConeProblem<'_, T>) {
        let mut forces = std::mem::take(&mut self.forces);
        let (problem, solver) = self.parts(of);
        solver.adopt(&problem, &mut forces);
        self.forces = forces;
    }

    /// Status of the last solution in each lane.
    pub(super) fn statuses(&self) -> &[Status] {
        match self.by_blocks.as_deref().filter(|_| self.is_by_blocks) {
            Some(own) => &own.statuses,
            None => self.solver.statuses(),
        }
    }

    /// Hands the mode of each of its blocks in the first lane to `each`.
    pub(super) fn each_mode(&self, mut each: impl FnMut(usize, Mode)) {
        let modes = self.blocks.iter().zip(self.solver.modes());
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
        let (problem, solver) = self.parts(of);
        solver.respond_transposed(&problem, &forces, &mut own, &mut slopes);
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
        let (problem, solver) = self.parts(of);
        solver.apply_sensitivity(&problem, &forces, std::iter::once(&mut *changed), rest);
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
