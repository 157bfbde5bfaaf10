//! Minimises the rollout's cost; around that the augmented Lagrangian.

use nalgebra::{DMatrix, DVector};

use super::{Known, Multiplied, ShootingProgress, ShootingSolution, SingleShooting};
use crate::trajopt::dynamics::Dynamics;
use crate::trajopt::minimizer::{Iteration, MinimizeOptions, Minimizer, Minimum, Objective, Run};
use crate::trajopt::multipliers::{AtMultipliers, meet_constraints};
use crate::trajopt::status::Status;
use crate::trajopt::trajectory::Trajectory;

/// Tolerance of the first problem of an augmented Lagrangian, whose multipliers are not yet right.
const FIRST_TOLERANCE: f64 = 1e-3;

/// The function with what it works on.
struct Solving<'a, 'p, D: Dynamics> {
    shooting: &'a mut SingleShooting<'p, D>,
    minimizer: Minimizer,
    out: &'a mut ShootingSolution,
    report: &'a mut dyn FnMut(&ShootingProgress),
}

impl<D: Dynamics> AtMultipliers for Solving<'_, '_, D> {
    fn descend(&mut self, tolerance: f64) -> Status {
        let (shooting, out) = (&*self.shooting, &mut *self.out);
        let status = shooting.descend(self.minimizer, tolerance, out, self.report);
        let trajectory = shooting.trajectory(&out.variables);
        out.violation = trajectory.violation(shooting.problem);
        status
    }

    fn violation(&self) -> f64 {
        self.out.violation
    }

    fn update(&mut self, penalty: f64) {
        let z = &self.out.variables;
        self.shooting.update_multipliers(z, penalty);
    }
}

impl<D: Dynamics> SingleShooting<'_, D> {
    /// Minimises with a method of argmin, from the inputs of a guess (and its first state where that is free).
    ///
    /// A method that stalls is started anew from the best point as long as that helps. The best point is kept, whatever happens.
    ///
    /// # Panics
    /// If the guess has not the shape of the problem.
    pub fn solve(&mut self, minimizer: Minimizer, guess: &Trajectory) -> ShootingSolution {
        self.solve_with(minimizer, guess, |_| {})
    }

    /// [`solve`](Self::solve), reporting every iteration.
    ///
    /// # Panics
    /// If the guess has not the shape of the problem.
    pub fn solve_with(
        &mut self,
        minimizer: Minimizer,
        guess: &Trajectory,
        mut report: impl FnMut(&ShootingProgress),
    ) -> ShootingSolution {
        let z = self.variables(guess);
        self.set_multipliers(Multiplied::new(
            self.problem,
            self.options.constraints.penalty,
        ));
        let mut out = ShootingSolution {
            status: Status::Diverged,
            trajectory: self.trajectory(&z),
            cost_history: vec![self.value(&z)],
            variables: z,
            iterations: 0,
            cost: f64::INFINITY,
            violation: 0.0,
        };
        out.violation = out.trajectory.violation(self.problem);
        out.status = self.iterate(minimizer, &mut out, &mut report);
        out.trajectory = self.trajectory(&out.variables);
        out.cost = out.trajectory.cost(self.problem);
        out.violation = out.trajectory.violation(self.problem);
        out
    }

    /// Minimises with better and better multipliers where there are constraints.
    fn iterate(
        &mut self,
        minimizer: Minimizer,
        out: &mut ShootingSolution,
        report: &mut dyn FnMut(&ShootingProgress),
    ) -> Status {
        let tolerance = self.options.tolerance;
        if !self.problem.is_constrained() {
            return self.descend(minimizer, tolerance, out, report);
        }
        let constraints = self.options.constraints.clone();
        let mut solving = Solving {
            shooting: self,
            minimizer,
            out,
            report,
        };
        meet_constraints(&mut solving, &constraints, (FIRST_TOLERANCE, tolerance))
    }

    /// λ from the violations, then this penalty.
    fn update_multipliers(&mut self, z: &[f64], penalty: f64) {
        let nothing = Multiplied {
            lambda: Vec::new(),
            mu: penalty,
        };
        drop(self.at(z, Known::Price));
        let mut next = std::mem::replace(&mut self.multiplied, nothing);
        let problem = self.problem;
        self.lock().sweep.update_multipliers(problem, &mut next);
        next.mu = penalty;
        self.set_multipliers(next);
    }

    fn set_multipliers(&mut self, multiplied: Multiplied) {
        self.multiplied = multiplied;
        self.lock().known = Known::Nothing;
    }

    /// Runs at fixed multipliers, from where the last ones ended.
    fn descend(
        &self,
        minimizer: Minimizer,
        tolerance: f64,
        out: &mut ShootingSolution,
        report: &mut dyn FnMut(&ShootingProgress),
    ) -> Status {
        let violation = out.violation;
        let mut found = Minimum {
            status: out.status,
            value: self.value(&out.variables),
            x: std::mem::take(&mut out.variables),
            iterations: out.iterations,
            history: std::mem::take(&mut out.cost_history),
        };
        let options = MinimizeOptions {
            max_iterations: self.options.max_iterations,
            tolerance,
            memory: self.options.memory,
            radius: self.options.radius,
        };
        let run = Run {
            objective: self,
            minimizer,
            options: &options,
        };
        run.descend(tolerance, &mut found, &mut |at: &Iteration| {
            report(&ShootingProgress {
                iteration: at.iteration,
                cost: at.value,
                gradient: at.gradient,
                step: at.step,
                violation,
            });
        });
        (out.variables, out.iterations) = (found.x, found.iterations);
        out.cost_history = found.history;
        found.status
    }
}

impl<D: Dynamics> Objective for SingleShooting<'_, D> {
    fn value(&self, z: &[f64]) -> f64 {
        Self::value(self, z)
    }

    fn gradient(&self, z: &[f64]) -> DVector<f64> {
        Self::gradient(self, z)
    }

    fn hessian(&self, z: &[f64]) -> DMatrix<f64> {
        Self::hessian(self, z)
    }
}
