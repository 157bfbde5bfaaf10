//! Runs argmin: one run after another while they improve, and around them the augmented Lagrangian.

use argmin::core::{Executor, Solver};
use argmin::solver::gradientdescent::SteepestDescent;
use argmin::solver::linesearch::condition::ArmijoCondition;
use argmin::solver::linesearch::{BacktrackingLineSearch, MoreThuenteLineSearch};
use argmin::solver::newton::NewtonCG;
use argmin::solver::quasinewton::LBFGS;
use argmin::solver::trustregion::{Steihaug, TrustRegion};

use super::watch::{Iterate, Limits, Watch, Watched};
use super::{Known, Minimizer, Multiplied, ShootingProgress, ShootingSolution, SingleShooting};
use crate::trajopt::dynamics::Dynamics;
use crate::trajopt::multipliers::{AtMultipliers, meet_constraints};
use crate::trajopt::status::Status;
use crate::trajopt::trajectory::Trajectory;

/// Iterations without improvement that line searches are given: a second one starts from the same point.
const PATIENCE: usize = 2;
/// A radius of trust shrinks to a quarter at each failure; this many lead from any to nothing.
const PATIENCE_OF_TRUST: usize = 30;
/// argmin's Newton-CG ends its inner iterations at  ‖r‖² ≤ ½ ‖g‖  (residual and gradient), which for small gradients is before the
/// first: costs this many times larger make it  ‖r‖² ≤ ½ ‖g‖ / scale.
const NEWTON_SCALE: f64 = 1e9;
/// A run that improves the cost by less than this share of 1 + |cost| is not repeated.
const WORTHWHILE: f64 = 1e-12;
/// Share of the expected decrease that a backtracking step has to keep.
const ARMIJO: f64 = 1e-4;
/// A radius of trust never grows beyond this.
const MAX_RADIUS: f64 = 1e6;
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

    /// Runs at fixed multipliers, each from where the one before ended.
    fn descend(
        &self,
        minimizer: Minimizer,
        tolerance: f64,
        out: &mut ShootingSolution,
        report: &mut dyn FnMut(&ShootingProgress),
    ) -> Status {
        loop {
            let before = self.value(&out.variables);
            let from = (std::mem::take(&mut out.variables), out.iterations);
            let limits = Limits {
                tolerance,
                patience: match minimizer {
                    Minimizer::TrustRegion => PATIENCE_OF_TRUST,
                    _ => PATIENCE,
                },
                scale: match minimizer {
                    Minimizer::NewtonCg => NEWTON_SCALE,
                    _ => 1.0,
                },
                violation: out.violation,
            };
            let watch = Watch::new(self, limits, from, &mut out.cost_history, report);
            self.run(minimizer, &watch);
            let record = watch.into_record();
            let improvement = before - record.cost;
            let worthwhile = improvement > WORTHWHILE * (1.0 + record.cost.abs());
            let status = record.status;
            (out.variables, out.iterations) = (record.z, record.iterations);
            if out.iterations >= self.options.max_iterations && status != Some(Status::Converged) {
                return status
                    .filter(|&s| s == Status::Diverged)
                    .unwrap_or(Status::IterationLimit);
            }
            match status {
                None | Some(Status::LineSearchStalled) if worthwhile => {}
                status => return status.unwrap_or(Status::LineSearchStalled),
            }
        }
    }

    /// One run of argmin.
    fn run(&self, minimizer: Minimizer, watch: &Watch<'_, '_, D>) {
        match minimizer {
            Minimizer::Lbfgs => {
                let search = MoreThuenteLineSearch::new();
                self.execute::<_, ()>(LBFGS::new(search, self.options.memory), watch);
            }
            Minimizer::SteepestDescent => {
                let search = MoreThuenteLineSearch::new();
                self.execute::<_, ()>(SteepestDescent::new(search), watch);
            }
            Minimizer::NewtonCg => {
                let condition = ArmijoCondition::new(ARMIJO).expect("a share between 0 and 1");
                let search = BacktrackingLineSearch::new(condition).rho(0.5);
                let search = search.expect("a factor between 0 and 1");
                self.execute::<_, Vec<Vec<f64>>>(NewtonCG::new(search), watch);
            }
            Minimizer::TrustRegion => {
                let inner = Steihaug::new().with_max_iters(2 * self.dim() as u64);
                let method = TrustRegion::new(inner).with_max_radius(MAX_RADIUS);
                let method = method.and_then(|method| method.with_radius(self.options.radius));
                let method = method.expect("radii are positive");
                self.execute::<_, Vec<Vec<f64>>>(method, watch);
            }
        }
    }

    /// A method until its watch ends it. So does an error of argmin: a line search that found nothing.
    fn execute<'w, 'a, 'p, S, H>(&self, method: S, watch: &'w Watch<'a, 'p, D>)
    where
        S: Solver<&'w Watch<'a, 'p, D>, Iterate<H>>,
        H: Clone,
    {
        let (z, done) = watch.start();
        let left = self.options.max_iterations.saturating_sub(done);
        let run = Executor::new(watch, Watched { method, watch })
            .configure(|state| state.param(z).max_iters(left as u64))
            .ctrlc(false)
            .run();
        // Nothing is lost with an error: the watch has the best point.
        drop(run);
    }
}
