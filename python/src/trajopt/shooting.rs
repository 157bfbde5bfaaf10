//! Single shooting: the cost of a rollout as a function of its inputs, with first and second derivatives.

use dualbody::trajopt::{Minimizer, ShootingOptions, SingleShooting, Variables};

use super::problem::{Guess, guess_of, problem_of_simulator};
use super::solution::{curvature_of, solve, trajectory};
use crate::prelude::*;

use Minimizer::{Lbfgs, NewtonCg, SteepestDescent, TrustRegion};

fn options_of(value: &Bound<'_, PyDict>) -> PyResult<ShootingOptions> {
    read_options!(ShootingOptions, "SingleShooting", value;
        minimizer = minimizer by chosen("minimizer", &[Lbfgs, SteepestDescent, NewtonCg, TrustRegion]), memory, radius, max_iterations, tolerance,
        exact_curvature = curvature by curvature_of, constraint_tolerance = constraints.tolerance, penalty = constraints.penalty)
}

functions! {
    /// Minimises: see `solution`, with the variables.
    fn _single_shooting(problem, options: &Bound<'py, PyDict>, guess: Option<Guess<'py>> = None, report = None) -> PyResult<Bound<'py, PyTuple>> {
        let options = options_of(options)?;
        solve(
            problem,
            guess,
            report,
            problem_of_simulator,
            |problem, guess, report| {
                let minimizer = options.minimizer;
                SingleShooting::with_options(problem, options).solve_with(guess, minimizer, report)
            },
            |py, _, own: &Variables| Ok(vector(py, &own.variables)),
        )
    }

    /// Value, gradient (n,), Hessian (n, n) or trajectory (x, u) at variables (n,).
    fn _shooting_at(problem, options: &Bound<'py, PyDict>, question: &str, z) -> PyResult<Bound<'py, PyAny>> {
        let (py, raised) = (problem.py(), Raised::default());
        let problem = problem_of_simulator(problem, &raised)?;
        let own = SingleShooting::with_options(&problem, options_of(options)?);
        let z = read_vector("z", z, Some(own.dim()))?;
        let found = match question {
            "value" => guarded(|| own.value(&z))?.into_pyobject(py)?.into_any(),
            "gradient" => {
                let gradient = guarded(|| own.gradient(&z))?;
                vector(py, gradient.as_slice())
            }
            "hessian" => matrix(py, &guarded(|| own.hessian(&z))?).into_any(),
            _ => {
                let found = guarded(|| own.trajectory(&z))?;
                let arrays = trajectory(py, problem.dynamics(), &found)?;
                arrays.into_pyobject(py)?.into_any()
            }
        };
        raised.check()?;
        Ok(found)
    }

    /// The variables (n,) of a guess.
    fn _shooting_variables(problem, options: &Bound<'py, PyDict>, guess: Option<Guess<'py>> = None) -> PyResult<Bound<'py, PyAny>> {
        let py = problem.py();
        let problem = problem_of_simulator(problem, &Raised::default())?;
        let guess = guess_of(&problem, guess)?;
        let options = options_of(options)?;
        let found = guarded(|| SingleShooting::with_options(&problem, options).variables(&guess))?;
        Ok(vector(py, &found))
    }
}
