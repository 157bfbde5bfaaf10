//! Minimises the rollout's merit; around that the augmented Lagrangian.

use super::solution::{ShootingSolution, Variables};
use super::{ShootingOptions, SingleShooting};
use crate::minimize::{Iteration, MinimizeOptions, Minimizer, Minimum, Run, Status};
use crate::trajopt::multipliers::{AtMultipliers, Tolerances, meet_constraints};
use crate::trajopt::progress::Progress;
use crate::trajopt::solution::Solution;
use crate::trajopt::trajectory::Trajectory;

/// Tolerance of the first problem of an augmented Lagrangian, whose multipliers are not yet right.
const FIRST_TOLERANCE: f64 = 1e-3;

/// The function with the best point so far.
struct Solving<'a, 'p> {
    function: &'a mut SingleShooting<'p>,
    minimizer: Minimizer,
    best: Minimum,
    violation: f64,
    report: &'a mut dyn FnMut(&Progress),
}

impl AtMultipliers for Solving<'_, '_> {
    /// Runs at fixed multipliers, from where the last ones ended.
    fn descend(&mut self, tolerance: f64) -> Status {
        let (violation, report) = (self.violation, &mut *self.report);
        let of = &self.function.options;
        let options = MinimizeOptions {
            max_iterations: of.max_iterations,
            tolerance,
            memory: of.memory,
            radius: of.radius,
        };
        let run = Run {
            objective: &*self.function,
            minimizer: self.minimizer,
            options: &options,
        };
        run.descend(tolerance, &mut self.best, &mut |at: &Iteration| {
            report(&Progress {
                gradient: Some(at.gradient),
                step: at.step,
                violation,
                ..Progress::new(at.iteration, at.value)
            });
        });
        self.violation = self.measure_violation();
        self.best.status
    }

    fn violation(&self) -> f64 {
        self.violation
    }

    fn update(&mut self, penalty: f64) {
        self.function.update_multipliers(&self.best.x, penalty);
    }
}

impl Solving<'_, '_> {
    fn measure_violation(&self) -> f64 {
        let trajectory = self.function.trajectory(&self.best.x);
        trajectory.violation(self.function.problem)
    }

    /// Minimises with better and better multipliers where there are constraints.
    fn iterate(&mut self) -> Status {
        let ShootingOptions {
            tolerance,
            curvature,
            ..
        } = self.function.options;
        if !curvature.is_known_of(self.function.problem.dynamics()) {
            return Status::NoStepHessian;
        }
        if !self.function.problem.is_constrained() {
            return self.descend(tolerance);
        }
        let constraints = self.function.options.constraints.clone();
        let tolerances = Tolerances {
            first: FIRST_TOLERANCE,
            last: tolerance,
        };
        meet_constraints(self, &constraints, tolerances)
    }
}

impl SingleShooting<'_> {
    /// Minimises from a guess.
    pub(super) fn minimize(
        &mut self,
        minimizer: Minimizer,
        guess: &Trajectory,
        report: &mut dyn FnMut(&Progress),
    ) -> ShootingSolution {
        let z = self.variables(guess);
        self.reset_multipliers(self.options.constraints.penalty);
        let value = self.value(&z);
        let best = Minimum {
            status: Status::Diverged,
            x: z,
            value,
            iterations: 0,
            history: vec![value],
        };
        let mut solving = Solving {
            function: self,
            minimizer,
            best,
            violation: 0.0,
            report,
        };
        solving.violation = solving.measure_violation();
        let status = solving.iterate();
        let best = solving.best;
        self.solution(status, best)
    }

    fn solution(&self, status: Status, best: Minimum) -> ShootingSolution {
        let trajectory = self.trajectory(&best.x);
        Solution {
            status,
            cost: trajectory.cost(self.problem),
            violation: trajectory.violation(self.problem),
            gap: 0.0,
            multipliers: self.multipliers(&best.x),
            trajectory,
            iterations: best.iterations,
            cost_history: best.history,
            own: Variables { variables: best.x },
        }
    }
}
