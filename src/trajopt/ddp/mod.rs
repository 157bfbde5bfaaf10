//! Differential dynamic programming in multiple-shooting form.
//!
//! One iteration: expand costs and dynamics around the trajectory (`stage.rs`), go backward for the policy (`backward.rs`), go forward
//! with shorter and shorter steps until one improves as it should (`forward.rs`). A guess need not obey the dynamics: the gaps between
//! a step's end and the next state are closed by the share of the step that is taken. Inputs within bounds are a small quadratic
//! program at each stage (`box_qp.rs`); constraints are an augmented Lagrangian around all of it (`lagrangian.rs`).
//!
//! [Mastalli et al. 2020, FDDP; Tassa, Mansard, Todorov 2014, control limits; Howell, Jackson, Manchester 2019, constraints].

mod backward;
mod box_qp;
mod curvature;
mod forward;
mod lagrangian;
mod options;
mod product;
mod solution;
mod stage;

use std::fmt;

use super::dynamics::Dynamics;
use super::problem::{InitialState, Problem};
use super::trajectory::Trajectory;
use crate::sim::for_each_part;
use backward::{Backward, Expected, expected_change};
use forward::{Forward, Price, price_of};
use lagrangian::Penalty;
pub use options::{Curvature, DdpOptions};
pub use solution::{DdpSolution, DdpStatus, Progress};
use stage::{Around, Stage, Worker};

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

/// The solver with its working memory; made once for problems of one shape.
///
/// Its iterations do not allocate as long as costs, constraints and the steps of the system do not.
pub struct Ddp<D> {
    options: DdpOptions,
    stages: Vec<Stage>,
    workers: Vec<Worker<D>>,
    backward: Backward,
    forward: Forward,
    trial: Trajectory,
    solution: DdpSolution,
    /// start ⊖ x₀.
    first_gap: Vec<f64>,
    dz: Vec<f64>,
    next: Vec<f64>,
    regularization: f64,
    penalty: Penalty,
    merit: f64,
    has_gaps: bool,
}

/// How the iterations between two updates of the multipliers ended.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Inner {
    Optimal,
    Ended(DdpStatus),
}

impl<D: Dynamics> Ddp<D> {
    /// Memory for a problem, with default options.
    pub fn new(problem: &Problem<D>) -> Self {
        Self::with_options(problem, DdpOptions::default())
    }

    /// Memory for a problem.
    ///
    /// # Panics
    /// If an option is out of its range.
    pub fn with_options(problem: &Problem<D>, options: DdpOptions) -> Self {
        options.check();
        let (n, nu) = (problem.dynamics().ndx(), problem.dynamics().nu());
        let stages = (0..=problem.horizon()).map(|k| Stage::new(problem, k));
        let workers = (0..options.threads.max(1)).map(|_| Worker::new(problem));
        Self {
            stages: stages.collect(),
            workers: workers.collect(),
            backward: Backward::new(problem),
            forward: Forward::new(problem),
            trial: Trajectory::resting(problem),
            solution: DdpSolution::new(problem, options.max_iterations),
            first_gap: vec![0.0; n],
            dz: vec![0.0; n + nu],
            next: vec![0.0; n],
            regularization: options.regularization,
            penalty: Penalty(options.penalty),
            merit: 0.0,
            has_gaps: true,
            options,
        }
    }

    /// Optimises from a guess, which need not obey the dynamics. Inputs of the guess are moved into their bounds.
    ///
    /// # Panics
    /// If the guess has not the shape of the problem, or the problem not that of the solver.
    pub fn solve(&mut self, problem: &Problem<D>, guess: &Trajectory) -> &DdpSolution {
        self.solve_with(problem, guess, |_| {})
    }

    /// [`solve`](Self::solve), reporting every iteration.
    ///
    /// # Panics
    /// If the guess has not the shape of the problem, or the problem not that of the solver.
    pub fn solve_with(
        &mut self,
        problem: &Problem<D>,
        guess: &Trajectory,
        mut report: impl FnMut(&Progress),
    ) -> &DdpSolution {
        guess.check(problem);
        assert_eq!(self.stages.len(), problem.horizon() + 1, "the horizon");
        self.solution.trajectory.copy_from(guess);
        for u in &mut self.solution.trajectory.inputs {
            problem.clamp_input(u.as_mut_slice());
        }
        self.solution.status = if self.begin(problem) {
            self.iterate(problem, &mut report)
        } else {
            DdpStatus::Diverged
        };
        self.finish(problem);
        &self.solution
    }

    /// The last solution.
    pub fn solution(&self) -> &DdpSolution {
        &self.solution
    }

    /// The options.
    pub fn options(&self) -> &DdpOptions {
        &self.options
    }

    /// Resets what the last solution left, measures gaps and price of the guess; `false` if they are not finite.
    fn begin(&mut self, problem: &Problem<D>) -> bool {
        self.regularization = self.options.regularization;
        self.penalty = Penalty(self.options.penalty);
        self.solution.iterations = 0;
        self.solution.cost_history.clear();
        for stage in &mut self.stages {
            stage.lambda.fill(0.0);
        }
        self.has_gaps = true;
        self.reprice(problem);
        self.solution.cost_history.push(self.solution.cost);
        let states = &self.solution.trajectory.states;
        self.merit.is_finite() && states.iter().flatten().all(|x| x.is_finite())
    }

    /// Price of the trajectory at the current multipliers.
    fn reprice(&mut self, problem: &Problem<D>) {
        let mut sum = Price {
            cost: 0.0,
            merit: 0.0,
        };
        let trajectory = &self.solution.trajectory;
        for (k, stage) in self.stages.iter().enumerate() {
            let at = (k, trajectory.states[k].as_slice(), trajectory.input(k));
            let price = price_of(problem, at, stage, self.penalty, &mut self.workers[0]);
            sum.cost += price.cost;
            sum.merit += price.merit;
        }
        (self.solution.cost, self.merit) = (sum.cost, sum.merit);
        let memory = &mut self.workers[0].memory;
        self.solution.violation = lagrangian::violation(problem, trajectory, memory);
    }

