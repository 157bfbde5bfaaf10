//! Rows that say nothing to each other: those on trees of joints between which there is no row.
//!
//! G = J M⁻¹ Jᵀ then has a block for each such island, and the forces of each are a problem of their own: the cost is that of the islands, not that of all
//! rows together. A robot is one tree, and one island.

use super::sparse_rows::SparseRows;
use crate::cone::{
    Block, BlockProblem, Certificate, Columns, ConeOptions, ConeProblem, ConeSolver, Mode, Status,
};
use crate::dynamics::MassMatrixFactor;
use crate::model::Model;
use crate::scalar::{Linear, Scalar, is_more_than_values};

/// Rows from which on an island of several trees is solved by blocks; smaller ones are quicker in one piece.
const MANY_ROWS: usize = 48;

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
            for tree in (row..row + block.rows()).flat_map(|row| rows.trees_of(row)) {
                own = Some(self.join(own.unwrap_or(tree), tree));
            }
            row += block.rows();
            self.of_blocks.push(own.unwrap_or(0));
        }
        self.number();
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

/// First coordinate of what is connected with each one, by joints or by joints that follow others.
pub(super) fn trees<P: Scalar>(model: &Model<P>) -> Vec<usize> {
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
    let mut out: Vec<usize> = (0..trees.len()).map(|k| root(&trees, k)).collect();
    // What is between connected coordinates counts as connected with them.
    for k in (1..out.len()).rev() {
        if out[k] < k {
            out[k - 1] = out[k - 1].min(out[k]);
        }
    }
    out
}

/// The solver of the forces of all islands.
#[derive(Clone, Debug)]
pub(super) struct ForceSolver<T: Scalar> {
    /// Of all rows where there is one tree; its options are those of all.
    pub(super) one: ConeSolver<T>,
    /// As many as there were at most.
    islands: Vec<Island<T>>,
    count: usize,
    statuses: Vec<Status>,
    modes: Vec<Mode>,
}

/// The problem of an island, with its solver.
#[derive(Clone, Debug)]
struct Island<T: Scalar> {
    rows: Vec<usize>,
    blocks: Vec<usize>,
    kinds: Vec<Block>,
    friction: Vec<T>,
    /// G, where the island is solved in one piece, or derivatives are asked for.
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

/// A lane of a problem by blocks.
#[derive(Clone, Debug, Default)]
struct ByBlocks {
    columns: Columns,
    nodes: Vec<usize>,
    friction: Vec<f64>,
    regularization: Vec<f64>,
    free_velocity: Vec<f64>,
    forces: Vec<f64>,
    statuses: Vec<Status>,
}

impl<T: Scalar> ForceSolver<T> {
    /// Memory for so many rows and blocks.
    pub(super) fn new(rows: usize, blocks: usize, options: ConeOptions) -> Self {
        Self {
            one: ConeSolver::new(rows, blocks).with_options(options),
            islands: Vec::new(),
            count: 0,
            statuses: Vec::with_capacity(T::LANES),
            modes: Vec::new(),
        }
    }

    /// Statuses of the last solution, of the worst island, for each lane.
    pub(super) fn statuses(&self) -> &[Status] {
        match self.count {
            0 => self.one.statuses(),
            _ => &self.statuses,
        }
    }

    /// Modes of the blocks in the last solution, in the first lane first.
    pub(super) fn modes(&self) -> &[Mode] {
        match self.count {
            0 => self.one.modes(),
            _ => &self.modes,
        }
    }

    /// Finds the forces of one tree.
    pub(super) fn solve(&mut self, problem: &ConeProblem<'_, T>, f: &mut [T]) -> Certificate {
        self.one.solve(problem, f)
    }

