//! Data of one point: its rate, its costs, its constraints.

use nalgebra::DMatrix;

use super::chart::ChartScratch;
use super::defects::Flow;
use super::points::{self, Sample, stage_of};
use crate::trajopt::constraint::Bounds;
use crate::trajopt::cost::Expansion;
use crate::trajopt::cost::terms::Point;
use crate::trajopt::problem::AnyProblem;
use crate::trajopt::residual::BoundResidual;
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
    pub(super) fn new(problem: &dyn AnyProblem) -> Self {
        let system = problem.system();
        Self {
            scratch: Scratch::new(),
            residual: ResidualJacobian::with_sizes(system, problem.largest_dim()),
            chart: ChartScratch::new(system),
        }
    }
}

impl Entry {
    /// Violation of the bounds by the value; infinite where it is not a number.
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
    pub(super) fn new(problem: &dyn AnyProblem, i: usize) -> Self {
        let (system, mut entries) = (problem.system(), Vec::new());
        let nz = system.ndx() + system.nu();
        each_constraint(problem, i, &mut |_, bounds, _| {
            entries.extend(bounded(bounds).map(|row| Entry {
                value: 0.0,
                lower: bounds.lower[row],
                upper: bounds.upper[row],
            }));
        });
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
        problem: &dyn AnyProblem,
        i: usize,
        sample: Sample<'_>,
        memory: &mut Memory,
    ) {
        let Sample { x, u } = sample;
        let (system, rate) = (problem.system(), self.flow.rate.as_mut_slice());
        system.rate(x, u, &mut memory.scratch, rate);
        let memory = &mut memory.residual;
        self.cost.value = points::cost(problem, i, sample, memory);
        let mut entries = self.entries.iter_mut();
        each_constraint(problem, i, &mut |stage, bounds, residual| {
            let at = at(problem, stage, x, u);
            let values = bounds.residual(residual, at, memory);
            for (row, entry) in bounded(bounds).zip(entries.by_ref()) {
                entry.value = values[row];
            }
        });
    }

    /// Values with derivatives.
    pub(super) fn expand(
        &mut self,
        problem: &dyn AnyProblem,
        i: usize,
        sample: Sample<'_>,
        memory: &mut Memory,
    ) {
        let Sample { x, u } = sample;
        let (system, flow, scratch) = (problem.system(), &mut self.flow, &mut memory.scratch);
        system.rate(x, u, scratch, flow.rate.as_mut_slice());
        system.linearize_rate(x, u, scratch, &mut flow.jacobian);
        let memory = &mut memory.residual;
        points::expand_cost(problem, i, sample, memory, &mut self.cost);
        let (entries, slopes, mut next) = (&mut self.entries, &mut self.slopes, 0);
        each_constraint(problem, i, &mut |stage, bounds, residual| {
            let at = at(problem, stage, x, u);
            memory.prepare(bounds.dim());
            residual.linearize(at.stage, at.x, at.u, memory);
            for row in bounded(bounds) {
                entries[next].value = memory.values[row];
                slopes.column_mut(next).copy_from_slice(memory.row(row));
                next += 1;
            }
        });
    }
}

/// Hands out the constraints at a point with their stages: those of the interval, and at the last node those of the
/// last state too.
fn each_constraint(
    problem: &dyn AnyProblem,
    i: usize,
    visit: &mut dyn FnMut(usize, &Bounds, &dyn BoundResidual),
) {
    let n = problem.horizon();
    let path = (n > 0).then(|| stage_of(problem, i));
    let last = (i == 2 * n).then_some(n);
    for stage in path.into_iter().chain(last) {
        problem.each_constraint(stage, &mut |bounds, residual| {
            visit(stage, bounds, residual);
        });
    }
}

/// Point at which a residual of a stage is evaluated; at the end of the horizon there is no input.
fn at<'a>(problem: &dyn AnyProblem, stage: usize, x: &'a [f64], u: &'a [f64]) -> Point<'a> {
    Point {
        stage: problem.stage_of_motion(stage),
        x,
        u: if stage == problem.horizon() { &[] } else { u },
    }
}

/// The rows that are bounded at all.
fn bounded(bounds: &Bounds) -> impl Iterator<Item = usize> {
    let both = bounds.lower.iter().zip(&bounds.upper).enumerate();
    let finite = both.filter(|(_, (lower, upper))| lower.is_finite() || upper.is_finite());
    finite.map(|(row, _)| row)
}
