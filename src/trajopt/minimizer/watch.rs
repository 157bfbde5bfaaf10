//! argmin's methods under watch: what they find is kept, and they end for reasons of ours.

use std::cell::{Cell, RefCell};

use argmin::core::{
    CostFunction, Error, Gradient, Hessian, IterState, KV, Problem, Solver, State,
    TerminationReason, TerminationStatus,
};

use super::objective::{Objective, columns_of};
use crate::trajopt::status::Status;

/// Costs below minus this have no limit.
const COST_LIMIT: f64 = 1e25;
/// Improvements up to this share of 1 + |cost| are rounding.
const ROUNDING: f64 = 1e-15;
/// Values that one iteration may ask for; a line search that needs more goes nowhere.
const MOST_VALUES: usize = 200;
/// Factor on 1 + |best cost| that stands for a value that is not finite in a line search. Infinity would make its
/// interpolation not a number; a much larger value would make it too cautious.
const NOT_FINITE: f64 = 1e3;

/// State of argmin's methods that know gradients, and matrices `H` of second derivatives.
pub(super) type Iterate<H> = IterState<Vec<f64>, Vec<f64>, (), H, (), f64>;

/// The function that a method sees, and a record of what it finds.
pub(super) struct Watch<'a> {
    objective: &'a dyn Objective,
    limits: Limits,
    values: Cell<usize>,
    record: RefCell<Record<'a>>,
}

/// Tolerances and scale of one run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Tolerance of the gradient, as a share of 1 + cost (of one where costs are below zero).
    pub(super) tolerance: f64,
    /// Iterations without improvement after which a method has stalled.
    pub(super) patience: usize,
    /// Factor on costs and derivatives as the method sees them.
    pub(super) scale: f64,
}

/// One iteration, for a callback.
#[derive(Clone, Copy, Debug)]
pub(in crate::trajopt) struct Iteration {
    /// Number of the iteration, from 1.
    pub(in crate::trajopt) iteration: usize,
    /// The best value so far.
    pub(in crate::trajopt) value: f64,
    /// Largest entry of the gradient there.
    pub(in crate::trajopt) gradient: f64,
    /// Length of the step that the best point made, zero if the iteration found none better.
    pub(in crate::trajopt) step: f64,
}

/// Start of a run.
pub(super) struct Start {
    /// The variables.
    pub(super) z: Vec<f64>,
    /// Iterations of the runs before.
    pub(super) iterations: usize,
}

/// Best point so far, and the record of the run.
pub(super) struct Record<'a> {
    pub(super) z: Vec<f64>,
    pub(super) cost: f64,
    pub(super) gradient: f64,
    pub(super) iterations: usize,
    pub(super) history: &'a mut Vec<f64>,
    pub(super) status: Option<Status>,
    idle: usize,
    report: &'a mut dyn FnMut(&Iteration),
}

impl<'a> Watch<'a> {
    /// Makes a watch whose record begins with the start.
    pub(super) fn new(
        objective: &'a dyn Objective,
        limits: Limits,
        start: Start,
        history: &'a mut Vec<f64>,
        report: &'a mut dyn FnMut(&Iteration),
    ) -> Self {
        let Start { z, iterations } = start;
        let cost = objective.value(&z);
        let mut record = Record {
            z,
            cost,
            gradient: f64::INFINITY,
            iterations,
            history,
            status: None,
            idle: 0,
            report,
        };
        if cost.is_finite() {
            record.measure_gradient(objective, limits.tolerance);
        } else {
            record.status = Some(Status::Diverged);
        }
        Self {
            objective,
            limits,
            values: Cell::new(0),
            record: RefCell::new(record),
        }
    }

    /// Number of variables.
    pub(super) fn dim(&self) -> usize {
        self.record.borrow().z.len()
    }

    /// Point and number of iterations from which a run starts.
    pub(super) fn start(&self) -> Start {
        let record = self.record.borrow();
        Start {
            z: record.z.clone(),
            iterations: record.iterations,
        }
    }

