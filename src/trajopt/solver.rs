//! The common interface of all solvers.

use super::problem::Problem;
use super::progress::Progress;
use super::solution::Solution;
use super::trajectory::Trajectory;

/// A solver of trajectory-optimisation problems, for code that is generic over the solver. For a particular solver, its own functions are shorter.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples};
/// use dualbody::trajopt::{Activation, Cost, Ddp, InputError, Problem, SingleShooting, Solver, StateError, Trajectory};
///
/// /// The cost that a solver finds from the zero-input guess.
/// fn best<S: Solver>(solver: &mut S, problem: &Problem) -> f64 {
///     let solution = solver.solve(problem, &Trajectory::zero_input(problem));
///     assert!(solution.is_converged(), "{}", solution.status);
///     solution.cost
/// }
///
/// let pendulum = Simulator::new(samples::pendulum()).with_time_step(0.05);
/// let effort = Cost::new().with(1e-2, Activation::Quadratic, InputError::to_zero(&pendulum));
/// let arrive = Cost::new().with(1e1, Activation::Quadratic, StateError::to(&[1.0, 0.0]));
/// let problem = Problem::new(pendulum, 40, &[0.0, 0.0]).with_stage_cost(effort).with_final_cost(arrive);
/// let (ddp, shooting) = (best(&mut Ddp::new(&problem), &problem), best(&mut SingleShooting::new(&problem), &problem));
/// assert!((ddp - shooting).abs() < 1e-6);
/// ```
pub trait Solver {
    /// Results that only this solver gives besides.
    type Own;

    /// Optimises from a guess, reporting every iteration.
    ///
    /// # Panics
    /// If the guess does not have the shape of the problem.
    fn solve_with(
        &mut self,
        problem: &Problem,
        guess: &Trajectory,
        report: &mut dyn FnMut(&Progress),
    ) -> Solution<Self::Own>;

    /// [`solve_with`](Self::solve_with) without reports.
    ///
    /// # Panics
    /// If the guess does not have the shape of the problem.
    fn solve(&mut self, problem: &Problem, guess: &Trajectory) -> Solution<Self::Own> {
        self.solve_with(problem, guess, &mut |_| {})
    }
}
