//! One lane of a problem in plain numbers, scaled so that every row is of size 1.

use super::{Block, ConeProblem, Law};
use crate::scalar::Scalar;

/// A diagonal entry this small beside the largest is rounding, and its row is scaled like the largest.
const NO_DIAGONAL: f64 = 1e-14;

/// A regularisation as large as this, beside the size of its row, leaves most digits of a solution.
const ENOUGH: f64 = 1e-6;

/// The smallest parts that a law speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// One bilateral row.
    Row,
    Ray,
    /// Three rows.
    Cone,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Unit {
    pub(super) kind: Kind,
    /// The first row.
    pub(super) row: usize,
    /// The block of the problem that it belongs to.
    pub(super) block: usize,
    /// Whether it gives way without a force and so takes no part.
    pub(super) absent: bool,
    /// Friction; 0 where there is none.
    pub(super) mu: f64,
}

impl Unit {
    pub(super) fn rows(&self) -> usize {
        if self.kind == Kind::Cone { 3 } else { 1 }
    }
}

/// y = W f + g with  f = s f′,  y = y′ / s:  W′ = s W s,  g′ = s g.
///
/// s is the same in the rows of a cone, which keeps cones and products as they are, and such that the diagonal of W′ is 1 on average:
/// then f′ and y′ have the same unit, √J, and no weights are needed between them.
#[derive(Clone, Debug, Default)]
pub(super) struct System {
    pub(super) n: usize,
    pub(super) law: Law,
    pub(super) units: Vec<Unit>,
    /// W′ by columns.
    pub(super) w: Vec<f64>,
    pub(super) g: Vec<f64>,
    /// s, for each row.
    pub(super) scale: Vec<f64>,
    /// Whether the rows' own regularisation, beside their size, is so large that W′ is regular.
    pub(super) is_regularized: bool,
}

impl System {
    /// Reads one lane. `false` if a number is not finite.
    pub(super) fn load<T: Scalar>(&mut self, problem: &ConeProblem<'_, T>, lane: usize) -> bool {
        let n = problem.free_velocity.len();
        (self.n, self.law) = (n, problem.law);
        read(problem.matrix, lane, &mut self.w);
        read(problem.free_velocity, lane, &mut self.g);
        self.list_units(problem, lane);
        let regularization = |i: usize| problem.regularization[i].value(lane);
        for i in 0..n {
            self.w[i * n + i] += regularization(i);
        }
        self.take_out_what_is_absent();
        self.scale.resize(n, 1.0);
        self.find_scale();
        let finite = self.rescale();
        let scaled = |i: usize| regularization(i) * self.scale[i] * self.scale[i];
        self.is_regularized = (0..n).map(scaled).all(|r| r > ENOUGH);
        finite && self.units.iter().all(|unit| unit.mu.is_finite())
    }

    /// Units whose rows give way without a force have none, and say nothing to others: their own numbers would swamp those of the rest.
    fn take_out_what_is_absent(&mut self) {
        let n = self.n;
        for i in self.units.iter().filter(|u| u.absent).map(|u| u.row) {
            self.w[n * i..n * (i + 1)].fill(0.0);
            self.w.iter_mut().skip(i).step_by(n).for_each(|w| *w = 0.0);
            self.w[i * n + i] = 1.0;
            self.g[i] = 0.0;
        }
    }

    /// Makes room for so many rows.
    pub(super) fn reserve(&mut self, rows: usize) {
        self.units.reserve(rows);
        self.w.reserve(rows * rows);
        self.g.reserve(rows);
        self.scale.reserve(rows);
    }

    /// W′ = 1, g = 0, and no friction.
    pub(super) fn blank(&mut self) {
        self.w.fill(0.0);
        self.g.fill(0.0);
        self.scale.fill(1.0);
        for i in 0..self.n {
            self.w[i * self.n + i] = 1.0;
        }
        for unit in &mut self.units {
            unit.mu = 0.0;
        }
    }

    fn list_units<T: Scalar>(&mut self, problem: &ConeProblem<'_, T>, lane: usize) {
        self.units.clear();
        let mut row = 0;
        for (block, kind) in problem.blocks.iter().enumerate() {
            let is_infinite = |row: usize| problem.regularization[row].value(lane) == f64::INFINITY;
            let absent = (row..row + kind.rows()).any(is_infinite);
            let (kind, count) = match kind {
                Block::Ray if !absent => (Kind::Ray, 1),
                Block::Cone if !absent => (Kind::Cone, 1),
                // Rows by themselves: what takes no part has no law.
                other => (Kind::Row, other.rows()),
            };
            let mu = if kind == Kind::Cone {
                problem.friction[block].value(lane)
            } else {
                0.0
            };
            for _ in 0..count {
                let unit = Unit {
                    kind,
                    row,
                    block,
                    absent,
                    mu,
                };
                row += unit.rows();
                self.units.push(unit);
            }
        }
    }

    fn find_scale(&mut self) {
        let n = self.n;
        let largest = (0..n).map(|i| self.w[i * n + i]).fold(0.0, f64::max);
        for unit in &self.units {
            let rows = unit.row..unit.row + unit.rows();
            let sum: f64 = rows.clone().map(|i| self.w[i * n + i]).sum();
            let mean = sum / unit.rows() as f64;
            let size = if mean > NO_DIAGONAL * largest {
                mean
            } else {
                largest
            };
            let scale = if size > 0.0 { 1.0 / size.sqrt() } else { 1.0 };
            self.scale[rows].fill(scale);
        }
    }

    /// Whether all numbers are finite.
    fn rescale(&mut self) -> bool {
        let (n, scale) = (self.n, &self.scale);
        let mut finite = true;
        for (g, scale) in self.g.iter_mut().zip(scale) {
            *g *= scale;
            finite &= g.is_finite();
        }
        for (column, scale_of_column) in self.w.chunks_exact_mut(n.max(1)).zip(scale) {
            for (w, scale_of_row) in column.iter_mut().zip(scale) {
                *w *= scale_of_row * scale_of_column;
                // Without an early end, which would keep numbers from being worked on together.
                finite &= w.is_finite();
            }
        }
        finite
    }

    /// y ← W f + g.
    pub(super) fn velocities(&self, f: &[f64], g: &[f64], y: &mut [f64]) {
        y.copy_from_slice(g);
        for (column, &f) in self.w.chunks_exact(self.n.max(1)).zip(f) {
            if f != 0.0 {
                for (y, w) in y.iter_mut().zip(column) {
                    *y += w * f;
                }
            }
        }
    }
}

fn read<T: Scalar>(from: &[T], lane: usize, to: &mut Vec<f64>) {
    to.clear();
    to.extend(from.iter().map(|x| x.value(lane)));
}

/// Force and velocity of a unit; zeros after the first entry of a ray or a bilateral row.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnitState {
    pub(super) f: [f64; 3],
    pub(super) y: [f64; 3],
}

impl UnitState {
    #[inline(always)]
    pub(super) fn of(unit: &Unit, f: &[f64], y: &[f64]) -> Self {
        let (f, y) = (of_unit(f, unit), of_unit(y, unit));
        Self { f, y }
    }
}

/// The rows of a unit; zeros after the first of a ray or a bilateral row.
#[inline(always)]
pub(super) fn of_unit(x: &[f64], unit: &Unit) -> [f64; 3] {
    let first = unit.row;
    if unit.kind == Kind::Cone {
        [x[first], x[first + 1], x[first + 2]]
    } else {
        [x[first], 0.0, 0.0]
    }
}