    pub(super) fn into_record(self) -> Record<'a> {
        self.record.into_inner()
    }

    pub(super) fn status(&self) -> Option<Status> {
        self.record.borrow().status
    }

    /// Takes note of an iterate.
    fn note(&self, z: Option<&Vec<f64>>, cost: f64) {
        self.values.set(0);
        let record = &mut *self.record.borrow_mut();
        let improvement = record.cost - cost;
        record.idle += 1;
        if improvement > ROUNDING * (1.0 + cost.abs()) {
            record.idle = 0;
        }
        let mut step = 0.0;
        if let (Some(z), true) = (z, improvement > 0.0) {
            step = distance(z, &record.z);
            (record.z, record.cost) = (z.clone(), cost);
            record.measure_gradient(self.objective, self.limits.tolerance);
        }
        record.iterations += 1;
        record.history.push(record.cost);
        (record.report)(&Iteration {
            iteration: record.iterations,
            value: record.cost,
            gradient: record.gradient,
            step,
        });
        if record.cost < -COST_LIMIT {
            record.status = Some(Status::Diverged);
        } else if record.idle >= self.limits.patience {
            record.status = record.status.or(Some(Status::LineSearchStalled));
        }
    }
}

impl Record<'_> {
    fn measure_gradient(&mut self, objective: &dyn Objective, tolerance: f64) {
        let gradient = objective.gradient(&self.z);
        let largest = |max: f64, g: &f64| {
            if g.is_nan() {
                f64::INFINITY
            } else {
                max.max(g.abs())
            }
        };
        self.gradient = gradient.iter().fold(0.0, largest);
        // Not relative to costs below zero: where they have no limit, they outgrow any gradient.
        if self.gradient <= tolerance * (1.0 + self.cost.max(0.0)) {
            self.status = Some(Status::Converged);
        }
    }
}

fn distance(z: &[f64], from: &[f64]) -> f64 {
    let squares = z.iter().zip(from).map(|(z, from)| (z - from).powi(2));
    squares.sum::<f64>().sqrt()
}

impl CostFunction for &Watch<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, z: &Vec<f64>) -> Result<f64, Error> {
        self.values.set(self.values.get() + 1);
        if self.values.get() > MOST_VALUES {
            return Err(Error::msg("an iteration goes nowhere"));
        }
        let value = self.objective.value(z);
        if value < -COST_LIMIT {
            // A line search would go on; the note ends the run.
            self.note(Some(z), value);
            return Err(Error::msg("a cost without limit"));
        }
        if value.is_finite() {
            return Ok(value * self.limits.scale);
        }
        let best = self.record.borrow().cost;
        Ok(NOT_FINITE * (1.0 + best.abs()) * self.limits.scale)
    }
}

impl Gradient for &Watch<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, z: &Vec<f64>) -> Result<Vec<f64>, Error> {
        let mut gradient: Vec<f64> = self.objective.gradient(z).data.into();
        let are_finite = gradient.iter().all(|g| g.is_finite());
        if !are_finite {
            gradient.fill(0.0);
        }
        gradient.iter_mut().for_each(|g| *g *= self.limits.scale);
        Ok(gradient)
    }
}

impl Hessian for &Watch<'_> {
    type Param = Vec<f64>;
    type Hessian = Vec<Vec<f64>>;

    fn hessian(&self, z: &Vec<f64>) -> Result<Vec<Vec<f64>>, Error> {
        let mut hessian = columns_of(&self.objective.hessian(z));
        if hessian.iter().flatten().any(|h| !h.is_finite()) {
            return Err(Error::msg("a Hessian that is not finite"));
        }
        let entries = hessian.iter_mut().flatten();
        entries.for_each(|h| *h *= self.limits.scale);
        Ok(hessian)
    }
}

/// A method of argmin that ends when its watch says so, and not before.
pub(super) struct Watched<'w, 'a, S> {
    pub(super) method: S,
    pub(super) watch: &'w Watch<'a>,
}

impl<O, S, H> Solver<O, Iterate<H>> for Watched<'_, '_, S>
where
    S: Solver<O, Iterate<H>>,
    H: Clone,
{
    fn name(&self) -> &str {
        self.method.name()
    }

    fn init(
        &mut self,
        problem: &mut Problem<O>,
        state: Iterate<H>,
    ) -> Result<(Iterate<H>, Option<KV>), Error> {
        self.method.init(problem, state)
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<O>,
        state: Iterate<H>,
    ) -> Result<(Iterate<H>, Option<KV>), Error> {
        let (state, kv) = self.method.next_iter(problem, state)?;
        let cost = state.get_cost() / self.watch.limits.scale;
        self.watch.note(state.get_param(), cost);
        Ok((state, kv))
    }

    fn terminate(&mut self, _: &Iterate<H>) -> TerminationStatus {
        match self.watch.status() {
            Some(status) => {
                TerminationStatus::Terminated(TerminationReason::SolverExit(status.to_string()))
            }
            None => TerminationStatus::NotTerminated,
        }
    }
}
