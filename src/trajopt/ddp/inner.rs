//! Iterations at fixed multipliers: expand, choose a direction, search along it, until convergence.

use super::Ddp;
use super::backward::Limits;
use super::forward::{Along, Merit};
use super::predicted::{PredictedChange, predict_change};
use super::stage::ExpansionPoint;
use crate::minimize::{COST_LIMIT, Status};
use crate::nested::IntoNested;
use crate::parallel::for_each_part;
use crate::stop::is_stopped;
use crate::trajopt::curvature::Curvature;
use crate::trajopt::problem::{InitialState, Problem};
use crate::trajopt::progress::Progress;

/// Share of the expected improvement that a step has to keep.
const ACCEPTED_SHARE: f64 = 0.1;
/// Factor on the expected rise of the cost while gaps close, up to which a rise is accepted.
const ACCEPTED_RISE: f64 = 2.0;
/// Steps from this one on tell that the model is good: the regularisation falls.
const LONG_STEP: f64 = 0.5;
/// Steps down to this one tell that it is not: the regularisation rises.
const SHORT_STEP: f64 = 0.01;
/// Gaps up to this size (tangent, m or rad) count as closed.
const GAP_TOLERANCE: f64 = 1e-9;

impl Ddp {
    /// Iterations at fixed multipliers.
    pub(super) fn descend(
        &mut self,
        problem: &Problem,
        tolerance: f64,
        report: &mut dyn FnMut(&Progress),
    ) -> Status {
        loop {
            if is_stopped() {
                return Status::Stopped;
            }
            self.expand(problem, self.options.curvature);
            let (predicted, is_last) = match self.worthwhile_direction(problem, tolerance) {
                Ok(found) => found,
                Err(_) if is_stopped() => return Status::Stopped,
                Err(status) => return status,
            };
            if self.solution.iterations >= self.options.max_iterations {
                return Status::IterationLimit;
            }
            let found = self.step(problem, predicted);
            if is_stopped() {
                return Status::Stopped;
            }
            let Some((step, predicted)) = found else {
                return Status::NotConvex;
            };
            self.solution.iterations += 1;
            self.solution.cost_history.push(self.solution.cost);
            report(&self.progress(step, predicted));
            if self.merit.abs() > COST_LIMIT {
                return Status::Diverged;
            }
            if !self.adapt_regularization(step) || (is_last && step == 0.0) {
                return Status::LineSearchStalled;
            }
        }
    }

    /// Finds a direction worth a step: its predicted reduction, and whether no other is left; or the final status if
    /// there is none.
    ///
    /// A strong regularisation predicts little anywhere: it converged only where the least one predicts no more.
    fn worthwhile_direction(
        &mut self,
        problem: &Problem,
        tolerance: f64,
    ) -> Result<(PredictedChange, bool), Status> {
        let none = Status::NotConvex;
        let predicted = self.direction(problem).ok_or(none)?;
        if is_stopped() {
            return Err(Status::Stopped);
        }
        if !self.is_settled(predicted, tolerance) {
            return Ok((predicted, false));
        }
        if self.regularization > self.options.regularization.min {
            self.regularization = self.options.regularization.min;
            self.expand(problem, self.options.curvature);
            let freed = self.direction(problem).ok_or(none)?;
            if !self.is_settled(freed, tolerance) {
                return Ok((freed, true));
            }
        }
        Err(Status::Converged)
    }

    /// Whether the gaps are closed and a change is not worth a step.
    fn is_settled(&self, predicted: PredictedChange, tolerance: f64) -> bool {
        let negligible = tolerance * (1.0 + self.merit.abs());
        !self.has_gaps && predicted.change(1.0).abs() <= negligible
    }

