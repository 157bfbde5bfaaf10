//! Layout of the quadratic program: meaning of its rows and columns.
//!
//! Columns: (δx, δu) of each point, then a slack for each bounded entry of a constraint. Rows, equations first: the
//! given start, the defects of each interval, inputs whose bounds leave no choice; then upper and lower bounds of the
//! other inputs, upper and lower bounds of constraints, and that slacks are not negative.

use std::ops::Range;

use clarabel::solver::{NonnegativeConeT, SupportedConeT, ZeroConeT};
use nalgebra::DVector;

use super::approximation::Approximation;
use super::point_data::{Entry, PointData};
use super::points::Points;
use super::sparse::{Sink, Sparse};
use crate::nested::IntoNested;
use crate::trajopt::problem::{InitialState, Problem};

/// Sizes of all parts.
pub(super) struct Layout {
    ndx: usize,
    /// Columns of one point.
    nz: usize,
    points: usize,
    /// Bounded entries of constraints at all points.
    entries: usize,
    /// Rows of the given start: `ndx`, or none.
    start: usize,
    /// Inputs whose bounds coincide.
    fixed: Vec<usize>,
    /// The other inputs with finite bounds, and which: 1 for upper, −1 for lower.
    bounded: Vec<(usize, f64)>,
    /// Rows of bounds of constraints.
    entry_rows: usize,
}

impl Layout {
    pub(super) fn new(problem: &Problem, at: &Approximation) -> Self {
        let system = problem.dynamics();
        let (lower, upper) = problem.input_bounds();
        let (fixed, free): (Vec<usize>, Vec<usize>) =
            (0..system.nu()).partition(|&j| lower[j] == upper[j]);
        let sides = free.into_iter().nested(|j| [(j, 1.0), (j, -1.0)]);
        let is_finite = |&(j, side): &(usize, f64)| match side > 0.0 {
            true => upper[j].is_finite(),
            false => lower[j].is_finite(),
        };
        let entries = || at.points.iter().nested(|point| &point.entries);
        Self {
            ndx: system.ndx(),
            nz: system.ndx() + system.nu(),
            points: at.points.len(),
            entries: entries().count(),
            start: match problem.initial() {
                InitialState::Fixed => system.ndx(),
                InitialState::Free => 0,
            },
            fixed,
            bounded: sides.filter(is_finite).collect(),
            entry_rows: entries().map(|entry| sides_of(entry).count()).sum(),
        }
    }

    pub(super) fn columns(&self) -> usize {
        self.points * self.nz + self.entries
    }

    /// The columns of the slacks.
    pub(super) fn slacks(&self) -> Range<usize> {
        self.points * self.nz..self.columns()
    }

    pub(super) fn rows(&self) -> usize {
        self.first_entry_row() + self.entry_rows + self.entries
    }

    /// Number of rows that are equations.
    pub(super) fn equalities(&self) -> usize {
        self.defects().end + self.points * self.fixed.len()
    }

    /// The rows of the defects.
    pub(super) fn defects(&self) -> Range<usize> {
        self.start..self.start + self.points / 2 * 2 * self.ndx
    }

    fn first_entry_row(&self) -> usize {
        self.equalities() + self.points * self.bounded.len()
    }

    pub(super) fn cones(&self) -> [SupportedConeT<f64>; 2] {
        let equalities = self.equalities();
        [
            ZeroConeT(equalities),
            NonnegativeConeT(self.rows() - equalities),
        ]
    }

    /// H + σ, the upper triangle.
    pub(super) fn hessian(&self, at: &Approximation, regularization: f64, out: &mut Sink<'_>) {
        for (i, point) in at.points.iter().enumerate() {
            let first = i * self.nz;
            for (column, values) in point.cost.hessian.column_iter().enumerate() {
                for (row, &value) in values.iter().enumerate().take(column + 1) {
                    let shift = if row == column { regularization } else { 0.0 };
                    out(first + row, first + column, value + shift);
                }
            }
        }
    }

