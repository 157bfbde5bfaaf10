//! Outer iterations: multipliers and penalty of the augmented Lagrangian, until the constraints hold.

use super::Ddp;
use super::forward::{Merit, merit_of};
use crate::minimize::Status;
use crate::trajopt::multipliers::{AtMultipliers, Tolerances, meet_constraints};
use crate::trajopt::problem::Problem;
use crate::trajopt::progress::Progress;

/// Tolerance of the first problem of an augmented Lagrangian, whose multipliers are not yet accurate.
const FIRST_TOLERANCE: f64 = 1e-4;

/// The solver with its problem.
struct Solving<'a> {
    ddp: &'a mut Ddp,
    problem: &'a Problem,
    report: &'a mut dyn FnMut(&Progress),
}

impl AtMultipliers for Solving<'_> {
    fn descend(&mut self, tolerance: f64) -> Status {
        self.ddp.descend(self.problem, tolerance, self.report)
    }

    fn violation(&self) -> f64 {
        self.ddp.solution.violation
    }

    fn update(&mut self, penalty: f64) {
        self.ddp.update_multipliers(self.problem);
        self.ddp.penalty = penalty;
        self.ddp.regularization = self.ddp.options.regularization.start;
        self.ddp.update_merit(self.problem);
    }
}

impl Ddp {
    /// Iterations from the guess to the end, with better and better multipliers where there are constraints.
    pub(super) fn iterate(
        &mut self,
        problem: &Problem,
        report: &mut dyn FnMut(&Progress),
    ) -> Status {
        let (tolerance, constraints) = (self.options.tolerance, self.options.constraints.clone());
        if !problem.is_constrained() {
            return self.descend(problem, tolerance, report);
        }
        let mut solving = Solving {
            ddp: self,
            problem,
            report,
        };
        let tolerances = Tolerances {
            first: FIRST_TOLERANCE,
            last: tolerance,
        };
        meet_constraints(&mut solving, &constraints, tolerances)
    }

    /// λ from the violations.
    fn update_multipliers(&mut self, problem: &Problem) {
        let memory = &mut self.scratches[0].memory;
        for (k, stage) in self.stages.iter_mut().enumerate() {
            let point = self.solution.trajectory.stage(problem, k);
            point.update_multipliers(&mut stage.lambda, self.penalty, memory);
        }
    }

    /// Merit of the trajectory at the current multipliers.
    pub(super) fn update_merit(&mut self, problem: &Problem) {
        let mut sum = Merit::default();
        let trajectory = &self.solution.trajectory;
        for (k, stage) in self.stages.iter().enumerate() {
            let point = trajectory.stage(problem, k);
            let own = merit_of(&point, stage, self.penalty, &mut self.scratches[0]);
            sum.cost += own.cost;
            sum.merit += own.merit;
        }
        (self.solution.cost, self.merit) = (sum.cost, sum.merit);
        let memory = &mut self.scratches[0].memory;
        self.solution.violation = trajectory.largest_violation(problem, memory);
    }
}
