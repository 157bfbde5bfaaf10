//! Differential dynamic programming in multiple-shooting form.
//!
//! One iteration: expand costs and dynamics around the trajectory (`stage.rs`), go backward for the policy
//! (`backward.rs`), go forward with shorter and shorter steps until one improves as predicted
//! (`predicted.rs`, `forward.rs`); `inner.rs` repeats this until nothing improves. A guess need not obey the dynamics:
//! the gaps between a step's end and the next state are closed by the share of the step that is taken. Inputs within
//! bounds are a small quadratic program at each stage (`linalg/box_qp.rs`), but for steps on which the policy does better
//! without knowing them; constraints are an augmented Lagrangian around all of it (`outer.rs`).
//!
//! [Mastalli et al. 2020, FDDP; Tassa, Mansard, Todorov 2014, control limits; Mastalli et al. 2022, both together; Howell, Jackson,
//! Manchester 2019, constraints].

mod backward;
mod core;
mod forward;
mod inner;
mod options;
mod outer;
mod predicted;
mod solution;
mod stage;

use std::fmt;

use super::problem::Problem;
use super::progress::Progress;
use super::solver::Solver;
use super::trajectory::Trajectory;
use core::Core;
pub use options::DdpOptions;
pub use solution::{DdpSolution, Policy};

/// The solver with its working memory; made once for problems of one shape.
///
/// Its iterations do not allocate as long as costs, constraints and the steps of the system do not.
pub struct Ddp {
    core: Core,
}

impl Ddp {
    /// Memory for a problem, with default options.
    pub fn new(problem: &Problem) -> Self {
        Self::with_options(problem, DdpOptions::default())
    }

    /// Memory for a problem.
    ///
    /// # Panics
    /// If an option is out of its range.
    pub fn with_options(problem: &Problem, options: DdpOptions) -> Self {
        Self {
            core: Core::new(problem, options),
        }
    }

    /// Optimises from a guess, which need not obey the dynamics. Inputs of the guess are moved into their bounds.
    ///
    /// # Panics
    /// If the guess has not the shape of the problem, or the problem not that of the solver.
    pub fn solve(&mut self, problem: &Problem, guess: &Trajectory) -> &DdpSolution {
        self.solve_with(problem, guess, |_| {})
    }

    /// [`solve`](Self::solve), reporting every iteration.
    ///
    /// # Panics
    /// If the guess has not the shape of the problem, or the problem not that of the solver.
    pub fn solve_with(
        &mut self,
        problem: &Problem,
        guess: &Trajectory,
        mut report: impl FnMut(&Progress),
    ) -> &DdpSolution {
        self.core.solve(problem, guess, &mut report);
        &self.core.solution
    }

    /// The last solution.
    pub fn solution(&self) -> &DdpSolution {
        &self.core.solution
    }

    /// The options.
    pub fn options(&self) -> &DdpOptions {
        &self.core.options
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
        self.core.solve(problem, guess, report);
        self.core.solution.clone()
    }
}

impl fmt::Debug for Ddp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Ddp")
            .field("options", &self.core.options)
            .field("solution", &self.core.solution)
            .finish_non_exhaustive()
    }
}
