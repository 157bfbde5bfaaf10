//! A function as argmin's methods see it: what they find is kept, and they end for reasons of ours.

use std::cell::{Cell, RefCell};

use argmin::core::{CostFunction, Error, Gradient, Hessian, IterState, Problem, Solver, State};

use super::Minimum;
use super::objective::{Objective, columns_of};
use super::status::{COST_LIMIT, Status};
use crate::stop::is_stopped;

/// Improvements up to this share of 1 + |cost| are rounding.
const ROUNDING: f64 = 1e-15;
/// Values that one iteration may ask for; a line search that needs more goes nowhere.
const MOST_VALUES: usize = 200;
/// Factor on 1 + |best cost| that replaces a value that is not finite in a line search. Infinity would make its
/// interpolation NaN; a much larger value would make it too cautious.
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

/// Limits and scale of one run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub(super) max_iterations: usize,
    /// Tolerance of the gradient, as a share of 1 + cost (of one where costs are below zero).
    pub(super) tolerance: f64,
    /// Iterations without improvement after which a method has stalled.
    pub(super) stall_limit: usize,
    /// Factor on costs and derivatives as the method sees them.
    pub(super) scale: f64,
}

/// One iteration, for a callback.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Iteration {
    /// Number of the iteration, from 1.
    pub(crate) iteration: usize,
    /// The best value so far.
    pub(crate) value: f64,
    /// Largest entry of the gradient there.
    pub(crate) gradient: f64,
    /// Length of the step that the best point made, zero if the iteration found none better.
    pub(crate) step: f64,
}

/// Best point so far, and how the run goes.
struct Record<'a> {
    best: &'a mut Minimum,
    gradient: f64,
    status: Option<Status>,
    idle: usize,
    report: &'a mut dyn FnMut(&Iteration),
}

impl<'a> Watch<'a> {
    /// Makes a watch whose record begins with the best point so far.
    pub(super) fn new(
        objective: &'a dyn Objective,
        limits: Limits,
        best: &'a mut Minimum,
        report: &'a mut dyn FnMut(&Iteration),
    ) -> Self {
        let mut record = Record {
            best,
            gradient: f64::INFINITY,
            status: None,
            idle: 0,
            report,
        };
        if record.best.value.is_finite() {
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

    /// Iterations of a method from the best point, until there is a status or an error of argmin: a line search that found
    /// nothing. Nothing is lost with an error: the record has the best point.
    pub(super) fn run<'w, S, H: Clone>(&'w self, mut method: S) -> Result<(), Error>
    where
        S: Solver<&'w Self, Iterate<H>>,
    {
        let start = self.record.borrow().best.x.clone();
        let mut function = Problem::new(self);
        let (mut state, _) = method.init(&mut function, Iterate::new().param(start))?;
        state.update();
        while !self.is_over() {
            (state, _) = method.next_iter(&mut function, state)?;
            self.note(state.get_param(), state.get_cost() / self.limits.scale);
            state.update();
            state.increment_iter();
        }
        Ok(())
    }

    /// The status that ended the run, if any did, and the last gradient.
    pub(super) fn end(self) -> (Option<Status>, f64) {
        let record = self.record.into_inner();
        (record.status, record.gradient)
    }

    /// Number of variables.
    pub(super) fn dim(&self) -> usize {
        self.record.borrow().best.x.len()
    }

    fn is_over(&self) -> bool {
        let mut record = self.record.borrow_mut();
        if is_stopped() {
            record.status = Some(Status::Stopped);
        }
        record.status.is_some() || record.best.iterations >= self.limits.max_iterations
    }

    /// Takes note of an iterate.
    fn note(&self, z: Option<&Vec<f64>>, cost: f64) {
        self.values.set(0);
        // Values returned after a stop signal are not valid.
        if is_stopped() {
            return;
        }
        let record = &mut *self.record.borrow_mut();
        let improvement = record.best.value - cost;
        record.idle += 1;
        if improvement > ROUNDING * (1.0 + cost.abs()) {
            record.idle = 0;
        }
        let mut step = 0.0;
        if let (Some(z), true) = (z, improvement > 0.0) {
            step = distance(z, &record.best.x);
            (record.best.x, record.best.value) = (z.clone(), cost);
            record.measure_gradient(self.objective, self.limits.tolerance);
        }
        let best = &mut *record.best;
        best.iterations += 1;
        best.history.push(best.value);
        (record.report)(&Iteration {
            iteration: best.iterations,
            value: best.value,
            gradient: record.gradient,
            step,
        });
        if best.value < -COST_LIMIT {
            record.status = Some(Status::Diverged);
        } else if record.idle >= self.limits.stall_limit {
            record.status = record.status.or(Some(Status::LineSearchStalled));
        }
    }
}

impl Record<'_> {
    fn measure_gradient(&mut self, objective: &dyn Objective, tolerance: f64) {
        let gradient = objective.gradient(&self.best.x);
        let largest = |max: f64, g: &f64| {
            if g.is_nan() {
                f64::INFINITY
            } else {
                max.max(g.abs())
            }
        };
        self.gradient = gradient.iter().fold(0.0, largest);
        // Not relative to costs below zero: where they have no limit, they outgrow any gradient.
        if self.gradient <= tolerance * (1.0 + self.best.value.max(0.0)) {
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
        if is_stopped() {
            return Err(Error::msg("a signal ends the run"));
        }
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
        let best = self.record.borrow().best.value;
        Ok(NOT_FINITE * (1.0 + best.abs()) * self.limits.scale)
    }
}

impl Gradient for &Watch<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, z: &Vec<f64>) -> Result<Vec<f64>, Error> {
        if is_stopped() {
            return Err(Error::msg("a signal ends the run"));
        }
        let mut gradient = self.objective.gradient(z);
        if !gradient.iter().all(|g| g.is_finite()) {
            gradient.fill(0.0);
        }
        Ok((gradient * self.limits.scale).data.into())
    }
}

impl Hessian for &Watch<'_> {
    type Param = Vec<f64>;
    type Hessian = Vec<Vec<f64>>;

    fn hessian(&self, z: &Vec<f64>) -> Result<Vec<Vec<f64>>, Error> {
        let hessian = self.objective.hessian(z);
        match hessian.iter().all(|h| h.is_finite()) {
            true => Ok(columns_of(&(hessian * self.limits.scale))),
            false => Err(Error::msg("a Hessian that is not finite")),
        }
    }
}
