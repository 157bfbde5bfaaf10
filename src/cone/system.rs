//! A problem, scaled so that every row is of size 1: one lane of it in plain numbers, or numbers that are recorded.

use super::{Block, ConeProblem, Law};
use crate::scalar::{Scalar, pairs};

/// A diagonal entry this small beside the largest is rounding, and its row is scaled like the largest.
const NO_DIAGONAL: f64 = 1e-14;

/// A regularisation as large as this, beside the size of its row, leaves most digits of a solution.
pub(super) const REGULARIZED_ABOVE: f64 = 1e-6;

/// The smallest parts that a law speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// One bilateral row.
    Row,
    Ray,
    /// One row with a bounded force.
    Interval,
    /// Three rows.
    Cone,
    /// One row or two, within a multiple of the normal force of a cone.
    Spin,
    Roll,
}

impl Kind {
    /// Whether its force is bounded by the normal force of a cone.
    pub(super) fn is_moment(self) -> bool {
        matches!(self, Self::Spin | Self::Roll)
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Unit<T = f64> {
    pub(super) kind: Kind,
    /// The first row.
    pub(super) row: usize,
    /// The block of the problem that it belongs to.
    pub(super) block: usize,
    /// Whether it gives way without a force and so takes no part.
    pub(super) absent: bool,
    /// Friction of a cone; bound of an interval, scaled; that of a moment beside the normal force, scaled; 0 for others.
    pub(super) mu: T,
    /// Of a moment: the unit of its cone.
    pub(super) cone: usize,
}

impl<T> Unit<T> {
    pub(super) fn rows(&self) -> usize {
        match self.kind {
            Kind::Cone => 3,
            Kind::Roll => 2,
            _ => 1,
        }
    }
}

/// y = W f + g with  f = s f′,  y = y′ / s:  W′ = s W s,  g′ = s g.
///
/// s is the same in the rows of a cone, which keeps cones and products as they are, and such that the diagonal of W′ is 1 on average:
/// then f′ and y′ have the same unit, √J, and no weights are needed between them.
#[derive(Clone, Debug)]
pub(super) struct System<T = f64> {
    pub(super) n: usize,
    pub(super) law: Law,
    pub(super) units: Vec<Unit<T>>,
    /// W′ by columns.
    pub(super) w: Vec<T>,
    pub(super) g: Vec<T>,
    /// s, for each row.
    pub(super) scale: Vec<T>,
    /// Whether the rows' own regularisation, beside their size, is so large that W′ is regular.
    pub(super) is_regularized: bool,
}

impl<T> Default for System<T> {
    fn default() -> Self {
        Self {
            n: 0,
            law: Law::default(),
            units: Vec::new(),
            w: Vec::new(),
            g: Vec::new(),
            scale: Vec::new(),
            is_regularized: false,
        }
    }
}

impl System {
    /// Reads one lane. `false` if a number is not finite.
    pub(super) fn load<T: Scalar>(&mut self, problem: &ConeProblem<'_, T>, lane: usize) -> bool {
        let n = problem.free_velocity.len();
        (self.n, self.law) = (n, problem.law);
        read(problem.matrix, lane, &mut self.w);
        read(problem.free_velocity, lane, &mut self.g);
        let is_infinite = |row: usize| problem.regularization[row].value(lane) == f64::INFINITY;
        let friction = |block: usize| problem.friction[block].value(lane);
        self.list_units(problem.blocks, is_infinite, friction);
        let regularization = |i: usize| problem.regularization[i].value(lane);
        for i in 0..n {
            self.w[i * n + i] += regularization(i);
        }
        self.take_out_what_is_absent();
        self.scale.resize(n, 1.0);
        self.find_scale();
        self.scale_bounds();
        let mut finite = true;
        // Without an early end, which would keep numbers from being worked on together.
        self.rescale(|x| finite &= x.is_finite());
        let scaled = |i: usize| regularization(i) * self.scale[i] * self.scale[i];
        self.is_regularized = (0..n).map(scaled).all(|r| r > REGULARIZED_ABOVE);
        finite && self.units.iter().all(|unit| unit.mu.is_finite())
    }

    /// Units whose rows give way without a force have none, and do not couple to others: their entries would swamp those of the rest.
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
        // Of a problem with blocks there is none.
        let diagonal = self.w.iter_mut().step_by(self.n + 1);
        diagonal.for_each(|w| *w = 1.0);
        for unit in &mut self.units {
            unit.mu = 0.0;
        }
    }
}

impl<T: Scalar> System<T> {
    /// Lists the units of blocks.
    ///
    /// * `is_infinite` – whether a row gives way without a force
    /// * `friction` – μ of a block that is a cone, b of one that is an interval
    pub(super) fn list_units(
        &mut self,
        blocks: &[Block],
        is_infinite: impl Fn(usize) -> bool,
        friction: impl Fn(usize) -> T,
    ) {
        self.units.clear();
        let (mut row, mut cone) = (0, None);
        for (block, kind) in blocks.iter().enumerate() {
            let mut absent = (row..row + kind.rows()).any(&is_infinite);
            match kind {
                Block::Cone => cone = Some(self.units.len()).filter(|_| !absent),
                Block::Spin | Block::Roll => absent |= cone.is_none(),
                _ => {}
            }
            let (kind, count) = match kind {
                Block::Ray if !absent => (Kind::Ray, 1),
                Block::Cone if !absent => (Kind::Cone, 1),
                Block::Spin if !absent => (Kind::Spin, 1),
                Block::Roll if !absent => (Kind::Roll, 1),
                Block::Interval if !absent && !is_infinite_bound(friction(block)) => {
                    (Kind::Interval, 1)
                }
                // Rows by themselves: a unit that takes no part has no law.
                other => (Kind::Row, other.rows()),
            };
            let mu = match kind {
                Kind::Row | Kind::Ray => T::zero(),
                _ => friction(block),
            };
            for _ in 0..count {
                let unit = Unit {
                    kind,
                    row,
                    block,
                    absent,
                    mu,
                    cone: cone.unwrap_or(0),
                };
                row += unit.rows();
                self.units.push(unit);
            }
        }
    }

