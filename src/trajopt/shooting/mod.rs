//! Single shooting: the whole rollout as one function of the inputs, minimised by argmin.
//!
//! The variables are one number for each input of each stage, transformed smoothly into its bounds
//! (`bound_transform.rs`), after those of the first state if it is free. The gradient is exact, by one sweep backward
//! over the step Jacobians (`sweep.rs`); constraints are penalties of an augmented Lagrangian. `function.rs` caches the evaluations at a point,
//! `minimize.rs` runs argmin, `traits.rs` implements argmin's traits.
//!
//! [Betts 2010, section 3.3; Griewank, Walther 2008, chapter 3].

mod bound_transform;
mod function;
mod lambdas;
mod minimize;
mod options;
mod solution;
mod sweep;
mod traits;

use std::fmt;
use std::sync::Mutex;

use super::problem::Problem;
use super::progress::Progress;
use super::solver::Solver;
use super::trajectory::Trajectory;
use crate::minimize::Minimizer;
use function::Work;
use lambdas::Lambdas;
pub use options::ShootingOptions;
pub use solution::{ShootingSolution, Variables};

/// The cost of a rollout as a function of variables `z`, and its minimisation.
///
/// `z` holds, if the first state is free, δx₀ of  x₀ = start ⊕ δx₀,  then one variable for each input of each stage.
/// The variable of a bounded input is transformed: u = m + h sin(z / h) between two bounds (m their middle, h half their distance), u = lower − 1 +
/// √(z² + 1)  above one,  u = upper + 1 − √(z² + 1)  below one. So bounds hold for all z. Constraints enter by their augmented Lagrangian:
/// [`solve`](Self::solve) finds the multipliers; before, they are zero and constraints are plain quadratic penalties.
///
/// It implements argmin's `CostFunction`, `Gradient` and `Hessian` on `Vec<f64>` and `Vec<Vec<f64>>`, by value and by reference, for direct use of
/// argmin with observers, checkpoints and other methods. The Hessian is Gauss–Newton along the rollout, and exact in the bound transform. With
/// [`Curvature::Exact`](crate::trajopt::Curvature::Exact) it contains all second derivatives (except those of ⊕ for a free first state on a
/// manifold).
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples};
/// use dualbody::trajopt::{Activation, Cost, InputError, Minimizer, Problem, SingleShooting, StateError, Trajectory};
///
/// let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.05);
/// let effort = Cost::new().with(1e-2, Activation::Quadratic, InputError::to_zero(&pendulum));
/// let arrive = Cost::new().with(1e1, Activation::Quadratic, StateError::to(&[1.0, 0.0]));
/// let problem = Problem::new(pendulum, 40, &[0.0, 0.0]).with_stage_cost(effort).with_final_cost(arrive);
/// let swing = SingleShooting::new(&problem).solve(&Trajectory::zero_input(&problem), Minimizer::Lbfgs);
/// assert!(swing.is_converged() && (swing.trajectory.states[40][0] - 1.0).abs() < 0.05);
/// ```
pub struct SingleShooting<'p> {
    problem: &'p Problem,
    options: ShootingOptions,
    lambdas: Lambdas,
    /// Working memory, and what it holds: argmin asks for values and derivatives at one point after the other, behind
    /// `&self`.
    work: Mutex<Work>,
}

impl<'p> SingleShooting<'p> {
    /// Makes the function of a problem, with default options.
    ///
    /// # Panics
    /// If there is not enough [memory](crate::memory).
    pub fn new(problem: &'p Problem) -> Self {
        Self::with_options(problem, ShootingOptions::default())
    }

    /// Makes the function of a problem.
    ///
    /// # Panics
    /// If an option is out of its range, or there is not enough [memory](crate::memory).
    pub fn with_options(problem: &'p Problem, options: ShootingOptions) -> Self {
        options.check();
        problem.assert_memory();
        Self {
            problem,
            lambdas: Lambdas::new(problem, options.constraints.penalty),
            options,
            work: Mutex::new(Work::new(problem)),
        }
    }

    /// Minimises with a method of argmin, from the inputs of a guess (and its first state if that is free).
    ///
    /// A method that stalls is restarted from the best point while that improves the cost. The result is always the best point.
    ///
    /// # Panics
    /// If the guess does not have the shape of the problem.
    pub fn solve(&mut self, guess: &Trajectory, minimizer: Minimizer) -> ShootingSolution {
        self.solve_with(guess, minimizer, |_| {})
    }

    /// [`solve`](Self::solve) with a report of each iteration.
    ///
    /// # Panics
    /// If the guess does not have the shape of the problem.
    pub fn solve_with(
        &mut self,
        guess: &Trajectory,
        minimizer: Minimizer,
        mut report: impl FnMut(&Progress),
    ) -> ShootingSolution {
        self.minimize(minimizer, guess, &mut report)
    }

    /// The problem.
    pub(crate) fn problem(&self) -> &'p Problem {
        self.problem
    }

    /// The options.
    pub fn options(&self) -> &ShootingOptions {
        &self.options
    }
}

/// Solves any problem with the minimiser of its options: for another problem than its own it makes a new function.
impl Solver for SingleShooting<'_> {
    type Own = Variables;

    fn solve_with(
        &mut self,
        problem: &Problem,
        guess: &Trajectory,
        report: &mut dyn FnMut(&Progress),
    ) -> ShootingSolution {
        let minimizer = self.options.minimizer;
        if std::ptr::eq(problem, self.problem) {
            return self.minimize(minimizer, guess, report);
        }
        let mut other = SingleShooting::with_options(problem, self.options.clone());
        other.minimize(minimizer, guess, report)
    }
}

impl fmt::Debug for SingleShooting<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SingleShooting")
            .field("options", &self.options)
            .field("dim", &self.dim())
            .finish_non_exhaustive()
    }
}
