//! Iterations at fixed multipliers: expand, choose a direction, search along it, until no change is worth it.

use super::backward::Limits;
use super::expected::{Expected, expected_change};
use super::forward::Price;
use super::stage::Around;
use super::{Ddp, Progress};
use crate::sim::for_each_part;
use crate::trajopt::curvature::Curvature;
use crate::trajopt::dynamics::Dynamics;
use crate::trajopt::problem::{InitialState, Problem};
use crate::trajopt::status::Status;

/// Share of the expected improvement that a step has to keep.
const ACCEPTED_SHARE: f64 = 0.1;
/// While gaps close the cost may be expected to rise; by this many times the expectation it may.
const ACCEPTED_RISE: f64 = 2.0;
/// Steps from this one on tell that the model is good: the regularisation falls.
const LONG_STEP: f64 = 0.5;
/// Steps down to this one tell that it is not: the regularisation rises.
const SHORT_STEP: f64 = 0.01;
/// Gaps up to this size (tangent, m or rad) count as closed.
const GAP_TOLERANCE: f64 = 1e-9;
/// A cost beyond this size, of whichever sign, is divergence.
const COST_LIMIT: f64 = 1e25;

impl<D: Dynamics> Ddp<D> {
    /// Iterations at fixed multipliers.
    pub(super) fn descend(
        &mut self,
        problem: &Problem<D>,
        tolerance: f64,
        report: &mut dyn FnMut(&Progress),
    ) -> Status {
        loop {
            self.expand(problem, self.options.curvature);
            let (expected, is_last) = match self.worthwhile_direction(problem, tolerance) {
                Ok(found) => found,
                Err(status) => return status,
            };
            if self.solution.iterations >= self.options.max_iterations {
                return Status::IterationLimit;
            }
            let Some((step, expected)) = self.step(problem, expected) else {
                return Status::LineSearchStalled;
            };
            self.solution.iterations += 1;
            self.solution.cost_history.push(self.solution.cost);
            report(&self.progress(step, expected));
            if self.merit.abs() > COST_LIMIT {
                return Status::Diverged;
            }
            if !self.adapt_regularization(step) || (is_last && step == 0.0) {
                return Status::LineSearchStalled;
            }
        }
    }