    /// Finds the forces of rows on several trees, of which the problem has no matrix.
    pub(super) fn solve_islands(
        &mut self,
        problem: &ConeProblem<'_, T>,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
        islands: &Islands,
        f: &mut [T],
    ) -> Certificate {
        self.statuses.clear();
        self.statuses.resize(T::LANES, Status::default());
        self.modes.clear();
        self.modes.resize(problem.blocks.len(), Mode::Separated);
        let options = self.one.options;
        self.list(problem, islands);
        let mut worst = Certificate::default();
        for island in &mut self.islands[..self.count] {
            island.solver.options = options;
            island.load(problem, f);
            worst = worst.worse(island.solve(problem, rows, factor));
            scatter(&island.rows, &island.forces, f);
            let statuses = self.statuses.iter_mut().zip(island.statuses());
            statuses.for_each(|(worst, &own)| *worst = (*worst).max(own));
            let modes = island.blocks.iter().zip(island.solver.modes());
            modes.for_each(|(&block, &own)| self.modes[block] = own);
        }
        worst
    }

    /// Lists rows and blocks of each island.
    fn list(&mut self, problem: &ConeProblem<'_, T>, islands: &Islands) {
        let (options, most) = (self.one.options, self.islands.len().max(islands.count));
        self.islands.resize_with(most, || Island::new(options));
        self.count = islands.count;
        for island in &mut self.islands {
            island.rows.clear();
            island.blocks.clear();
        }
        let mut row = 0;
        for (block, (kind, &own)) in problem.blocks.iter().zip(&islands.of_blocks).enumerate() {
            let island = &mut self.islands[own];
            island.blocks.push(block);
            island.rows.extend(row..row + kind.rows());
            row += kind.rows();
        }
    }