    /// Everything to second order around the trajectory, on as many threads as there are scratches.
    fn expand(&mut self, problem: &Problem, curvature: Curvature) {
        self.measure_first_gap(problem);
        let at = ExpansionPoint {
            problem,
            trajectory: &self.solution.trajectory,
            curvature,
            penalty: self.penalty,
            has_gaps: self.has_gaps,
        };
        for_each_part(
            &mut self.scratches,
            &mut self.stages,
            |scratch, k, stage| {
                if !is_stopped() {
                    scratch.expand(&at, k, stage);
                }
            },
        );
        if self.has_gaps {
            let gaps = self.stages.iter().nested(|stage| &stage.gap);
            let largest = gaps
                .chain(&self.first_gap)
                .fold(0.0_f64, |max, gap| max.max(gap.abs()));
            self.solution.gap = largest;
            self.has_gaps = largest > GAP_TOLERANCE;
        }
    }

    fn measure_first_gap(&mut self, problem: &Problem) {
        if problem.initial() == InitialState::Free {
            return self.first_gap.fill(0.0);
        }
        let first = self.solution.trajectory.states[0].as_slice();
        let start = problem.start().as_slice();
        problem
            .dynamics()
            .difference(first, start, &mut self.first_gap);
    }

    /// The policy and the change it predicts; none where no regularisation within its limit makes the problem convex.
    ///
    /// Far from an optimum the exact Hessian is often indefinite, and a regularisation that outweighs it makes for
    /// steps so short that they lead nowhere. There the Hessian of Gauss and Newton is the better model, and only where
    /// it fails does more regularisation help.
    fn direction(&mut self, problem: &Problem) -> Option<PredictedChange> {
        let mut curvature = self.options.curvature;
        while !self.find_policy(problem, curvature) {
            if is_stopped() {
                return None;
            }
            if curvature == Curvature::Exact {
                curvature = Curvature::GaussNewton;
                self.expand(problem, curvature);
            } else if self.regularization >= self.options.regularization.max {
                return None;
            } else {
                self.regularization = self.options.regularization.raised(self.regularization);
            }
        }
        let first = &self.backward.first;
        let (dz, next) = (&mut self.dz, &mut self.next);
        Some(predict_change(&self.stages, first, dz, next))
    }

    /// Goes backward for the policy; `false` where the regularised problem has none.
    fn find_policy(&mut self, problem: &Problem, curvature: Curvature) -> bool {
        let at = ExpansionPoint {
            problem,
            trajectory: &self.solution.trajectory,
            curvature,
            penalty: self.penalty,
            has_gaps: true,
        };
        let (mu, limits) = (self.regularization, self.limits);
        let (stages, gap) = (&mut self.stages, &self.first_gap);
        self.backward.run(&at, stages, gap, mu, limits).is_ok()
    }

    /// Takes a step, and returns it with the change that its direction predicted; none where no direction is left.
    ///
    /// An input at its bound has no feedback: the rollout of an unstable system diverges, and only short steps remain. So if the full step does not
    /// improve as predicted, the policy may ignore the bounds, which the forward pass still applies: from the guess until its gaps are closed or it
    /// fails, and later for full steps only.
    fn step(
        &mut self,
        problem: &Problem,
        predicted: PredictedChange,
    ) -> Option<(f64, PredictedChange)> {
        if !problem.has_input_bounds() {
            return Some((self.line_search(problem, predicted, 1.0), predicted));
        }
        if self.limits == Limits::Dropped {
            return Some(self.step_without_bounds(problem, predicted));
        }
        if self.attempt(problem, predicted, 1.0) {
            return Some((1.0, predicted));
        }
        let is_first_try = self.limits == Limits::Untried;
        let unbounded = self.direction_under(problem, Limits::Dropped)?;
        if is_first_try {
            return Some(self.step_without_bounds(problem, unbounded));
        }
        if self.attempt(problem, unbounded, 1.0) {
            self.limits = Limits::Kept;
            return Some((1.0, unbounded));
        }
        let bounded = self.direction_under(problem, Limits::Kept)?;
        Some((self.line_search(problem, bounded, 0.5), bounded))
    }

