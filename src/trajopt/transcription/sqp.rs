//! The sequence of quadratic programs: expand, solve, search along the step, until nothing is left to improve.

use super::approximation::Approximation;
use super::curve::Curve;
use super::merit::{Merit, PredictedReduction};
use super::options::TranscriptionOptions;
use super::points::Points;
use super::qp::{QpData, Step, Weights};
use super::solution::{Continuous, TranscriptionSolution};
use crate::minimize::{COST_LIMIT, Status};
use crate::nested::IntoNested;
use crate::stop::is_stopped;
use crate::trajopt::problem::Problem;
use crate::trajopt::progress::Progress;
use crate::trajopt::solution::Solution;
use crate::trajopt::trajectory::Trajectory;

/// A merit that falls by this share of what the model predicts, or more, tells that the model is good: the
/// regularisation falls.
const GOOD: f64 = 0.75;
/// One that falls by this share or less tells that it is not: the regularisation rises.
const BAD: f64 = 0.25;

/// One run of the solver.
pub(super) struct SqpSolver<'a> {
    problem: &'a Problem,
    options: &'a TranscriptionOptions,
    points: Points,
    trial: Points,
    approximation: Approximation,
    qp: QpData,
    weights: Weights,
    /// ν of each defect in the merit.
    defect_weights: Vec<f64>,
    merit: Merit,
    /// Multipliers of all rows of the last program.
    row_multipliers: Vec<f64>,
    iterations: usize,
    cost_history: Vec<f64>,
}

impl<'a> SqpSolver<'a> {
    /// A solver that starts from a guess.
    pub(super) fn from_trajectory(
        problem: &'a Problem,
        options: &'a TranscriptionOptions,
        guess: &Trajectory,
    ) -> Self {
        guess.check(problem);
        Self::new(problem, options, Points::from_trajectory(problem, guess))
    }

    /// A solver that starts from the curve of a former solution.
    pub(super) fn from_curve(
        problem: &'a Problem,
        options: &'a TranscriptionOptions,
        curve: &Curve,
    ) -> Self {
        curve.check(problem);
        Self::new(
            problem,
            options,
            Points::interleaved(
                problem,
                [&curve.states, &curve.middle_states],
                [&curve.inputs, &curve.middle_inputs],
            ),
        )
    }

    fn new(problem: &'a Problem, options: &'a TranscriptionOptions, points: Points) -> Self {
        let mut approximation = Approximation::new(problem, options.threads);
        let qp = QpData::new(problem, &approximation);
        let defect_weights = vec![0.0; qp.layout.defects().len()];
        let merit = approximation.measure(problem, &points, &defect_weights);
        Self {
            problem,
            options,
            trial: points.clone(),
            points,
            approximation,
            qp,
            weights: Weights {
                regularization: options.regularization.start,
                penalty: options.constraints.penalty,
            },
            defect_weights,
            merit,
            row_multipliers: Vec::new(),
            iterations: 0,
            cost_history: vec![merit.cost],
        }
    }

    pub(super) fn run(mut self, report: &mut dyn FnMut(&Progress)) -> TranscriptionSolution {
        let starts = self.points.is_finite() && self.merit.cost.is_finite();
        let starts = starts && self.merit.gap.is_finite() && self.merit.violation.is_finite();
        let status = match starts {
            true => self.iterate(report),
            false => Status::Diverged,
        };
        let curve = Curve::new(self.problem, &self.points);
        let (layout, rows) = (&self.qp.layout, &self.row_multipliers);
        Solution {
            status,
            trajectory: curve.nodes(),
            own: Continuous { curve },
            iterations: self.iterations,
            cost: self.merit.cost,
            cost_history: self.cost_history,
            violation: self.merit.violation,
            gap: self.merit.gap,
            multipliers: layout.entry_multipliers(&self.approximation, rows),
        }
    }

    fn iterate(&mut self, report: &mut dyn FnMut(&Progress)) -> Status {
        loop {
            if is_stopped() {
                return Status::Stopped;
            }
            self.approximation.expand(self.problem, &self.points);
            self.qp
                .refresh(self.problem, &self.approximation, &self.points);
            let found = self.direction();
            if is_stopped() {
                return Status::Stopped;
            }
            let Some(step) = found else {
                return Status::NotConvex;
            };
            self.row_multipliers.clone_from(&step.multipliers);
            if let Some(status) = self.verdict(&step) {
                return status;
            }
            if self.iterations >= self.options.max_iterations {
                return Status::IterationLimit;
            }
            let predicted = self.predict(&step);
            let alpha = self.search(step, predicted);
            self.iterations += 1;
            self.cost_history.push(self.merit.cost);
            report(&self.progress(alpha, predicted));
            if self.merit.cost.abs() > COST_LIMIT {
                return Status::Diverged;
            }
            if !self.adapt_regularization(alpha, predicted) {
                return Status::LineSearchStalled;
            }
        }
    }

    /// The step of the program; none where no regularisation within its limit makes it convex and solvable.
    fn direction(&mut self) -> Option<Step> {
        loop {
            if is_stopped() {
                return None;
            }
            if let Some(step) = self.weighted_step() {
                return Some(step);
            }
            if self.weights.regularization >= self.options.regularization.max {
                return None;
            }
            self.raise_regularization();
        }
    }

