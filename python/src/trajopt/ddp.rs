//! Differential dynamic programming.

use dualbody::Simulator;
use dualbody::trajopt::{Curvature, Ddp, DdpOptions, DdpSolution, Progress, System};
use nalgebra::DVector;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::problem::{guess_of, is_of_user, problem_of};
use super::residual::Described;
use super::user::{Raised, UserSystem};
use crate::arrays::{Array, empty, numbers_mut, write_matrix};
use crate::errors::{guarded, value_error};

pub(super) fn options_of(value: &Bound<'_, PyDict>) -> PyResult<DdpOptions> {
    let mut options = DdpOptions::default();
    for (name, value) in value {
        match name.extract::<String>()?.as_str() {
            "max_iterations" => options.max_iterations = value.extract()?,
            "tolerance" => options.tolerance = value.extract()?,
            "threads" => options.threads = value.extract()?,
            "line_search_steps" => options.line_search_steps = value.extract()?,
            "constraint_tolerance" => options.constraints.tolerance = value.extract()?,
            "penalty" => options.constraints.penalty = value.extract()?,
            "exact_curvature" => {
                let exact: bool = value.extract()?;
                options.curvature = if exact {
                    Curvature::Exact
                } else {
                    Curvature::GaussNewton
                };
            }
            other => return Err(value_error(format_args!("\"{other}\" is no option of Ddp"))),
        }
    }
    Ok(options)
}

/// Calls a function of Python after each iteration; keeps the first error.
pub(super) fn reporter<'a>(
    report: Option<&'a Bound<'_, PyAny>>,
    raised: &'a mut Option<PyErr>,
) -> impl FnMut(&Progress) + 'a {
    move |progress| {
        if let Some(report) = report
            && raised.is_none()
            && let Err(error) = report.call1((
                progress.iteration,
                progress.cost,
                progress.violation,
                progress.gap,
            ))
        {
            *raised = Some(error);
        }
    }
}

pub(super) fn stack<'py>(
    py: Python<'py>,
    rows: &[DVector<f64>],
    n: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let numbers: Vec<f64> = rows.iter().flat_map(|row| row.iter().copied()).collect();
    Ok(PyArray1::from_vec(py, numbers)
        .reshape([rows.len(), n])?
        .into_any())
}

/// (x, u, gains, cost, status, converged, iterations, cost history, violation, gap)
pub(super) fn solution<'py>(
    py: Python<'py>,
    dynamics: &impl System,
    s: &DdpSolution,
) -> PyResult<Bound<'py, PyTuple>> {
    let (nx, ndx, nu) = (dynamics.nx(), dynamics.ndx(), dynamics.nu());
    let gains: Array<'py> = empty(py, &[s.own.gains.len(), nu, ndx]);
    let rows = numbers_mut(&gains).chunks_mut((nu * ndx).max(1));
    rows.zip(&s.own.gains)
        .for_each(|(out, gain)| write_matrix(gain, out));
    let history = PyArray1::from_vec(py, s.cost_history.clone());
    let (x, u) = (
        stack(py, &s.trajectory.states, nx)?,
        stack(py, &s.trajectory.inputs, nu)?,
    );
    (
        x,
        u,
        gains,
        s.cost,
        s.status.to_string(),
        s.is_converged(),
        s.iterations,
        history,
        s.violation,
        s.gap,
    )
        .into_pyobject(py)
}

/// Solves a problem by differential dynamic programming.
#[pyfunction]
#[pyo3(signature = (problem, options, guess=None, report=None))]
pub(crate) fn _ddp<'py>(
    py: Python<'py>,
    problem: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
    guess: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    report: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyTuple>> {
    let options = options_of(options)?;
    match is_of_user(problem)? {
        true if options.curvature == Curvature::Exact => Err(value_error(
            "exact_curvature needs second derivatives, and dynamics that are functions have first ones",
        )),
        true => solve::<UserSystem>(py, problem, options, guess, report),
        false => solve::<Simulator>(py, problem, options, guess, report),
    }
}

fn solve<'py, D: Described>(
    py: Python<'py>,
    problem: &Bound<'py, PyAny>,
    options: DdpOptions,
    guess: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    report: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyTuple>> {
    let of_functions = Raised::default();
    let problem = problem_of::<D>(problem, &of_functions)?;
    let guess = guess_of(&problem, guess)?;
    let mut raised = None;
    let pool = crate::threads::pool()?;
    let solved = match report {
        Some(_) => guarded(|| {
            let mut ddp = Ddp::with_options(&problem, options);
            ddp.solve_with(&problem, &guess, reporter(report, &mut raised))
                .clone()
        })?,
        None => py.detach(|| {
            guarded(|| {
                pool.install(|| {
                    Ddp::with_options(&problem, options)
                        .solve(&problem, &guess)
                        .clone()
                })
            })
        })?,
    };
    raised.map_or(Ok(()), Err)?;
    of_functions.check()?;
    solution(py, problem.dynamics(), &solved)
}
