//! The sequence of quadratic programs: expand, solve, search along the step, until nothing is left to improve.

use super::curve::Curve;
use super::merit::{Price, Promise};
use super::model::Model;
use super::options::TranscriptionOptions;
use super::points::Points;
use super::program::{Program, Step, Weights};
use super::solution::TranscriptionSolution;
use crate::trajopt::continuous::ContinuousDynamics;
use crate::trajopt::ddp::Progress;
use crate::trajopt::problem::Problem;
use crate::trajopt::status::Status;

/// A merit that falls by this share of what the model promises, or more, tells that the model is good: the regularisation falls.
const GOOD: f64 = 0.75;
/// One that falls by this share or less tells that it is not: the regularisation rises.
const BAD: f64 = 0.25;
/// A cost beyond this size, of whichever sign, is divergence.
const COST_LIMIT: f64 = 1e25;
/// A higher price of violations pays where it leaves at most this share of them.
const PAYS: f64 = 0.9;

/// One run of the solver.
pub(super) struct Sequence<'a, D: ContinuousDynamics> {
    problem: &'a Problem<D>,
    options: &'a TranscriptionOptions,
    points: Points,
    trial: Points,
    model: Model<D>,
    program: Program,
    weights: Weights,
    /// ν of each defect in the merit.
    defect_weights: Vec<f64>,
    price: Price,
    iterations: usize,
    cost_history: Vec<f64>,
}

impl<'a, D: ContinuousDynamics> Sequence<'a, D> {
    pub(super) fn new(
        problem: &'a Problem<D>,
        options: &'a TranscriptionOptions,
        points: Points,
    ) -> Self {
        let mut model = Model::new(problem, options.threads);
        let program = Program::new(problem, &model);
        let defect_weights = vec![0.0; program.layout.defects().len()];
        let price = model.measure(problem, &points, &defect_weights);
        Self {
            problem,
            options,
            trial: points.clone(),
            points,
            model,
            program,
            weights: Weights {
                regularization: options.regularization.start,
                penalty: options.penalty,
            },
            defect_weights,
            price,
            iterations: 0,
            cost_history: vec![price.cost],
        }
    }

    pub(super) fn run(mut self, report: &mut impl FnMut(&Progress)) -> TranscriptionSolution {
        let starts = self.points.is_finite() && self.price.cost.is_finite();
        let starts = starts && self.price.gap.is_finite() && self.price.violation.is_finite();
        let status = match starts {
            true => self.iterate(report),
            false => Status::Diverged,
        };
        let curve = Curve::new(self.problem, &self.points);
        TranscriptionSolution {
            status,
            trajectory: curve.nodes(),
            curve,
            iterations: self.iterations,
            cost: self.price.cost,
            cost_history: self.cost_history,
            violation: self.price.violation,
            gap: self.price.gap,
        }
    }

    fn iterate(&mut self, report: &mut impl FnMut(&Progress)) -> Status {
        loop {
            self.model.expand(self.problem, &self.points);
            self.program
                .refresh(self.problem, &self.model, &self.points);
            let Some(step) = self.direction() else {
                return Status::LineSearchStalled;
            };
            if let Some(status) = self.verdict(&step) {
                return status;
            }
            if self.iterations >= self.options.max_iterations {
                return Status::IterationLimit;
            }
            let promise = self.promise(&step);
            let alpha = self.search(step, promise);
            self.iterations += 1;
            self.cost_history.push(self.price.cost);
            report(&self.progress(alpha, promise));
            if self.price.cost.abs() > COST_LIMIT {
                return Status::Diverged;
            }
            if !self.adapt_regularization(alpha, promise) {
                return Status::LineSearchStalled;
            }
        }
    }

    /// The step of the program; none where no regularisation within its limit makes it convex and solvable.
    fn direction(&mut self) -> Option<Step> {
        loop {
            if let Some(step) = self.priced_step() {
                return Some(step);
            }
            if self.weights.regularization >= self.options.regularization.max {
                return None;
            }
            self.raise_regularization();
        }
    }

    /// The step, with a price of violations that is raised as long as that leaves less of them.
    fn priced_step(&mut self) -> Option<Step> {
        let mut step = self.program.solve(&self.model, self.weights)?;
        loop {
            let left: f64 = step.slacks.iter().sum();
            let largest = step.slacks.iter().fold(0.0, |max: f64, &s| max.max(s));
            let raised = self.raised_penalty();
            if largest <= self.options.constraint_tolerance || raised <= self.weights.penalty {
                return Some(step);
            }
            let weights = Weights {
                penalty: raised,
                ..self.weights
            };
            match self.program.solve(&self.model, weights) {
                Some(other) if other.slacks.iter().sum::<f64>() <= PAYS * left => {
                    (step, self.weights) = (other, weights);
                }
                _ => return Some(step),
            }
        }
    }

