//! Differential dynamic programming in multiple-shooting form.
//!
//! One iteration: expand costs and dynamics around the trajectory (`stage.rs`), go backward for the policy (`backward.rs`), go forward
//! with shorter and shorter steps until one improves as it promises (`expected.rs`, `forward.rs`); `inner.rs` repeats this until
//! nothing improves. A guess need not obey the dynamics: the gaps between a step's end and the next state are closed by the share of
//! the step that is taken. Inputs within bounds are a small quadratic program at each stage (`box_qp.rs`), but for steps on which the policy
//! does better without knowing them; constraints are an augmented Lagrangian around all of it (`outer.rs`).
//!
//! [Mastalli et al. 2020, FDDP; Tassa, Mansard, Todorov 2014, control limits; Mastalli et al. 2022, both together; Howell, Jackson,
//! Manchester 2019, constraints].

mod backward;
mod box_qp;
mod expected;
mod forward;
mod free_factor;
mod inner;
mod options;
mod outer;
mod product;
mod solution;
mod stage;

use std::fmt;

use super::dynamics::Dynamics;
use super::problem::Problem;
use super::status::Status;
use super::trajectory::Trajectory;
use backward::{Backward, Limits};
use forward::Forward;
pub use options::DdpOptions;
pub use solution::{DdpSolution, Progress};
use stage::{Stage, Worker};

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
    penalty: f64,
    merit: f64,
    has_gaps: bool,
    limits: Limits,
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
            regularization: options.regularization.start,
            penalty: options.constraints.penalty,
            merit: 0.0,
            has_gaps: true,
            limits: Limits::Untried,
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
            Status::Diverged
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
        self.regularization = self.options.regularization.start;
        self.penalty = self.options.constraints.penalty;
        self.solution.iterations = 0;
        self.solution.cost_history.clear();
        for stage in &mut self.stages {
            stage.lambda.fill(0.0);
        }
        (self.has_gaps, self.limits) = (true, Limits::Untried);
        self.reprice(problem);
        self.solution.cost_history.push(self.solution.cost);
        let states = &self.solution.trajectory.states;
        self.merit.is_finite() && states.iter().flatten().all(|x| x.is_finite())
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

impl<D> fmt::Debug for Ddp<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Ddp")
            .field("options", &self.options)
            .field("solution", &self.solution)
            .finish_non_exhaustive()
    }
}
