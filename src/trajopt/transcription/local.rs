//! Data of one point: its rate, its costs, its constraints.

use nalgebra::DMatrix;

use super::chart::ChartScratch;
use super::defects::Flow;
use super::points::{self, stage_of};
use crate::trajopt::constraint::Constraint;
use crate::trajopt::continuous::{ContinuousDynamics, Rates};
use crate::trajopt::cost::Expansion;
use crate::trajopt::problem::Problem;
use crate::trajopt::residual::ResidualJacobian;

/// One point.
#[derive(Clone, Debug)]
pub(super) struct Local {
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
pub(super) struct Worker<D> {
    pub(super) rates: Box<dyn Rates<D>>,
    pub(super) memory: ResidualJacobian,
    pub(super) chart: ChartScratch,
}

impl<D: ContinuousDynamics> Worker<D> {
    pub(super) fn new(problem: &Problem<D>) -> Self {
        let dynamics = problem.dynamics();
        Self {
            rates: dynamics.rates(),
            memory: ResidualJacobian::new(dynamics, problem.largest_dim()),
            chart: ChartScratch::new(dynamics),
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

impl Local {
    pub(super) fn new<D: ContinuousDynamics>(problem: &Problem<D>, i: usize) -> Self {
        let dynamics = problem.dynamics();
        let nz = dynamics.ndx() + dynamics.nu();
        let bounds = constraints(problem, i).flat_map(|(constraint, _)| {
            let bounds = constraint.lower().iter().zip(constraint.upper());
            bounds.filter(|bounds| is_bound(*bounds))
        });
        let entries: Vec<_> = bounds
            .map(|(&lower, &upper)| Entry {
                value: 0.0,
                lower,
                upper,
            })
            .collect();
        Self {
            flow: Flow::new(dynamics),
            cost: Expansion::zeros(nz),
            slopes: DMatrix::zeros(nz, entries.len()),
            entries,
        }
    }

    /// Values of all there is, without derivatives.
    pub(super) fn measure<D: ContinuousDynamics>(
        &mut self,
        problem: &Problem<D>,
        i: usize,
        (x, u): (&[f64], &[f64]),
        worker: &mut Worker<D>,
    ) {
        let (dynamics, memory) = (problem.dynamics(), &mut worker.memory);
        worker.rates.rate(dynamics, x, u, &mut self.flow.rate);
        self.cost.value = points::cost(problem, i, (x, u), memory);
        let mut entries = self.entries.iter_mut();
        for (constraint, stage) in constraints(problem, i) {
            let node = problem.node(stage);
            let values = constraint.residual(&node, x, input_at(problem, stage, u), memory);
            let bounds = constraint.lower().iter().zip(constraint.upper());
            let bounded = values.iter().zip(bounds).filter(|(_, b)| is_bound(*b));
            for ((&value, _), entry) in bounded.zip(entries.by_ref()) {
                entry.value = value;
            }
        }
    }

    /// Values with derivatives.
    pub(super) fn expand<D: ContinuousDynamics>(
        &mut self,
        problem: &Problem<D>,
        i: usize,
        (x, u): (&[f64], &[f64]),
        worker: &mut Worker<D>,
    ) {
        let (dynamics, memory) = (problem.dynamics(), &mut worker.memory);
        let flow = &mut self.flow;
        worker.rates.rate(dynamics, x, u, &mut flow.rate);
        worker.rates.linearize(dynamics, x, u, &mut flow.jacobian);
        points::expand_cost(problem, i, (x, u), memory, &mut self.cost);
        let mut next = 0;
        for (constraint, stage) in constraints(problem, i) {
            let u = input_at(problem, stage, u);
            constraint.linearize(dynamics, problem.first_stage() + stage, x, u, memory);
            let bounds = constraint.lower().iter().zip(constraint.upper());
            for (row, _) in bounds.enumerate().filter(|(_, b)| is_bound(*b)) {
                self.entries[next].value = memory.values[row];
                self.slopes
                    .column_mut(next)
                    .copy_from_slice(memory.row(row));
                next += 1;
            }
        }
    }
}

/// The constraints at a point with their stages: those of the interval, and at the last node those of the last state too.
fn constraints<D: ContinuousDynamics>(
    problem: &Problem<D>,
    i: usize,
) -> impl Iterator<Item = (&Constraint<D>, usize)> {
    let n = problem.horizon();
    let path: &[_] = if n > 0 { problem.constraints() } else { &[] };
    let last: &[_] = if i == 2 * n {
        problem.final_constraints()
    } else {
        &[]
    };
    let stage = stage_of(problem, i);
    let path = path.iter().map(move |constraint| (constraint, stage));
    path.chain(last.iter().map(move |constraint| (constraint, n)))
}

/// At the end of the horizon there is no input.
fn input_at<'u, D: ContinuousDynamics>(
    problem: &Problem<D>,
    stage: usize,
    u: &'u [f64],
) -> &'u [f64] {
    if stage == problem.horizon() { &[] } else { u }
}

fn is_bound((lower, upper): (&f64, &f64)) -> bool {
    lower.is_finite() || upper.is_finite()
}
