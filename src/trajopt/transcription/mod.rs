//! Direct transcription: states and inputs at all nodes at once, tied together by the dynamics, solved as one sparse
//! program.
//!
//! Between two nodes the state is a cubic in time whose rate is that of the dynamics at both ends and in the middle (Hermite and
//! Simpson, `defects.rs`); so the trajectory is right to fourth order in the length of the intervals, which may be
//! long. The middles are variables of their own (the separated form): path constraints and costs hold there as at the
//! nodes, every row of the program is about one point or one interval, and each defect is closer to linear than with the middle put into it [Kelly 2017, section 4;
//! Betts 2010, section 4.6].
//!
//! One iteration: expand costs, constraints and defects around the trajectory (`approximation.rs`), solve a convex
//! quadratic program for the step (`qp.rs`, by Clarabel), go along it as far as an exact penalty function falls
//! (`sqp.rs`). The Hessian is that of Gauss and Newton for the costs; what the dynamics bend is left out, as in iLQR,
//! so the last digits come by a constant factor an iteration.
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
/// It solves a [`Problem`] in continuous time: an interval lasts one time step of the system, which may be long, and
/// the system has a [`rate`](super::System::rate). What a cost or a constraint does at stage k holds for all of interval k:
/// the running cost is integrated by Simpson's rule, constraints of the stages hold at all nodes (the last one too) and
/// in the middle of all intervals. Inputs are continuous, and within their bounds at nodes and middles.
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

    /// Optimises from a guess, which need not obey the dynamics. Its first state is moved to the given start, inputs
    /// into their bounds.
    ///
    /// # Panics
    /// If the guess has not the shape of the problem, or the system no rate.
    pub fn solve(&self, problem: &Problem, guess: &Trajectory) -> TranscriptionSolution {
        self.solve_with(problem, guess, |_| {})
    }

    /// [`solve`](Self::solve), reporting every iteration. The gap of a report is the largest defect.
    ///
    /// # Panics
    /// If the guess has not the shape of the problem, or the system no rate.
    pub fn solve_with(
        &self,
        problem: &Problem,
        guess: &Trajectory,
        mut report: impl FnMut(&Progress),
    ) -> TranscriptionSolution {
        SqpSolver::from_trajectory(problem, &self.options, guess).run(&mut report)
    }

    /// [`solve_with`](Self::solve_with) from the curve of a former solution, also of another but similar problem: it
    /// starts with its inputs in the middles too.
    ///
    /// # Panics
    /// If the curve has not the shape of the problem, or the system no rate.
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
