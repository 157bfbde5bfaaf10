//! Rows that say nothing to each other: those on trees of joints between which there is no row.
//!
//! G = J M⁻¹ Jᵀ then has a block for each such island, and the forces of each are a problem of their own: the cost is that of the islands, not that of all
//! rows together. A robot is one tree, and one island.

use std::ops::Range;

use crate::cone::{Block, Certificate, ConeOptions, ConeProblem, ConeSolver, Mode, Status};
use crate::model::Model;
use crate::scalar::{Linear, Scalar};

/// The islands of the rows of an instant.
#[derive(Clone, Debug)]
pub(super) struct Islands {
    /// First coordinate of the tree of each one; empty where there is one tree.
    trees: Vec<usize>,
    /// Another tree with which a row connects the one of a coordinate, or itself; for the first coordinate of each tree.
    joined: Vec<usize>,
    /// Island of each row and of each block.
    pub(super) of_rows: Vec<usize>,
    of_blocks: Vec<usize>,
    count: usize,
}

impl Islands {
    pub(super) fn new<P: Scalar>(model: &Model<P>) -> Self {
        let trees = trees(model);
        let is_one = trees.iter().all(|&first| first == 0);
        Self {
            trees: if is_one { Vec::new() } else { trees },
            joined: Vec::new(),
            of_rows: Vec::new(),
            of_blocks: Vec::new(),
            count: 1,
        }
    }

    /// Whether there are several.
    pub(super) fn are_several(&self) -> bool {
        self.count > 1
    }

    /// The coordinates on which some rows act, from the first of a tree on, one after the last; all of them where there is one tree.
    pub(super) fn range<T: Scalar>(&self, jacobian: &[T], nv: usize) -> Range<usize> {
        if self.trees.is_empty() || !T::HAS_VALUES {
            return 0..nv;
        }
        let acts = |k: &usize| jacobian.iter().skip(*k).step_by(nv).any(|x| !x.is_zero());
        let first = (0..nv).find(acts).map_or(0, |k| self.trees[k]);
        first..(first..nv).rev().find(acts).map_or(first, |k| k + 1)
    }

    /// Finds the islands of rows.
    ///
    /// * `jacobian` – J, row after row, a number for each coordinate
    pub(super) fn find<T: Scalar>(&mut self, jacobian: &[T], blocks: &[Block]) {
        self.count = 1;
        // What is recorded has no zeros that are known.
        if self.trees.is_empty() || !T::HAS_VALUES {
            return;
        }
        let nv = self.trees.len();
        self.joined.clear();
        self.joined.extend(0..nv);
        self.of_rows.clear();
        self.of_blocks.clear();
        let mut rows = jacobian.chunks_exact(nv);
        for block in blocks {
            let mut own = None;
            for row in rows.by_ref().take(block.rows()) {
                own = self.join(own, row);
            }
            self.of_blocks.push(own.unwrap_or(0));
        }
        self.number(blocks);
    }

    /// Joins the trees on which a row acts with one on which the rows before it do.
    fn join<T: Scalar>(&mut self, mut own: Option<usize>, row: &[T]) -> Option<usize> {
        let mut k = 0;
        while k < row.len() {
            if row[k].is_zero() {
                k += 1;
                continue;
            }
            let tree = self.root(self.trees[k]);
            let root = own.map_or(tree, |own| self.root(own));
            let (first, second) = (root.min(tree), root.max(tree));
            self.joined[second] = first;
            own = Some(first);
            // The rest of this tree says no more.
            let first = self.trees[k];
            while k < row.len() && self.trees[k] == first {
                k += 1;
            }
        }
        own
    }

    fn root(&self, mut tree: usize) -> usize {
        while self.joined[tree] != tree {
            tree = self.joined[tree];
        }
        tree
    }