    /// The Jacobian of all rows.
    pub(super) fn constraints(&self, at: &Approximation, out: &mut Sink<'_>) {
        (0..self.start).for_each(|k| out(k, k, 1.0));
        for (k, defects) in at.defects.iter().enumerate() {
            let first = self.start + k * 2 * self.ndx;
            for (j, block) in defects.blocks.iter().enumerate() {
                for (column, values) in block.column_iter().enumerate() {
                    let column = (2 * k + j) * self.nz + column;
                    for (row, &value) in values.iter().enumerate() {
                        out(first + row, column, value);
                    }
                }
            }
        }
        let mut row = self.defects().end;
        for i in 0..self.points {
            for &j in &self.fixed {
                out(row, i * self.nz + self.ndx + j, 1.0);
                row += 1;
            }
        }
        for i in 0..self.points {
            for &(j, side) in &self.bounded {
                out(row, i * self.nz + self.ndx + j, side);
                row += 1;
            }
        }
        let mut slack = self.slacks().start;
        for (i, point) in at.points.iter().enumerate() {
            for (entry, slopes) in point.entries.iter().zip(point.slopes.column_iter()) {
                for side in sides_of(entry) {
                    for (column, slope) in slopes.iter().enumerate() {
                        out(row, i * self.nz + column, side * slope);
                    }
                    out(row, slack, -1.0);
                    row += 1;
                }
                slack += 1;
            }
        }
        for slack in self.slacks() {
            out(row, slack, -1.0);
            row += 1;
        }
    }

    /// g of the costs; the slacks stay as they are.
    pub(super) fn gradient(&self, at: &Approximation, out: &mut [f64]) {
        let points = out.chunks_exact_mut(self.nz.max(1));
        for (out, point) in points.zip(&at.points) {
            out.copy_from_slice(point.cost.gradient.as_slice());
        }
    }

    /// Right-hand sides of all rows.
    pub(super) fn bounds(
        &self,
        problem: &Problem,
        at: &Approximation,
        points: &Points,
        out: &mut [f64],
    ) {
        let (lower, upper) = problem.input_bounds();
        let start = (0..self.start).map(|_| 0.0);
        let fixed = points.inputs.iter().nested(|u| {
            let fixed = self.fixed.iter();
            fixed.map(|&j| lower[j] - u[j])
        });
        let bounded = points.inputs.iter().nested(|u| {
            self.bounded.iter().map(|&(j, side)| match side > 0.0 {
                true => upper[j] - u[j],
                false => u[j] - lower[j],
            })
        });
        let all = start
            .chain(minus_defects(at))
            .chain(fixed)
            .chain(bounded)
            .chain(distances(at))
            .chain((0..self.entries).map(|_| 0.0));
        out.iter_mut().zip(all).for_each(|(out, x)| *out = x);
    }

    /// The multipliers of the entries of each point: of its upper bound less that of its lower one.
    ///
    /// * `of_rows` – multipliers of all rows
    pub(super) fn entry_multipliers(
        &self,
        at: &Approximation,
        of_rows: &[f64],
    ) -> Vec<DVector<f64>> {
        let mut rows = of_rows.iter().skip(self.first_entry_row());
        let mut of_entry = |entry: &Entry| -> f64 {
            let sides = sides_of(entry).zip(rows.by_ref());
            sides.map(|(side, lambda)| side * lambda).sum()
        };
        let mut of_point = |point: &PointData| {
            let entries = point.entries.iter().map(&mut of_entry);
            DVector::from_vec(entries.collect())
        };
        at.points.iter().map(&mut of_point).collect()
    }

    /// Right-hand sides with which a program finds the step from here that leads, to first order in what is corrected,
    /// where the step `dz` was to lead: those of the trajectory that it led to, plus J dz.
    pub(super) fn correct(
        &self,
        there: &Approximation,
        constraints: &Sparse,
        dz: &[f64],
        out: &mut [f64],
    ) {
        let mut product = vec![0.0; self.rows()];
        for (j, dz) in dz.iter().enumerate() {
            for (row, value) in constraints.column(j) {
                product[row] += value * dz;
            }
        }
        let defects = self.defects().zip(minus_defects(there));
        let entries = (self.first_entry_row()..).zip(distances(there));
        for (row, x) in defects.chain(entries) {
            out[row] = x + product[row];
        }
    }
}

fn minus_defects(at: &Approximation) -> impl Iterator<Item = f64> {
    let values = at.defects.iter().nested(|defects| &defects.values);
    values.map(|value| -value)
}

/// The distance of each constraint to each of its bounds; negative where it is violated.
fn distances(at: &Approximation) -> impl Iterator<Item = f64> {
    let entries = at.points.iter().nested(|point| &point.entries);
    entries.nested(|entry| {
        sides_of(entry).map(|side| match side > 0.0 {
            true => entry.upper - entry.value,
            false => entry.value - entry.lower,
        })
    })
}

/// The finite bounds of an entry: 1 for the upper, −1 for the lower.
fn sides_of(entry: &Entry) -> impl Iterator<Item = f64> {
    let upper = entry.upper.is_finite().then_some(1.0);
    let lower = entry.lower.is_finite().then_some(-1.0);
    upper.into_iter().chain(lower)
}