    /// Finds a direction worth a step: its predicted reduction, and whether no other is left; or the final status if there is none.
    ///
    /// A strong regularisation promises little anywhere: it converged only where the least one promises no more.
    fn worthwhile_direction(
        &mut self,
        problem: &Problem<D>,
        tolerance: f64,
    ) -> Result<(Expected, bool), Status> {
        let none = Status::LineSearchStalled;
        let expected = self.direction(problem).ok_or(none)?;
        if !self.is_settled(expected, tolerance) {
            return Ok((expected, false));
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
    fn is_settled(&self, expected: Expected, tolerance: f64) -> bool {
        let negligible = tolerance * (1.0 + self.merit.abs());
        !self.has_gaps && expected.change(1.0).abs() <= negligible
    }

    /// Everything to second order around the trajectory, on as many threads as there are workers.
    fn expand(&mut self, problem: &Problem<D>, curvature: Curvature) {
        self.measure_first_gap(problem);
        let at = Around {
            problem,
            trajectory: &self.solution.trajectory,
            curvature,
            penalty: self.penalty,
            has_gaps: self.has_gaps,
        };
        for_each_part(&mut self.workers, &mut self.stages, |worker, k, stage| {
            worker.expand(&at, k, stage);
        });
        if self.has_gaps {
            let gaps = self.stages.iter().flat_map(|stage| &stage.gap);
            let largest = gaps
                .chain(&self.first_gap)
                .fold(0.0_f64, |max, gap| max.max(gap.abs()));
            self.solution.gap = largest;
            self.has_gaps = largest > GAP_TOLERANCE;
        }
    }

    fn measure_first_gap(&mut self, problem: &Problem<D>) {
        if problem.initial() == InitialState::Free {
            return self.first_gap.fill(0.0);
        }
        let first = self.solution.trajectory.states[0].as_slice();
        let start = problem.start().as_slice();
        problem
            .dynamics()
            .difference(first, start, &mut self.first_gap);
    }

    /// The policy and what it promises; none where no regularisation within its limit makes the problem convex.
    ///
    /// Far from an optimum the exact Hessian is often indefinite, and a regularisation that outweighs it makes for steps so short that
    /// they lead nowhere. There the Hessian of Gauss and Newton is the better model, and only where it fails does more regularisation
    /// help.
    fn direction(&mut self, problem: &Problem<D>) -> Option<Expected> {
        let mut curvature = self.options.curvature;
        while !self.find_policy(problem, curvature) {
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
        Some(expected_change(&self.stages, first, dz, next))
    }

    /// Goes backward for the policy; `false` where the regularised problem has none.
    fn find_policy(&mut self, problem: &Problem<D>, curvature: Curvature) -> bool {
        let at = Around {
            problem,
            trajectory: &self.solution.trajectory,
            curvature,
            penalty: self.penalty,
            has_gaps: true,
        };
        let how = (self.regularization, self.limits);
        let (stages, gap) = (&mut self.stages, &self.first_gap);
        self.backward.run(&at, stages, gap, how).is_ok()
    }

    /// Takes a step, and returns it with what its direction promises; none where no direction is left.
    ///
    /// An input that the policy sends to its bound has no feedback there: the roll-out of an unstable system runs away, and only
    /// short steps are left. So where the whole step does not improve as it should, the policy may do without the bounds, which the
    /// forward pass keeps all the same: from the guess on until its gaps are closed or it leads nowhere, later for whole steps only.
    fn step(&mut self, problem: &Problem<D>, expected: Expected) -> Option<(f64, Expected)> {
        if !problem.has_input_bounds() {
            return Some((self.line_search(problem, expected, 1.0), expected));
        }
        if self.limits == Limits::Dropped {
            return Some(self.step_without_bounds(problem, expected));
        }
        if self.attempt(problem, expected, 1.0) {
            return Some((1.0, expected));
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
    fn step_without_bounds(&mut self, problem: &Problem<D>, expected: Expected) -> (f64, Expected) {
        let step = self.line_search(problem, expected, 1.0);
        if step == 0.0 || step == 1.0 {
            self.limits = Limits::Kept;
        }
        (step, expected)
    }

    /// Another policy around the same trajectory, and what it promises.
    fn direction_under(&mut self, problem: &Problem<D>, limits: Limits) -> Option<Expected> {
        self.limits = limits;
        if self.options.curvature == Curvature::Exact {
            // Where it was not convex, the last direction has left Gauss and Newton's expansion.
            self.expand(problem, Curvature::Exact);
        }
        self.direction(problem)
    }

    /// Takes the longest step up to `longest` that improves as it should, and returns it; zero where none does.
    fn line_search(&mut self, problem: &Problem<D>, expected: Expected, longest: f64) -> f64 {
        let mut alpha = longest;
        for _ in 0..self.options.line_search_steps {
            if self.attempt(problem, expected, alpha) {
                return alpha;
            }
            alpha *= 0.5;
        }
        0.0
    }

    /// Takes a step if it improves as it should.
    fn attempt(&mut self, problem: &Problem<D>, expected: Expected, alpha: f64) -> bool {
        let how = (self.backward.first.as_slice(), alpha, self.penalty);
        let price = self.forward.run(
            problem,
            &self.solution.trajectory,
            &self.stages,
            how,
            &mut self.workers[0],
            &mut self.trial,
        );
        let promised = expected.change(alpha);
        let Some(price) =
            price.filter(|price| is_accepted(price.merit - self.merit, promised, expected.slope))
        else {
            return false;
        };
        self.accept(problem, price, alpha);
        true
    }

    fn accept(&mut self, problem: &Problem<D>, price: Price, alpha: f64) {
        std::mem::swap(&mut self.solution.trajectory, &mut self.trial);
        (self.solution.cost, self.merit) = (price.cost, price.merit);
        if alpha == 1.0 {
            self.has_gaps = false;
            self.solution.gap = 0.0;
        }
        let memory = &mut self.workers[0].memory;
        self.solution.violation = self.solution.trajectory.largest_violation(problem, memory);
    }

    fn progress(&self, step: f64, expected: Expected) -> Progress {
        Progress {
            iteration: self.solution.iterations,
            cost: self.solution.cost,
            step,
            expected: expected.change(1.0),
            regularization: self.regularization,
            gap: self.solution.gap,
            violation: self.solution.violation,
        }
    }

    /// Less after long steps, more after short ones; `false` where it would have to rise beyond its limit and no step was taken.
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

/// Goldstein's test where an improvement is expected; where closing gaps costs, a limit on what it may cost.
fn is_accepted(change: f64, expected: f64, slope: f64) -> bool {
    /// A slope that is rounding: any change will do.
    const NO_SLOPE: f64 = 1e-12;
    if expected <= 0.0 {
        slope.abs() < NO_SLOPE || change <= ACCEPTED_SHARE * expected
    } else {
        change <= ACCEPTED_RISE * expected
    }
}