    /// From a tree of each block to the island of each row and block, numbered from zero in the order of the blocks.
    fn number(&mut self, blocks: &[Block]) {
        let nv = self.trees.len();
        for k in 0..self.of_blocks.len() {
            self.of_blocks[k] = self.root(self.of_blocks[k]);
        }
        self.joined.fill(nv);
        self.count = 0;
        for (block, own) in blocks.iter().zip(&mut self.of_blocks) {
            let number = &mut self.joined[*own];
            if *number == nv {
                *number = self.count;
                self.count += 1;
            }
            *own = *number;
            (self.of_rows).extend(std::iter::repeat_n(*own, block.rows()));
        }
    }
}

/// First coordinate of what is connected with each one, by joints or by joints that follow others.
fn trees<P: Scalar>(model: &Model<P>) -> Vec<usize> {
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
    (0..trees.len()).map(|k| root(&trees, k)).collect()
}

/// The solver of the forces of all islands.
#[derive(Clone, Debug)]
pub(super) struct ForceSolver<T: Scalar> {
    /// Of all rows where they are one island; its options are those of all.
    pub(super) one: ConeSolver<T>,
    islands: Vec<Island<T>>,
    statuses: Vec<Status>,
    modes: Vec<Mode>,
    are_several: bool,
}

/// The problem of an island, with its solver.
#[derive(Clone, Debug)]
struct Island<T: Scalar> {
    rows: Vec<usize>,
    blocks: Vec<usize>,
    kinds: Vec<Block>,
    friction: Vec<T>,
    matrix: Vec<T>,
    regularization: Vec<T>,
    free_velocity: Vec<T>,
    forces: Vec<T>,
    weights: Vec<T>,
    by_friction: Vec<T>,
    solver: ConeSolver<T>,
}

impl<T: Scalar> ForceSolver<T> {
    /// Memory for so many rows and blocks.
    pub(super) fn new(rows: usize, blocks: usize, options: ConeOptions) -> Self {
        Self {
            one: ConeSolver::new(rows, blocks).with_options(options),
            islands: Vec::new(),
            statuses: Vec::with_capacity(T::LANES),
            modes: Vec::new(),
            are_several: false,
        }
    }

    /// Statuses of the last solution, of the worst island, for each lane.
    pub(super) fn statuses(&self) -> &[Status] {
        match self.are_several {
            true => &self.statuses,
            false => self.one.statuses(),
        }
    }

    /// Modes of the blocks in the last solution, in the first lane first.
    pub(super) fn modes(&self) -> &[Mode] {
        match self.are_several {
            true => &self.modes,
            false => self.one.modes(),
        }
    }

    /// Finds the forces.
    pub(super) fn solve(
        &mut self,
        problem: &ConeProblem<'_, T>,
        islands: &Islands,
        f: &mut [T],
    ) -> Certificate {
        self.are_several = islands.are_several();
        if !self.are_several {
            return self.one.solve(problem, f);
        }
        self.statuses.clear();
        self.statuses.resize(T::LANES, Status::default());
        self.modes.clear();
        self.modes.resize(problem.blocks.len(), Mode::Separated);
        let options = self.one.options;
        let new = || Island::new(options);
        self.islands.resize_with(islands.count, new);
        let mut worst = Certificate::default();
        for (k, island) in self.islands.iter_mut().enumerate() {
            island.load(problem, islands, k, f);
            island.solver.options = options;
            worst = worst.worse(island.solve(problem, f));
            let statuses = self.statuses.iter_mut().zip(island.solver.statuses());
            statuses.for_each(|(worst, &own)| *worst = (*worst).max(own));
            let modes = island.blocks.iter().zip(island.solver.modes());
            modes.for_each(|(&block, &own)| self.modes[block] = own);
        }
        worst
    }

