//! One lane of a problem, without the blocks that take no part in it: those of another lane cost it nothing.

use super::{Block, ConeProblem, Law};
use crate::scalar::Scalar;

/// A lane of a problem, and the forces to start from.
#[derive(Clone, Debug, Default)]
pub(super) struct LaneProblem {
    /// The rows that take part, by their indices among all.
    pub(super) rows: Vec<usize>,
    /// The blocks, likewise.
    pub(super) blocks: Vec<usize>,
    law: Law,
    kinds: Vec<Block>,
    friction: Vec<f64>,
    matrix: Vec<f64>,
    regularization: Vec<f64>,
    free_velocity: Vec<f64>,
    pub(super) forces: Vec<f64>,
}

impl LaneProblem {
    /// Makes room for so many rows.
    pub(super) fn reserve(&mut self, rows: usize) {
        self.rows.reserve(rows);
        self.blocks.reserve(rows);
        self.kinds.reserve(rows);
        self.matrix.reserve(rows * rows);
        let numbers = [&mut self.friction, &mut self.regularization];
        let numbers = numbers
            .into_iter()
            .chain([&mut self.free_velocity, &mut self.forces]);
        numbers.for_each(|x| x.reserve(rows));
    }

    /// Takes over a lane.
    pub(super) fn read<T: Scalar>(&mut self, of: &ConeProblem<'_, T>, f: &[T], lane: usize) {
        self.choose(of, lane);
        let n = f.len();
        let Self { rows, blocks, .. } = self;
        self.law = of.law;
        fill(&mut self.kinds, blocks, |k| of.blocks[k]);
        fill(&mut self.friction, blocks, |k| of.friction[k].value(lane));
        let regularization = |row: usize| of.regularization[row].value(lane);
        fill(&mut self.regularization, rows, regularization);
        let free_velocity = |row: usize| of.free_velocity[row].value(lane);
        fill(&mut self.free_velocity, rows, free_velocity);
        fill(&mut self.forces, rows, |row| f[row].value(lane));
        self.matrix.clear();
        if rows.len() == n {
            let entries = of.matrix.iter().map(|x| x.value(lane));
            return self.matrix.extend(entries);
        }
        for column in rows.iter().map(|&row| &of.matrix[n * row..n * (row + 1)]) {
            let entries = rows.iter().map(|&row| column[row].value(lane));
            self.matrix.extend(entries);
        }
    }

    /// Lists the blocks whose rows have a finite R; a moment takes part with its cone.
    fn choose<T: Scalar>(&mut self, of: &ConeProblem<'_, T>, lane: usize) {
        self.rows.clear();
        self.blocks.clear();
        let (mut row, mut has_cone) = (0, false);
        for (block, kind) in of.blocks.iter().enumerate() {
            let rows = row..row + kind.rows();
            row = rows.end;
            let mut own = of.regularization[rows.clone()].iter();
            let mut is_present = own.all(|r| r.value(lane) != f64::INFINITY);
            match kind {
                Block::Cone => has_cone = is_present,
                Block::Spin | Block::Roll => is_present &= has_cone,
                _ => {}
            }
            if is_present {
                self.blocks.push(block);
                self.rows.extend(rows);
            }
        }
    }

    /// The problem of the lane.
    pub(super) fn problem(&self) -> ConeProblem<'_, f64> {
        ConeProblem {
            law: self.law,
            blocks: &self.kinds,
            friction: &self.friction,
            matrix: &self.matrix,
            regularization: &self.regularization,
            free_velocity: &self.free_velocity,
        }
    }
}

fn fill<X>(out: &mut Vec<X>, of: &[usize], number: impl Fn(usize) -> X) {
    out.clear();
    out.extend(of.iter().map(|&k| number(k)));
}