    /// Takes a step of the policy without bounds, which is over once the step is whole, or none.
    fn step_without_bounds(
        &mut self,
        problem: &Problem,
        predicted: PredictedChange,
    ) -> (f64, PredictedChange) {
        let step = self.line_search(problem, predicted, 1.0);
        if step == 0.0 || step == 1.0 {
            self.limits = Limits::Kept;
        }
        (step, predicted)
    }

    /// Another policy around the same trajectory, and the change it predicts.
    fn direction_under(&mut self, problem: &Problem, limits: Limits) -> Option<PredictedChange> {
        self.limits = limits;
        if self.options.curvature == Curvature::Exact {
            // Where it was not convex, the last direction has left Gauss and Newton's expansion.
            self.expand(problem, Curvature::Exact);
        }
        self.direction(problem)
    }

    /// Takes the longest step up to `longest` that improves as it should, and returns it; zero where none does.
    fn line_search(&mut self, problem: &Problem, predicted: PredictedChange, longest: f64) -> f64 {
        let mut alpha = longest;
        for _ in 0..self.options.line_search_steps {
            if is_stopped() {
                return 0.0;
            }
            if self.attempt(problem, predicted, alpha) {
                return alpha;
            }
            alpha *= 0.5;
        }
        0.0
    }

    /// Takes a step if it improves as it should.
    fn attempt(&mut self, problem: &Problem, predicted: PredictedChange, alpha: f64) -> bool {
        let along = Along {
            first: &self.backward.first,
            alpha,
            penalty: self.penalty,
        };
        let merit = self.forward.run(
            problem,
            &self.solution.trajectory,
            &self.stages,
            &along,
            &mut self.scratches[0],
            &mut self.trial,
        );
        let change = predicted.change(alpha);
        let Some(merit) =
            merit.filter(|at| is_accepted(at.merit - self.merit, change, predicted.slope))
        else {
            return false;
        };
        self.accept(problem, merit, alpha);
        true
    }

    fn accept(&mut self, problem: &Problem, at: Merit, alpha: f64) {
        std::mem::swap(&mut self.solution.trajectory, &mut self.trial);
        (self.solution.cost, self.merit) = (at.cost, at.merit);
        if alpha == 1.0 {
            self.has_gaps = false;
            self.solution.gap = 0.0;
        }
        let memory = &mut self.scratches[0].memory;
        self.solution.violation = self.solution.trajectory.largest_violation(problem, memory);
    }

    fn progress(&self, step: f64, predicted: PredictedChange) -> Progress {
        Progress {
            step,
            gap: self.solution.gap,
            violation: self.solution.violation,
            predicted_reduction: Some(-predicted.change(1.0)),
            regularization: Some(self.regularization),
            ..Progress::new(self.solution.iterations, self.solution.cost)
        }
    }

    /// Adapts the regularisation: less after long steps, more after short ones; `false` where it would have to rise
    /// beyond its limit and no step was taken.
    fn adapt_regularization(&mut self, step: f64) -> bool {
        if step >= LONG_STEP {
            self.regularization = self.options.regularization.lowered(self.regularization);
        } else if step <= SHORT_STEP {
            if step == 0.0 && self.regularization >= self.options.regularization.max {
                return false;
            }
            self.regularization = self.options.regularization.raised(self.regularization);
        }
        true
    }
}

/// Goldstein's test if an improvement is predicted; if closing gaps increases the cost, a limit on the increase.
fn is_accepted(change: f64, predicted: f64, slope: f64) -> bool {
    /// A slope that is only rounding: any change is accepted.
    const NO_SLOPE: f64 = 1e-12;
    if predicted <= 0.0 {
        slope.abs() < NO_SLOPE || change <= ACCEPTED_SHARE * predicted
    } else {
        change <= ACCEPTED_RISE * predicted
    }
}
