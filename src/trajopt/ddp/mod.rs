//! Differential dynamic programming in multiple-shooting form.
//!
//! One iteration: expand costs and dynamics around the trajectory (`stage.rs`), go backward for the policy
//! (`backward.rs`), go forward with decreasing steps until one improves as predicted (`predicted.rs`, `forward.rs`); `inner.rs` repeats this until
//! nothing improves. A guess need not satisfy the dynamics: each step closes the gaps between the end of a step and the next state in proportion to
//! its length. Input bounds give a small quadratic program at each stage (`linalg/box_qp.rs`), except for steps on which the policy without bounds is
//! better; constraints are an outer augmented Lagrangian (`outer.rs`).
//!
//! [Mastalli et al. 2020, FDDP; Tassa, Mansard, Todorov 2014, control limits; Mastalli et al. 2022, both together; Howell, Jackson,
//! Manchester 2019, constraints].

mod backward;
mod forward;
mod inner;
mod options;
mod outer;
mod predicted;
mod run;
mod solution;
mod stage;

use std::fmt;

use super::problem::Problem;
use super::progress::Progress;
use super::solution::Solution;
use super::solver::Solver;
use super::trajectory::Trajectory;
use backward::{Backward, Limits};
use forward::Forward;
pub use options::DdpOptions;
pub use solution::{DdpSolution, Policy};
use stage::{Stage, StageScratch};

/// The solver with its working memory, for problems of one shape.
///
/// Its iterations do not allocate if costs, constraints and the steps of the system do not.
pub struct Ddp {
    options: DdpOptions,
    stages: Vec<Stage>,
    scratches: Vec<StageScratch>,
    backward: Backward,
    forward: Forward,
    trial: Trajectory,
    solution: DdpSolution,
    /// start ⊖ x₀.
    first_gap: Vec<f64>,
    dz: Vec<f64>,
    next: Vec<f64>,
    regularization: f64,
    penalty: f64,
    merit: f64,
    has_gaps: bool,
    limits: Limits,
}

impl Ddp {
    /// Makes a solver for a problem, with default options.
    ///
    /// # Panics
    /// If there is not enough [memory](crate::memory).
    pub fn new(problem: &Problem) -> Self {
        Self::with_options(problem, DdpOptions::default())
    }

    /// Makes a solver for a problem.
    ///
    /// # Panics
    /// If an option is out of its range, or there is not enough [memory](crate::memory).
    pub fn with_options(problem: &Problem, options: DdpOptions) -> Self {
        options.check();
        problem.assert_memory();
        let (n, nu) = (problem.dynamics().ndx(), problem.dynamics().nu());
        let stages = (0..=problem.horizon()).map(|k| Stage::new(problem, k));
        let scratches = (0..options.threads.clamp(1, problem.horizon() + 1))
            .map(|_| StageScratch::new(problem));
        let policy = Policy::zeros(problem);
        Self {
            stages: stages.collect(),
            scratches: scratches.collect(),
            backward: Backward::new(problem),
            forward: Forward::new(problem),
            trial: Trajectory::zero_input(problem),
            solution: Solution::new(problem, options.max_iterations, policy),
            first_gap: vec![0.0; n],
            dz: vec![0.0; n + nu],
            next: vec![0.0; n],
            regularization: options.regularization.start,
            penalty: options.constraints.penalty,
            merit: 0.0,
            has_gaps: true,
            limits: Limits::Untried,
            options,
        }
    }

    /// Optimises from a guess, which need not satisfy the dynamics. Inputs of the guess are clamped to their bounds.
    ///
    /// The result is a local optimum, which depends on the guess. Check its [`status`](crate::trajopt::Solution::status): if the solver stops without
    /// convergence, the result is the best iterate.
    ///
    /// # Panics
    /// If the guess or the problem does not have the shape of the solver's problem.
    pub fn solve(&mut self, problem: &Problem, guess: &Trajectory) -> &DdpSolution {
        self.solve_with(problem, guess, |_| {})
    }

    /// [`solve`](Self::solve) with a report of each iteration.
    ///
    /// # Panics
    /// If the guess or the problem does not have the shape of the solver's problem.
    pub fn solve_with(
        &mut self,
        problem: &Problem,
        guess: &Trajectory,
        mut report: impl FnMut(&Progress),
    ) -> &DdpSolution {
        self.run(problem, guess, &mut report);
        &self.solution
    }

    /// The last solution.
    pub fn solution(&self) -> &DdpSolution {
        &self.solution
    }
}

/// Solves problems of the shape that it was made for.
impl Solver for Ddp {
    type Own = Policy;

    fn solve_with(
        &mut self,
        problem: &Problem,
        guess: &Trajectory,
        report: &mut dyn FnMut(&Progress),
    ) -> DdpSolution {
        self.run(problem, guess, report);
        self.solution.clone()
    }
}

impl fmt::Debug for Ddp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Ddp")
            .field("options", &self.options)
            .field("solution", &self.solution)
            .finish_non_exhaustive()
    }
}