    /// Inner problems, one after the other, with better and better multipliers.
    fn iterate(&mut self, problem: &Problem<D>, report: &mut impl FnMut(&Progress)) -> DdpStatus {
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
            if !holds && !shrinks && self.penalty.0 >= self.options.max_penalty {
                return DdpStatus::Infeasible;
            }
            before = self.solution.violation;
            tolerance = self.options.next_tolerance(tolerance);
            self.update_lagrangian(problem, holds || shrinks);
        }
    }

    /// λ from the violations, and a larger penalty where they do not shrink.
    fn update_lagrangian(&mut self, problem: &Problem<D>, shrinks: bool) {
        lagrangian::update_multipliers(
            problem,
            &self.solution.trajectory,
            self.penalty,
            &mut self.stages,
            &mut self.workers[0].memory,
        );
        if !shrinks {
            let raised = self.penalty.0 * self.options.penalty_increase;
            self.penalty = Penalty(raised.min(self.options.max_penalty));
        }
        self.regularization = self.options.regularization;
        self.reprice(problem);
    }

    /// Iterations at fixed multipliers.
    fn descend(
        &mut self,
        problem: &Problem<D>,
        tolerance: f64,
        report: &mut impl FnMut(&Progress),
    ) -> Inner {
        loop {
            self.expand(problem);
            let Some(expected) = self.direction(problem) else {
                return Inner::Ended(DdpStatus::LineSearchStalled);
            };
            let negligible = tolerance * (1.0 + self.merit.abs());
            if !self.has_gaps && expected.change(1.0).abs() <= negligible {
                return Inner::Optimal;
            }
            if self.solution.iterations >= self.options.max_iterations {
                return Inner::Ended(DdpStatus::IterationLimit);
            }
            let step = self.line_search(problem, expected);
            self.solution.iterations += 1;
            self.solution.cost_history.push(self.solution.cost);
            report(&self.progress(step, expected));
            if self.merit.abs() > COST_LIMIT {
                return Inner::Ended(DdpStatus::Diverged);
            }
            if !self.adapt_regularization(step) {
                return Inner::Ended(DdpStatus::LineSearchStalled);
            }
        }
    }

    /// Everything to second order around the trajectory, on as many threads as there are workers.
    fn expand(&mut self, problem: &Problem<D>) {
        self.measure_first_gap(problem);
        let at = Around {
            problem,
            trajectory: &self.solution.trajectory,
            options: &self.options,
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

    /// The policy and what it promises, with as much regularisation as it takes; none where that is beyond its limit.
    fn direction(&mut self, problem: &Problem<D>) -> Option<Expected> {
        let at = Around {
            problem,
            trajectory: &self.solution.trajectory,
            options: &self.options,
            penalty: self.penalty,
            has_gaps: true,
        };
        loop {
            let (backward, mu) = (&mut self.backward, self.regularization);
            if backward
                .run(&at, &mut self.stages, &self.first_gap, mu)
                .is_ok()
            {
                let first = &self.backward.first;
                return Some(expected_change(
                    &self.stages,
                    first,
                    &mut self.dz,
                    &mut self.next,
                ));
            }
            if self.regularization >= self.options.max_regularization {
                return None;
            }
            self.regularization = self.options.raised(self.regularization);
        }
    }

    /// Takes the longest step that improves as it should, and returns it; zero where none does.
    fn line_search(&mut self, problem: &Problem<D>, expected: Expected) -> f64 {
        let mut alpha = 1.0;
        for _ in 0..self.options.line_search_steps {
            let how = (self.backward.first.as_slice(), alpha, self.penalty);
            let price = self.forward.run(
                problem,
                &self.solution.trajectory,
                &self.stages,
                how,
                &mut self.workers[0],
                &mut self.trial,
            );
            if let Some(price) = price
                && is_accepted(
                    price.merit - self.merit,
                    expected.change(alpha),
                    expected.slope,
                )
            {
                self.accept(problem, price, alpha);
                return alpha;
            }
            alpha *= 0.5;
        }
        0.0
    }

    fn accept(&mut self, problem: &Problem<D>, price: Price, alpha: f64) {
        std::mem::swap(&mut self.solution.trajectory, &mut self.trial);
        (self.solution.cost, self.merit) = (price.cost, price.merit);
        if alpha == 1.0 {
            self.has_gaps = false;
            self.solution.gap = 0.0;
        }
        let memory = &mut self.workers[0].memory;
        self.solution.violation = lagrangian::violation(problem, &self.solution.trajectory, memory);
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
            self.regularization = self.options.lowered(self.regularization);
        } else if step <= SHORT_STEP {
            if step == 0.0 && self.regularization >= self.options.max_regularization {
                return false;
            }
            self.regularization = self.options.raised(self.regularization);
        }
        true
    }

    /// The gains in the form in which they are handed out.
    fn finish(&mut self, problem: &Problem<D>) {
        let n = problem.dynamics().ndx();
        for (gain, stage) in self.solution.gains.iter_mut().zip(&self.stages) {
            for (i, column) in stage.gain_t.chunks_exact(n.max(1)).enumerate() {
                let row = gain.row_mut(i).into_iter();
                row.zip(column).for_each(|(gain, &k)| *gain = k);
            }
        }
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

impl<D> fmt::Debug for Ddp<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Ddp")
            .field("options", &self.options)
            .field("solution", &self.solution)
            .finish_non_exhaustive()
    }
}