    /// The step, with a weight of violations that is raised as long as that leaves less of them.
    fn weighted_step(&mut self) -> Option<Step> {
        let decrease = self.options.constraints.violation_decrease;
        let mut step = self.qp.solve(&mut self.approximation, self.weights)?;
        loop {
            let left: f64 = step.slacks.iter().sum();
            let largest = step.slacks.iter().fold(0.0, |max: f64, &s| max.max(s));
            let raised = self.raised_penalty();
            if largest <= self.options.constraints.tolerance || raised <= self.weights.penalty {
                return Some(step);
            }
            let weights = Weights {
                penalty: raised,
                ..self.weights
            };
            match self.qp.solve(&mut self.approximation, weights) {
                Some(other) if other.slacks.iter().sum::<f64>() <= decrease * left => {
                    (step, self.weights) = (other, weights);
                }
                _ => return Some(step),
            }
        }
    }

    /// Termination status, if the solver ends here.
    fn verdict(&mut self, step: &Step) -> Option<Status> {
        let scale = 1.0 + self.qp.largest_gradient();
        let error = self.qp.optimality_error(step);
        let obeys = self.merit.gap <= self.options.gap_tolerance;
        if error > self.options.tolerance * scale || !obeys {
            return None;
        }
        if self.merit.violation <= self.options.constraints.tolerance {
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
        let raised = self.weights.penalty * self.options.constraints.penalty_increase;
        raised.min(self.options.constraints.max_penalty)
    }

    /// Weights of the defects that make the step one of descent, and the merit that is predicted along it.
    fn predict(&mut self, step: &Step) -> PredictedReduction {
        let multipliers = self.qp.defect_multipliers(step);
        for (nu, lambda) in self.defect_weights.iter_mut().zip(multipliers) {
            // [Powell 1978]: large enough, and falling slowly where they were larger.
            *nu = lambda.abs().max(0.5 * (*nu + lambda.abs()));
        }
        self.merit = self.approximation.merit(&self.defect_weights);
        let left: f64 = step.slacks.iter().sum();
        let violations = self.merit.violations - left.min(self.merit.violations);
        let falls = self.merit.weighed_defects + self.weights.penalty * violations;
        PredictedReduction {
            merit: self.merit.total(self.weights.penalty),
            slope: (self.qp.slope(step) - falls).min(0.0),
        }
    }

    /// The share of the step that was taken; zero if none was.
    fn search(&mut self, step: Step, predicted: PredictedReduction) -> f64 {
        if self.try_step(&step, 1.0, predicted) || self.try_corrected(&step, predicted) {
            return 1.0;
        }
        let mut alpha = 1.0;
        for _ in 1..self.options.line_search_steps {
            alpha *= 0.5;
            if is_stopped() {
                break;
            }
            if self.try_step(&step, alpha, predicted) {
                return alpha;
            }
        }
        0.0
    }

    fn try_step(&mut self, step: &Step, alpha: f64, predicted: PredictedReduction) -> bool {
        self.points
            .step(self.problem, &step.dz, alpha, &mut self.trial);
        let at = self
            .approximation
            .measure(self.problem, &self.trial, &self.defect_weights);
        let merit = at.total(self.weights.penalty);
        let accepted = self.trial.is_finite() && predicted.is_sufficient(merit, alpha);
        if accepted {
            std::mem::swap(&mut self.points, &mut self.trial);
            self.merit = at;
        }
        accepted
    }

    /// The step with a correction of second order, for where the whole step was refused because defects and constraints
    /// bend.
    fn try_corrected(&mut self, step: &Step, predicted: PredictedReduction) -> bool {
        self.qp.correct(&self.approximation, step);
        match self.qp.solve(&mut self.approximation, self.weights) {
            Some(corrected) => self.try_step(&corrected, 1.0, predicted),
            None => false,
        }
    }

    fn progress(&self, step: f64, predicted: PredictedReduction) -> Progress {
        Progress {
            step,
            gap: self.merit.gap,
            violation: self.merit.violation,
            predicted_reduction: Some(-predicted.slope),
            regularization: Some(self.weights.regularization),
            ..Progress::new(self.iterations, self.merit.cost)
        }
    }

    /// Raises the regularisation, enough to be felt beside the Hessian.
    fn raise_regularization(&mut self) {
        /// Share of the Hessian above which a regularisation shortens steps.
        const FELT: f64 = 1e-6;
        let diagonals = self.approximation.points.iter().nested(|point| {
            let hessian = &point.cost.hessian;
            (0..hessian.nrows()).map(|k| hessian[(k, k)].abs())
        });
        let largest = diagonals.fold(0.0, f64::max);
        let from = self.weights.regularization.max(FELT * largest);
        self.weights.regularization = self.options.regularization.raised(from);
    }

    /// Adapts the regularisation: less after steps that reduce the merit as predicted, more after those that do not;
    /// `false` where it would have to rise beyond its limit and no step was taken.
    fn adapt_regularization(&mut self, step: f64, predicted: PredictedReduction) -> bool {
        let regularization = self.weights.regularization;
        let achieved = predicted.achieved_share(self.merit.total(self.weights.penalty));
        if step == 1.0 && achieved >= GOOD {
            self.weights.regularization = self.options.regularization.lowered(regularization);
        } else if step == 0.0 || achieved <= BAD {
            if step == 0.0 && regularization >= self.options.regularization.max {
                return false;
            }
            self.raise_regularization();
        }
        true
    }
}