    /// Termination status, if the solver ends here.
    fn verdict(&mut self, step: &Step) -> Option<Status> {
        let scale = 1.0 + self.program.largest_gradient();
        let error = self.program.optimality_error(step);
        let obeys = self.price.gap <= self.options.defect_tolerance;
        if error > self.options.tolerance * scale || !obeys {
            return None;
        }
        if self.price.violation <= self.options.constraint_tolerance {
            return Some(Status::Converged);
        }
        let raised = self.raised_penalty();
        if raised <= self.weights.penalty {
            return Some(Status::Infeasible);
        }
        self.weights.penalty = raised;
        None
    }

    fn raised_penalty(&self) -> f64 {
        let raised = self.weights.penalty * self.options.penalty_increase;
        raised.min(self.options.max_penalty)
    }

    /// Weights of the defects that make the step one of descent, and what the merit promises along it.
    fn promise(&mut self, step: &Step) -> Promise {
        let multipliers = self.program.defect_multipliers(step);
        for (nu, lambda) in self.defect_weights.iter_mut().zip(multipliers) {
            // [Powell 1978]: large enough, and falling slowly where they were larger.
            *nu = lambda.abs().max(0.5 * (*nu + lambda.abs()));
        }
        self.price = self.model.price(&self.defect_weights);
        let left: f64 = step.slacks.iter().sum();
        let violations = self.price.violations - left.min(self.price.violations);
        let falls = self.price.weighed_defects + self.weights.penalty * violations;
        Promise {
            merit: self.price.merit(self.weights.penalty),
            slope: (self.program.slope(step) - falls).min(0.0),
        }
    }

    /// The share of the step that was taken; zero if none was.
    fn search(&mut self, step: Step, promise: Promise) -> f64 {
        if self.try_step(&step, 1.0, promise) || self.try_corrected(&step, promise) {
            return 1.0;
        }
        let mut alpha = 1.0;
        for _ in 1..self.options.line_search_steps {
            alpha *= 0.5;
            if self.try_step(&step, alpha, promise) {
                return alpha;
            }
        }
        0.0
    }

    fn try_step(&mut self, step: &Step, alpha: f64, promise: Promise) -> bool {
        self.points
            .step(self.problem, &step.dz, alpha, &mut self.trial);
        let price = self
            .model
            .measure(self.problem, &self.trial, &self.defect_weights);
        let merit = price.merit(self.weights.penalty);
        let accepted = self.trial.is_finite() && promise.is_kept(merit, alpha);
        if accepted {
            std::mem::swap(&mut self.points, &mut self.trial);
            self.price = price;
        }
        accepted
    }

    /// The step with a correction of second order, for where the whole step was refused because defects and constraints bend.
    fn try_corrected(&mut self, step: &Step, promise: Promise) -> bool {
        self.program.correct(&self.model, step);
        match self.program.solve(&self.model, self.weights) {
            Some(corrected) => self.try_step(&corrected, 1.0, promise),
            None => false,
        }
    }

    fn progress(&self, step: f64, promise: Promise) -> Progress {
        Progress {
            iteration: self.iterations,
            cost: self.price.cost,
            step,
            expected: promise.slope,
            regularization: self.weights.regularization,
            gap: self.price.gap,
            violation: self.price.violation,
        }
    }

    /// More, and enough to be felt beside the Hessian.
    fn raise_regularization(&mut self) {
        /// Share of the Hessian from which on a regularisation shortens steps.
        const FELT: f64 = 1e-6;
        let diagonals = self.model.locals.iter().flat_map(|local| {
            let hessian = &local.cost.hessian;
            (0..hessian.nrows()).map(|k| hessian[(k, k)].abs())
        });
        let largest = diagonals.fold(0.0, f64::max);
        let from = self.weights.regularization.max(FELT * largest);
        self.weights.regularization = self.options.regularization.raised(from);
    }

    /// Less after steps that keep their promise, more after those that do not; `false` where it would have to rise beyond its limit
    /// and no step was taken.
    fn adapt_regularization(&mut self, step: f64, promise: Promise) -> bool {
        let regularization = self.weights.regularization;
        let kept = promise.kept_share(self.price.merit(self.weights.penalty));
        if step == 1.0 && kept >= GOOD {
            self.weights.regularization = self.options.regularization.lowered(regularization);
        } else if step == 0.0 || kept <= BAD {
            if step == 0.0 && regularization >= self.options.regularization.max {
                return false;
            }
            self.raise_regularization();
        }
        true
    }
}