    /// Finds s from the diagonal of W.
    pub(super) fn find_scale(&mut self) {
        let n = self.n;
        let diagonal = |i: usize| self.w[i * n + i].detached();
        find_scale(&self.units, diagonal, &mut self.scale);
    }

    /// b′ = b / s of intervals, c′ = c sₙ / s of moments.
    pub(super) fn scale_bounds(&mut self) {
        for k in 0..self.units.len() {
            let (unit, scale) = (self.units[k], &self.scale);
            if unit.kind == Kind::Interval {
                self.units[k].mu /= scale[unit.row];
            } else if unit.kind.is_moment() {
                self.units[k].mu = unit.mu * (scale[self.normal(&unit)] / scale[unit.row]);
            }
        }
    }

    /// Row of the normal whose force bounds a moment.
    pub(super) fn normal<M>(&self, unit: &Unit<M>) -> usize {
        self.units[unit.cone].row
    }

    /// The unit of a moment with its bound, c′ fₙ, for the law of its own rows; `None` for others.
    pub(super) fn bounded(&self, unit: &Unit<T>, f: &[T]) -> Option<Unit<T>> {
        unit.kind.is_moment().then(|| Unit {
            mu: unit.mu * f[self.normal(unit)].max(T::zero()),
            ..*unit
        })
    }

    /// W′ = s W s,  g′ = s g. Each of these numbers is shown to `look`.
    #[inline(always)]
    pub(super) fn rescale(&mut self, mut look: impl FnMut(T)) {
        let (n, scale) = (self.n, &self.scale);
        for (g, &scale) in pairs(&mut self.g, scale) {
            *g *= scale;
            look(*g);
        }
        for (column, &scale_of_column) in pairs(self.w.chunks_exact_mut(n.max(1)), scale) {
            let scale = &scale[..column.len()];
            for (i, x) in column.iter_mut().enumerate() {
                *x *= scale[i] * scale_of_column;
                look(*x);
            }
        }
    }

    /// y ← W f + g.
    pub(super) fn velocities(&self, f: &[T], g: &[T], y: &mut [T]) {
        y.copy_from_slice(g);
        for (column, &f) in pairs(self.w.chunks_exact(self.n.max(1)), f) {
            if !f.is_zero() {
                let y = &mut y[..column.len()];
                for i in 0..column.len() {
                    y[i] += column[i] * f;
                }
            }
        }
    }
}

/// Finds s of the rows of all units from the diagonal of W.
pub(super) fn find_scale<T: Scalar>(
    units: &[Unit<T>],
    diagonal: impl Fn(usize) -> T,
    scale: &mut [T],
) {
    let zero = T::zero();
    let all = (0..scale.len()).map(&diagonal);
    let largest = all.fold(zero, |most, x| x.max(most));
    for unit in units {
        let rows = unit.row..unit.row + unit.rows();
        let sum = rows.clone().map(&diagonal).fold(zero, |sum, x| sum + x);
        let mean = sum / unit.rows() as f64;
        let size = (largest * NO_DIAGONAL).select_lt(mean, mean, largest);
        let positive = zero.select_lt(size, size, T::one());
        scale[rows].fill(T::one() / positive.sqrt());
    }
}

/// Whether a bound is none.
fn is_infinite_bound<T: Scalar>(bound: T) -> bool {
    bound.has_value() && bound.value(0) == f64::INFINITY
}

pub(super) fn read<T: Scalar>(from: &[T], lane: usize, to: &mut Vec<f64>) {
    to.clear();
    to.extend(from.iter().map(|x| x.value(lane)));
}

/// Force and velocity of a unit; zeros after the last row.
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

/// The rows of a unit; zeros after the last.
#[inline(always)]
pub(super) fn of_unit<T: Scalar, M>(x: &[T], unit: &Unit<M>) -> [T; 3] {
    let first = unit.row;
    match unit.kind {
        Kind::Cone => [x[first], x[first + 1], x[first + 2]],
        Kind::Roll => [x[first], x[first + 1], T::zero()],
        _ => [x[first], T::zero(), T::zero()],
    }
}
