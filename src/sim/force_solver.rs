//! The solver of the forces of rows: of those on one tree in one piece, of those on several trees island by island.

use super::island::{Island, Start};
use super::islands::Islands;
use super::sparse_rows::SparseRows;
use crate::cone::{Certificate, ConeOptions, ConeProblem, ConeSolver, Mode, Status};
use crate::dynamics::MassMatrixFactor;
use crate::scalar::{Linear, Scalar};

/// The solver of the forces of all islands.
#[derive(Clone, Debug)]
pub(super) struct ForceSolver<T: Scalar> {
    /// Of all rows where there is one tree, of the forces of one island after the other where there are several; its options are those of all.
    pub(super) one: ConeSolver<T>,
    /// As many as there were at most.
    islands: Vec<Island<T>>,
    last: Solved,
    statuses: Vec<Status>,
    modes: Vec<Mode>,
}

/// The last problem that was solved.
#[derive(Clone, Copy, Debug)]
enum Solved {
    /// No rows.
    Nothing,
    OneTree,
    /// So many of the islands.
    Islands(usize),
}

impl<T: Scalar> ForceSolver<T> {
    /// Memory for so many rows and blocks.
    pub(super) fn new(rows: usize, blocks: usize, options: ConeOptions) -> Self {
        Self {
            one: ConeSolver::new(rows, blocks).with_options(options),
            islands: Vec::new(),
            last: Solved::Nothing,
            statuses: Vec::with_capacity(T::LANES),
            modes: Vec::new(),
        }
    }

    /// Drops the last solution, for a state without rows.
    pub(super) fn clear(&mut self) {
        self.last = Solved::Nothing;
    }

    /// Statuses of the last solution, of the worst island, for each lane.
    pub(super) fn statuses(&self) -> &[Status] {
        match self.last {
            Solved::Nothing => &[],
            Solved::OneTree => self.one.statuses(),
            Solved::Islands(_) => &self.statuses,
        }
    }

    /// Modes of the blocks in the last solution, in the first lane first.
    pub(super) fn modes(&self) -> &[Mode] {
        match self.last {
            Solved::Nothing => &[],
            Solved::OneTree => self.one.modes(),
            Solved::Islands(_) => &self.modes,
        }
    }

    /// Finds the forces of one tree.
    pub(super) fn solve(&mut self, problem: &ConeProblem<'_, T>, f: &mut [T]) -> Certificate {
        self.last = match f {
            [] => Solved::Nothing,
            _ => Solved::OneTree,
        };
        self.one.solve(problem, f)
    }

    /// Finds the forces of rows on several trees, of which the problem has no matrix.
    ///
    /// * `f` – on entry those from which they start
    pub(super) fn solve_islands(
        &mut self,
        problem: &ConeProblem<'_, T>,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
        islands: &Islands,
        start: Start,
        f: &mut [T],
    ) -> Certificate {
        self.statuses.clear();
        self.statuses.resize(T::LANES, Status::default());
        self.modes.clear();
        self.modes.resize(problem.blocks.len(), Mode::Separated);
        let count = islands.count();
        self.list(problem, islands);
        self.last = match count {
            0 => Solved::Nothing,
            _ => Solved::Islands(count),
        };
        if start == Start::Nothing {
            self.islands.iter_mut().for_each(Island::forget);
        }
        let mut worst = Certificate::default();
        for island in &mut self.islands[..count] {
            let solver = &mut self.one;
            worst = worst.worse(island.solve(problem, solver, rows, factor, start, f));
            let statuses = self.statuses.iter_mut().zip(island.statuses(solver));
            statuses.for_each(|(worst, &own)| *worst = (*worst).max(own));
            island.each_mode(solver, |block, mode| self.modes[block] = mode);
        }
        worst
    }

    /// Lists rows and blocks of each island.
    fn list(&mut self, problem: &ConeProblem<'_, T>, islands: &Islands) {
        let most = self.islands.len().max(islands.count());
        self.islands.resize_with(most, Island::new);
        self.islands.iter_mut().for_each(Island::clear);
        let mut row = 0;
        for (block, (kind, &own)) in problem.blocks.iter().zip(islands.of_blocks()).enumerate() {
            self.islands[own].push(block, row..row + kind.rows());
            row += kind.rows();
        }
    }

    /// Readies islands for derivatives.
    pub(super) fn prepare_slopes(&mut self, problem: &ConeProblem<'_, T>, rows: &SparseRows<T>) {
        if let Solved::Islands(count) = self.last {
            let all = self.islands[..count].iter_mut();
            all.for_each(|island| island.prepare_slopes(problem, self.one.options, rows));
        }
    }

    /// See [`ConeSolver::respond_transposed`].
    pub(super) fn respond_transposed(
        &mut self,
        problem: &ConeProblem<'_, T>,
        f: &[T],
        weights: &mut [T],
        by_friction: &mut [T],
    ) {
        match self.last {
            Solved::Nothing => {}
            Solved::OneTree => (self.one).respond_transposed(problem, f, weights, by_friction),
            Solved::Islands(count) => {
                for island in &mut self.islands[..count] {
                    island.respond_transposed(problem, weights, by_friction);
                }
            }
        }
    }

    /// See [`ConeSolver::apply_sensitivity`].
    pub(super) fn respond<'x, S: Linear<T>>(
        &mut self,
        problem: &ConeProblem<'_, T>,
        f: &[T],
        changes: impl Iterator<Item = &'x mut [S]>,
        memory: &mut Vec<S>,
    ) {
        match self.last {
            Solved::Nothing => {}
            Solved::OneTree => {
                memory.resize(2 * f.len(), S::zero());
                self.one.apply_sensitivity(problem, f, changes, memory);
            }
            Solved::Islands(count) => {
                for change in changes {
                    for island in &mut self.islands[..count] {
                        island.respond(problem, change, memory);
                    }
                }
            }
        }
    }
}
