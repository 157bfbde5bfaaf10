//! Single shooting: the cost of a rollout as a function of its inputs, with first and second derivatives.

use dualbody::Simulator;
use dualbody::trajopt::{Curvature, Minimizer, Problem, ShootingOptions, SingleShooting, System};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::ddp::{reporter, stack};
use super::problem::{guess_of, problem_of};
use super::user::Raised;
use crate::arrays::{matrix, read_vector, vector};
use crate::errors::{choice, guarded, value_error};

const MINIMIZERS: [(&str, Minimizer); 4] = [
    ("lbfgs", Minimizer::Lbfgs),
    ("steepest_descent", Minimizer::SteepestDescent),
    ("newton_cg", Minimizer::NewtonCg),
    ("trust_region", Minimizer::TrustRegion),
];

fn options_of(value: &Bound<'_, PyDict>) -> PyResult<ShootingOptions> {
    let mut options = ShootingOptions::default();
    for (name, value) in value {
        match name.extract::<String>()?.as_str() {
            "minimizer" => {
                options.minimizer = choice("minimizer", &value.extract::<String>()?, &MINIMIZERS)?;
            }
            "max_iterations" => options.max_iterations = value.extract()?,
            "tolerance" => options.tolerance = value.extract()?,
            "memory" => options.memory = value.extract()?,
            "radius" => options.radius = value.extract()?,
            "constraint_tolerance" => options.constraints.tolerance = value.extract()?,
            "penalty" => options.constraints.penalty = value.extract()?,
            "exact_curvature" => {
                options.curvature = match value.extract()? {
                    true => Curvature::Exact,
                    false => Curvature::GaussNewton,
                };
            }
            other => {
                let text = format_args!("\"{other}\" is no option of SingleShooting");
                return Err(value_error(text));
            }
        }
    }
    Ok(options)
}

/// Minimises: (x, u, variables, cost, status, converged, iterations, cost history, violation).
#[pyfunction]
#[pyo3(signature = (problem, options, guess=None, report=None))]
pub(crate) fn _single_shooting<'py>(
    py: Python<'py>,
    problem: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
    guess: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    report: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyTuple>> {
    let of_functions = Raised::default();
    let problem: Problem<Simulator> = problem_of(problem, &of_functions)?;
    let options = options_of(options)?;
    let guess = guess_of(&problem, guess)?;
    let mut raised = None;
    let s = guarded(|| {
        let minimizer = options.minimizer;
        let mut shooting = SingleShooting::with_options(&problem, options);
        shooting.solve_with(minimizer, &guess, reporter(report, &mut raised))
    })?;
    raised.map_or(Ok(()), Err)?;
    of_functions.check()?;
    let (nx, nu) = (
        System::nx(problem.dynamics()),
        System::nu(problem.dynamics()),
    );
    let (x, u) = (
        stack(py, &s.trajectory.states, nx)?,
        stack(py, &s.trajectory.inputs, nu)?,
    );
    let variables = vector(py, s.own.variables.clone());
    let history = PyArray1::from_vec(py, s.cost_history.clone());
    (
        x,
        u,
        variables,
        s.cost,
        s.status.to_string(),
        s.is_converged(),
        s.iterations,
        history,
        s.violation,
    )
        .into_pyobject(py)
}

/// What is asked of the function of single shooting.
#[derive(Clone, Copy)]
enum Question {
    Value,
    Gradient,
    Hessian,
    Trajectory,
}

const QUESTIONS: [(&str, Question); 4] = [
    ("value", Question::Value),
    ("gradient", Question::Gradient),
    ("hessian", Question::Hessian),
    ("trajectory", Question::Trajectory),
];

/// Value, gradient (n,), Hessian (n, n) or trajectory (x, u) at variables (n,).
#[pyfunction]
pub(crate) fn _shooting_at<'py>(
    problem: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
    question: &str,
    z: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let (py, raised) = (problem.py(), Raised::default());
    let problem: Problem<Simulator> = problem_of(problem, &raised)?;
    let question = choice("question", question, &QUESTIONS)?;
    let own = SingleShooting::with_options(&problem, options_of(options)?);
    let z = read_vector("z", z, Some(own.dim()))?;
    let found = match question {
        Question::Value => guarded(|| own.value(&z))?.into_pyobject(py)?.into_any(),
        Question::Gradient => {
            let gradient = guarded(|| own.gradient(&z))?;
            vector(py, gradient.as_slice().to_vec()).into_any()
        }
        Question::Hessian => matrix(py, &guarded(|| own.hessian(&z))?).into_any(),
        Question::Trajectory => {
            let found = guarded(|| own.trajectory(&z))?;
            let x = stack(py, &found.states, System::nx(problem.dynamics()))?;
            let u = stack(py, &found.inputs, System::nu(problem.dynamics()))?;
            (x, u).into_pyobject(py)?.into_any()
        }
    };
    raised.check()?;
    Ok(found)
}

/// The variables (n,) of a guess.
#[pyfunction]
#[pyo3(signature = (problem, options, guess=None))]
pub(crate) fn _shooting_variables<'py>(
    problem: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
    guess: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = problem.py();
    let problem: Problem<Simulator> = problem_of(problem, &Raised::default())?;
    let guess = guess_of(&problem, guess)?;
    let options = options_of(options)?;
    let found = guarded(|| SingleShooting::with_options(&problem, options).variables(&guess))?;
    Ok(vector(py, found).into_any())
}
