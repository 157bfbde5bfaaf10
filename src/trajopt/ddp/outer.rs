//! Around the iterations: multipliers and penalty of the augmented Lagrangian, until the constraints hold.

use super::forward::{Price, price_of};
use super::inner::Inner;
use super::{Ddp, DdpStatus, Progress};
use crate::trajopt::dynamics::Dynamics;
use crate::trajopt::lagrangian::StagePoint;
use crate::trajopt::problem::Problem;

impl<D: Dynamics> Ddp<D> {
    /// Inner problems, one after the other, with better and better multipliers.
    pub(super) fn iterate(
        &mut self,
        problem: &Problem<D>,
        report: &mut impl FnMut(&Progress),
    ) -> DdpStatus {
        let constrained = self.stages.iter().any(|stage| !stage.lambda.is_empty());
        if !constrained {
            return match self.descend(problem, self.options.tolerance, report) {
                Inner::Optimal => DdpStatus::Converged,
                Inner::Ended(status) => status,
            };
        }
        let mut tolerance = self.options.first_tolerance();
        let mut before = f64::INFINITY;
        loop {
            let inner = self.descend(problem, tolerance, report);
            let holds = self.solution.violation <= self.options.constraint_tolerance;
            match inner {
                Inner::Ended(DdpStatus::LineSearchStalled) if !holds => {}
                Inner::Ended(status) => return status,
                Inner::Optimal if holds && tolerance <= self.options.tolerance => {
                    return DdpStatus::Converged;
                }
                Inner::Optimal => {}
            }
            let shrinks = self.solution.violation <= self.options.violation_decrease * before;
            if !holds && !shrinks && self.penalty >= self.options.max_penalty {
                return DdpStatus::Infeasible;
            }
            before = self.solution.violation;
            tolerance = self.options.next_tolerance(tolerance);
            self.update_lagrangian(problem, holds || shrinks);
        }
    }

    /// λ from the violations, and a larger penalty where they do not shrink.
    fn update_lagrangian(&mut self, problem: &Problem<D>, shrinks: bool) {
        let memory = &mut self.workers[0].memory;
        for (k, stage) in self.stages.iter_mut().enumerate() {
            let point = StagePoint::of(problem, &self.solution.trajectory, k);
            point.update_multipliers(&mut stage.lambda, self.penalty, memory);
        }
        if !shrinks {
            let raised = self.penalty * self.options.penalty_increase;
            self.penalty = raised.min(self.options.max_penalty);
        }
        self.regularization = self.options.regularization;
        self.reprice(problem);
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
