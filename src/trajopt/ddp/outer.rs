//! Around the iterations: multipliers and penalty of the augmented Lagrangian, until the constraints hold.

use super::forward::{Price, price_of};
use super::{Ddp, Progress};
use crate::trajopt::dynamics::Dynamics;
use crate::trajopt::lagrangian::StagePoint;
use crate::trajopt::multipliers::{AtMultipliers, meet_constraints};
use crate::trajopt::problem::Problem;
use crate::trajopt::status::Status;

/// Tolerance of the first problem of an augmented Lagrangian, whose multipliers are not yet right.
const FIRST_TOLERANCE: f64 = 1e-4;

/// The solver with what it works on.
struct Solving<'a, D: Dynamics> {
    ddp: &'a mut Ddp<D>,
    problem: &'a Problem<D>,
    report: &'a mut dyn FnMut(&Progress),
}

impl<D: Dynamics> AtMultipliers for Solving<'_, D> {
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
        self.ddp.reprice(self.problem);
    }
}

impl<D: Dynamics> Ddp<D> {
    /// Iterations from the guess to the end, with better and better multipliers where there are constraints.
    pub(super) fn iterate(
        &mut self,
        problem: &Problem<D>,
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
        meet_constraints(&mut solving, &constraints, (FIRST_TOLERANCE, tolerance))
    }

    /// λ from the violations.
    fn update_multipliers(&mut self, problem: &Problem<D>) {
        let memory = &mut self.workers[0].memory;
        for (k, stage) in self.stages.iter_mut().enumerate() {
            let point = StagePoint::of(problem, &self.solution.trajectory, k);
            point.update_multipliers(&mut stage.lambda, self.penalty, memory);
        }
    }

    /// Price of the trajectory at the current multipliers.
    pub(super) fn reprice(&mut self, problem: &Problem<D>) {
        let mut sum = Price {
            cost: 0.0,
            merit: 0.0,
        };
        let trajectory = &self.solution.trajectory;
        for (k, stage) in self.stages.iter().enumerate() {
            let point = StagePoint::of(problem, trajectory, k);
            let price = price_of(&point, stage, self.penalty, &mut self.workers[0]);
            sum.cost += price.cost;
            sum.merit += price.merit;
        }
        (self.solution.cost, self.merit) = (sum.cost, sum.merit);
        let memory = &mut self.workers[0].memory;
        self.solution.violation = trajectory.largest_violation(problem, memory);
    }
}