    /// See [`ConeSolver::respond_transposed`].
    pub(super) fn respond_transposed(
        &mut self,
        problem: &ConeProblem<'_, T>,
        f: &[T],
        weights: &mut [T],
        by_friction: &mut [T],
    ) {
        if !self.are_several {
            self.one
                .respond_transposed(problem, f, weights, by_friction);
            return;
        }
        for island in &mut self.islands {
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
        if !self.are_several {
            memory.resize(2 * f.len(), S::zero());
            self.one.apply_sensitivity(problem, f, changes, memory);
            return;
        }
        for change in changes {
            for island in &mut self.islands {
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
        }
    }

    /// Takes its part of a problem, and of forces to start from.
    fn load(&mut self, problem: &ConeProblem<'_, T>, islands: &Islands, k: usize, f: &[T]) {
        self.rows.clear();
        let rows = islands.of_rows.iter().enumerate();
        self.rows
            .extend(rows.filter(|(_, own)| **own == k).map(|(row, _)| row));
        self.blocks.clear();
        let blocks = islands.of_blocks.iter().enumerate();
        (self.blocks).extend(blocks.filter(|(_, own)| **own == k).map(|(block, _)| block));
        self.kinds.clear();
        (self.kinds).extend(self.blocks.iter().map(|&block| problem.blocks[block]));
        gather(&self.blocks, problem.friction, &mut self.friction);
        gather(&self.rows, problem.regularization, &mut self.regularization);
        gather(&self.rows, problem.free_velocity, &mut self.free_velocity);
        gather(&self.rows, f, &mut self.forces);
        let n = problem.free_velocity.len();
        self.matrix.clear();
        for &j in &self.rows {
            let column = &problem.matrix[n * j..n * (j + 1)];
            self.matrix.extend(self.rows.iter().map(|&i| column[i]));
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

    fn solve(&mut self, of: &ConeProblem<'_, T>, f: &mut [T]) -> Certificate {
        let mut forces = std::mem::take(&mut self.forces);
        let (problem, solver) = self.parts(of);
        let certificate = solver.solve(&problem, &mut forces);
        scatter(&self.rows, &forces, f);
        self.forces = forces;
        certificate
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

/// Puts entries where they belong.
fn scatter<T: Copy>(at: &[usize], from: &[T], to: &mut [T]) {
    for (&k, &x) in at.iter().zip(from) {
        to[k] = x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn islands(trees: Vec<usize>) -> Islands {
        Islands {
            trees,
            joined: Vec::new(),
            of_rows: Vec::new(),
            of_blocks: Vec::new(),
            count: 1,
        }
    }

    // Trees {0, 1}, {2}, {3, 4}, {5}: a cone on the first two, a ray on the third, a pair of bilateral rows of which one is on the first and one on the last.
    #[test]
    fn rows_that_share_no_tree_even_through_others_are_islands_of_their_own() {
        let mut islands = islands(vec![0, 0, 2, 3, 3, 5]);
        let cone = [
            [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
            [1.0, 0.0, -2.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 3.0, 0.0, 0.0, 0.0],
        ];
        let ray = [[0.0, 0.0, 0.0, 0.0, 1.0, 0.0]];
        let pair = [
            [0.5, 0.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        ];
        let rows: Vec<f64> = [&cone[..], &ray, &pair].concat().concat();
        islands.find(&rows, &[Block::Cone, Block::Ray, Block::Free(2)]);
        assert!(islands.are_several());
        assert_eq!(islands.of_rows, [0, 0, 0, 1, 0, 0]);
        assert_eq!(islands.of_blocks, [0, 1, 0]);
        assert_eq!(islands.range(&cone.concat(), 6), 0..3);
        assert_eq!(islands.range(&ray.concat(), 6), 3..5);
        islands.find(&rows[..18], &[Block::Cone]);
        assert!(!islands.are_several());
    }

    #[test]
    fn a_robot_is_one_tree_and_free_bodies_are_many() {
        use crate::model::{Mass, Object, World, samples};
        assert!(Islands::new(&samples::arm()).trees.is_empty());
        let mut world = World::default();
        for name in ["a", "b"] {
            let ball = Object::free(Mass::Kilograms(1.0));
            world.add_sphere(name, 0.1, &ball).expect("a member");
        }
        let model = world.build().expect("a world");
        let expected: Vec<usize> = (0..12).map(|k| k / 6 * 6).collect();
        assert_eq!(Islands::new(&model).trees, expected);
    }
}