    /// Readies islands that were solved by blocks for derivatives, which take their rows in one piece.
    pub(super) fn prepare_slopes(
        &mut self,
        problem: &ConeProblem<'_, T>,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
    ) {
        let all = self.islands[..self.count].iter_mut();
        for island in all.filter(|island| island.is_by_blocks) {
            island.form_matrix(rows, factor);
            island.adopt(problem);
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
        // Several trees without rows have no island, and nobody has used the solver of one tree.
        if f.is_empty() {
            return;
        }
        if self.count == 0 {
            self.one
                .respond_transposed(problem, f, weights, by_friction);
            return;
        }
        for island in &mut self.islands[..self.count] {
            island.respond_transposed(problem, weights, by_friction);
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
        if f.is_empty() {
            return;
        }
        if self.count == 0 {
            memory.resize(2 * f.len(), S::zero());
            self.one.apply_sensitivity(problem, f, changes, memory);
            return;
        }
        for change in changes {
            for island in &mut self.islands[..self.count] {
                island.respond(problem, change, memory);
            }
        }
    }
}

impl<T: Scalar> Island<T> {
    fn new(options: ConeOptions) -> Self {
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
    fn form_matrix(&mut self, rows: &SparseRows<T>, factor: &MassMatrixFactor<T>) {
        let n = self.rows.len();
        self.matrix.clear();
        self.matrix.resize(n * n, T::zero());
        for i in 0..n {
            for j in 0..=i {
                let entry = rows.product(factor, self.rows[i], self.rows[j]);
                self.matrix[n * i + j] = entry;
                self.matrix[n * j + i] = entry;
            }
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

    /// Finds its forces.
    fn solve(
        &mut self,
        of: &ConeProblem<'_, T>,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
    ) -> Certificate {
        let are_many = self.rows.len() > MANY_ROWS && !rows.are_on_one_tree(&self.rows);
        self.is_by_blocks = are_many && self.solver.options.smoothing == 0.0;
        if self.is_by_blocks {
            return self.solve_by_blocks(of, rows, factor);
        }
        self.form_matrix(rows, factor);
        let mut forces = std::mem::take(&mut self.forces);
        let (problem, solver) = self.parts(of);
        let certificate = solver.solve(&problem, &mut forces);
        self.forces = forces;
        certificate
    }

    /// Finds its forces by blocks, lane by lane, then what they have besides values.
    fn solve_by_blocks(
        &mut self,
        of: &ConeProblem<'_, T>,
        rows: &SparseRows<T>,
        factor: &MassMatrixFactor<T>,
    ) -> Certificate {
        let mut own = self.by_blocks.take().unwrap_or_default();
        own.statuses.clear();
        let mut worst = Certificate::default();
        for lane in 0..T::LANES {
            rows.fill_columns(factor, &self.rows, lane, &mut own.nodes, &mut own.columns);
            values(&self.friction, lane, &mut own.friction);
            values(&self.regularization, lane, &mut own.regularization);
            values(&self.free_velocity, lane, &mut own.free_velocity);
            own.forces.clear();
            own.forces.resize(self.rows.len(), 0.0);
            let problem = BlockProblem {
                law: of.law,
                blocks: &self.kinds,
                friction: &own.friction,
                columns: &own.columns,
                regularization: &own.regularization,
                free_velocity: &own.free_velocity,
            };
            let certificate = self.solver.solve_blocks(&problem, &mut own.forces);
            own.statuses.push(certificate.status);
            worst = worst.worse(certificate);
            for (f, &value) in self.forces.iter_mut().zip(&own.forces) {
                let others = *f;
                *f = T::from_values(|l| if l == lane { value } else { others.value(l) });
            }
        }
        self.by_blocks = Some(own);
        if is_more_than_values::<T>() && worst.status != Status::NotFinite {
            self.form_matrix(rows, factor);
            self.adopt(of);
        }
        worst
    }

    /// Lets the solver take its forces for those of the problem in one piece.
    fn adopt(&mut self, of: &ConeProblem<'_, T>) {
        let mut forces = std::mem::take(&mut self.forces);
        let (problem, solver) = self.parts(of);
        solver.adopt(&problem, &mut forces);
        self.forces = forces;
    }

    /// Status of the last solution in each lane.
    fn statuses(&self) -> &[Status] {
        match self.by_blocks.as_deref().filter(|_| self.is_by_blocks) {
            Some(own) => &own.statuses,
            None => self.solver.statuses(),
        }
    }

    fn respond_transposed(
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

    fn respond<S: Linear<T>>(
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

#[cfg(test)]
mod tests {
    use super::*;

    // Trees {0, 1}, {2}, {3, 4}, {5}: a cone on the first two, a ray on the third, a pair of bilateral rows of which one is on the first and one on the last.
    #[test]
    fn rows_that_share_no_tree_even_through_others_are_islands_of_their_own() {
        let mut rows = SparseRows::new(&[0, 0, 2, 3, 3, 5]);
        rows.grow(3);
        for (row, k) in [(0, 1), (1, 0), (1, 2), (2, 2)] {
            rows.add(3, row, k, 1.0);
        }
        for k in [4, 0, 5] {
            rows.grow(1);
            rows.add(1, 0, k, 1.0);
        }
        let mut islands = Islands::default();
        islands.find(&rows, &[Block::Cone, Block::Ray, Block::Free(2)]);
        assert_eq!((islands.count, &islands.of_blocks[..]), (2, &[0, 1, 0][..]));
        rows.truncate(3);
        islands.find(&rows, &[Block::Cone]);
        assert_eq!((islands.count, &islands.of_blocks[..]), (1, &[0][..]));
    }

    #[test]
    fn a_robot_is_one_tree_and_free_bodies_are_many() {
        use crate::model::{Mass, Object, World, samples};
        assert!(trees(&samples::arm()).iter().all(|&first| first == 0));
        let mut world = World::default();
        for name in ["a", "b"] {
            let ball = Object::free(Mass::Kilograms(1.0));
            world.add_sphere(name, 0.1, &ball).expect("a member");
        }
        let model = world.build().expect("a world");
        let expected: Vec<usize> = (0..12).map(|k| k / 6 * 6).collect();
        assert_eq!(trees(&model), expected);
    }
}
