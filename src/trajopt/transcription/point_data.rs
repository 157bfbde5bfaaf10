//! Data of one point: its rate, its costs, its constraints.

use nalgebra::DMatrix;

use super::chart::ChartScratch;
use super::defects::Flow;
use super::points::{self, Sample, stage_of};
use crate::nested::IntoNested;
use crate::trajopt::constraint::Constraint;
use crate::trajopt::cost::{Expansion, Point};
use crate::trajopt::problem::Problem;
use crate::trajopt::residual::ResidualJacobian;
use crate::trajopt::scratch::Scratch;

/// One point.
#[derive(Clone, Debug)]
pub(super) struct PointData {
    pub(super) flow: Flow,
    /// Costs; of the Hessian the upper triangle.
    pub(super) cost: Expansion,
    /// The entries of constraints that bound anything.
    pub(super) entries: Vec<Entry>,
    /// Their derivatives in (δx, δu), a column for each.
    pub(super) slopes: DMatrix<f64>,
}

/// lower ≤ value ≤ upper.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) value: f64,
    pub(super) lower: f64,
    pub(super) upper: f64,
}

/// Working memory of one thread.
pub(super) struct Memory {
    scratch: Scratch,
    residual: ResidualJacobian,
    pub(super) chart: ChartScratch,
}

impl Memory {
    pub(super) fn new(problem: &Problem) -> Self {
        let system = problem.dynamics();
        Self {
            scratch: Scratch::new(),
            residual: ResidualJacobian::new(system, problem.largest_dim()),
            chart: ChartScratch::new(system),
        }
    }
}

impl Entry {
    /// Violation of the bounds by the value; infinite where it is NaN.
    pub(super) fn excess(&self) -> f64 {
        if self.value.is_nan() {
            return f64::INFINITY;
        }
        (self.value - self.upper)
            .max(self.lower - self.value)
            .max(0.0)
    }
}

impl PointData {
    pub(super) fn new(problem: &Problem, i: usize) -> Self {
        let (system, mut entries) = (problem.dynamics(), Vec::new());
        let nz = system.ndx() + system.nu();
        for (_, constraint) in constraints(problem, i) {
            entries.extend(bounded(constraint).map(|row| Entry {
                value: 0.0,
                lower: constraint.lower()[row],
                upper: constraint.upper()[row],
            }));
        }
        Self {
            flow: Flow::new(system),
            cost: Expansion::zeros(nz),
            slopes: DMatrix::zeros(nz, entries.len()),
            entries,
        }
    }

    /// Values of all there is, without derivatives.
    pub(super) fn measure(
        &mut self,
        problem: &Problem,
        i: usize,
        sample: Sample<'_>,
        memory: &mut Memory,
    ) {
        let Sample { x, u } = sample;
        let (system, rate) = (problem.dynamics(), self.flow.rate.as_mut_slice());
        system.rate(x, u, &mut memory.scratch, rate);
        let memory = &mut memory.residual;
        self.cost.value = points::cost(problem, i, sample, memory);
        let mut entries = self.entries.iter_mut();
        for (stage, constraint) in constraints(problem, i) {
            let values = constraint.values(at(problem, stage, x, u), memory);
            for (row, entry) in bounded(constraint).zip(entries.by_ref()) {
                entry.value = values[row];
            }
        }
    }

    /// Values with derivatives.
    pub(super) fn expand(
        &mut self,
        problem: &Problem,
        i: usize,
        sample: Sample<'_>,
        memory: &mut Memory,
    ) {
        let Sample { x, u } = sample;
        let (system, flow, scratch) = (problem.dynamics(), &mut self.flow, &mut memory.scratch);
        system.rate(x, u, scratch, flow.rate.as_mut_slice());
        system.linearize_rate(x, u, scratch, &mut flow.jacobian);
        let memory = &mut memory.residual;
        points::expand_cost(problem, i, sample, memory, &mut self.cost);
        let (entries, slopes, mut next) = (&mut self.entries, &mut self.slopes, 0);
        for (stage, constraint) in constraints(problem, i) {
            constraint.linearize_at(at(problem, stage, x, u), memory);
            for row in bounded(constraint) {
                entries[next].value = memory.values[row];
                slopes.column_mut(next).copy_from_slice(memory.row(row));
                next += 1;
            }
        }
    }
}

/// The constraints at a point with their stages: those of the interval, and at the last node those of the last state
/// too.
fn constraints(problem: &Problem, i: usize) -> impl Iterator<Item = (usize, &Constraint)> {
    let n = problem.horizon();
    let path = (n > 0).then(|| stage_of(problem, i));
    let stages = path.into_iter().chain((i == 2 * n).then_some(n));
    stages.nested(|stage| {
        let own = problem.constraints_at(stage).iter();
        own.map(move |constraint| (stage, constraint))
    })
}

/// Point at which a residual of a stage is evaluated; at the end of the horizon there is no input.
fn at<'a>(problem: &'a Problem, stage: usize, x: &'a [f64], u: &'a [f64]) -> Point<'a> {
    let u = if stage == problem.horizon() { &[] } else { u };
    Point::new(problem.dynamics(), problem.stage_of_motion(stage), x, u)
}

/// The rows that are bounded at all.
fn bounded(constraint: &Constraint) -> impl Iterator<Item = usize> {
    let both = constraint
        .lower()
        .iter()
        .zip(constraint.upper())
        .enumerate();
    let finite = both.filter(|(_, (lower, upper))| lower.is_finite() || upper.is_finite());
    finite.map(|(row, _)| row)
}
