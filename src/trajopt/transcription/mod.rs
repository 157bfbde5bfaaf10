//! Direct collocation: states and inputs of all nodes are variables of one sparse program, with the dynamics as constraints.
//!
//! Between two nodes the state is a cubic in time that satisfies the dynamics at both ends and in the middle (Hermite–Simpson, `defects.rs`). So the
//! trajectory is accurate to fourth order in the length of the intervals, which may be long. The midpoints are separate variables (separated form):
//! path constraints and costs apply there as at the nodes, each row of the program depends on one point or one interval, and the defects are closer
//! to linear than in the compressed form [Kelly 2017, section 4; Betts 2010, section 4.6].
//!
//! One iteration: expand costs, constraints and defects around the trajectory (`approximation.rs`), solve a convex
//! quadratic program for the step (`qp.rs`, by Clarabel), and search along it with an exact penalty function (`sqp.rs`). The Hessian is the
//! Gauss–Newton Hessian of the costs, without the curvature of the dynamics, as in iLQR; so convergence is linear.
//!
//! [Hargraves, Paris 1987; Nocedal, Wright 2006, chapter 18].

mod approximation;
mod chart;
mod curve;
mod defects;
mod layout;
mod merit;
mod options;
mod point_data;
mod points;
mod qp;
mod solution;
mod sparse;
mod sqp;

use super::problem::Problem;
use super::progress::Progress;
use super::solver::Solver;
use super::trajectory::Trajectory;
pub use curve::Curve;
pub use options::TranscriptionOptions;
pub use solution::{Continuous, TranscriptionSolution};
use sqp::SqpSolver;

/// The solver: Hermite–Simpson collocation by sequential quadratic programming.
///
/// It solves a [`Problem`] in continuous time: an interval lasts one time step of the system, which may be long, and the system has a
/// [`rate`](super::System::rate). The cost and the constraints of stage k apply to interval k: Simpson's rule integrates the running cost;
/// constraints of the stages hold at all nodes, including the last, and in the middle of all intervals. Inputs are continuous, and within their
/// bounds at nodes and midpoints.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples};
/// use dualbody::trajopt::{Activation, Constraint, Cost, InputError, Problem, StateError, Trajectory, Transcription};
///
/// let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.1);
/// let effort = Cost::new().with(1.0, Activation::Quadratic, InputError::to_zero(&pendulum));
/// let arrive = Constraint::equal_to_zero(&pendulum, StateError::to(&[1.0, 0.0]));
/// let problem = Problem::new(pendulum, 10, &[0.0, 0.0]).with_stage_cost(effort).with_final_constraint(arrive);
/// let swing = Transcription::new().solve(&problem, &Trajectory::zero_input(&problem));
/// assert!(swing.is_converged() && swing.violation < 1e-6);
/// let half_way = swing.curve.state(problem.dynamics(), 0.55);
/// assert!((0.0..1.0).contains(&half_way[0]));
/// ```
///
/// # References
/// [Hargraves, Paris 1987]; [Kelly 2017]; [Betts 2010].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transcription {
    options: TranscriptionOptions,
}

impl Transcription {
    /// Makes a solver with default options.
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes a solver with options.
    ///
    /// # Panics
    /// If an option is out of its range.
    pub fn with_options(options: TranscriptionOptions) -> Self {
        options.check();
        Self { options }
    }

    /// The options.
    pub fn options(&self) -> &TranscriptionOptions {
        &self.options
    }

    /// Optimises from a guess, which need not satisfy the dynamics. Its first state is moved to the given start, and inputs are clamped to their bounds.
    ///
    /// # Panics
    /// If the guess does not have the shape of the problem, or the system has no rate.
    pub fn solve(&self, problem: &Problem, guess: &Trajectory) -> TranscriptionSolution {
        self.solve_with(problem, guess, |_| {})
    }

    /// [`solve`](Self::solve) with a report of each iteration. The gap of a report is the largest defect.
    ///
    /// # Panics
    /// If the guess does not have the shape of the problem, or the system has no rate.
    pub fn solve_with(
        &self,
        problem: &Problem,
        guess: &Trajectory,
        mut report: impl FnMut(&Progress),
    ) -> TranscriptionSolution {
        SqpSolver::from_trajectory(problem, &self.options, guess).run(&mut report)
    }

    /// [`solve_with`](Self::solve_with) from the curve of an earlier solution, possibly of a similar problem: it also uses the inputs in the middle
    /// of the intervals.
    ///
    /// # Panics
    /// If the curve does not have the shape of the problem, or the system has no rate.
    pub fn resume_with(
        &self,
        problem: &Problem,
        from: &Curve,
        mut report: impl FnMut(&Progress),
    ) -> TranscriptionSolution {
        SqpSolver::from_curve(problem, &self.options, from).run(&mut report)
    }
}

impl Solver for Transcription {
    type Own = Continuous;

    fn solve_with(
        &mut self,
        problem: &Problem,
        guess: &Trajectory,
        report: &mut dyn FnMut(&Progress),
    ) -> TranscriptionSolution {
        SqpSolver::from_trajectory(problem, &self.options, guess).run(report)
    }
}
