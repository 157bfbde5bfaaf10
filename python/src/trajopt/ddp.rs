//! Differential dynamic programming.

use dualbody::Simulator;
use dualbody::trajopt::{Curvature, Ddp, DdpOptions, DdpSolution, Progress, System};
use nalgebra::DVector;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::problem::{guess_of, problem_of};
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
fn reporter<'a>(
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

fn stack<'py>(py: Python<'py>, rows: &[DVector<f64>], n: usize) -> PyResult<Bound<'py, PyAny>> {
    let numbers: Vec<f64> = rows.iter().flat_map(|row| row.iter().copied()).collect();
    Ok(PyArray1::from_vec(py, numbers)
        .reshape([rows.len(), n])?
        .into_any())
}

/// (x, u, gains, cost, status, converged, iterations, cost history, violation, gap)
pub(super) fn solution<'py>(
    py: Python<'py>,
    simulator: &Simulator,
    s: &DdpSolution,
) -> PyResult<Bound<'py, PyTuple>> {
    let (nx, nu) = (simulator.nx(), Simulator::nu(simulator));
    let gains: Array<'py> = empty(py, &[s.own.gains.len(), nu, simulator.ndx()]);
    let rows = numbers_mut(&gains).chunks_mut((nu * simulator.ndx()).max(1));
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
    let (problem, options) = (problem_of(problem)?, options_of(options)?);
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
    match raised {
        Some(error) => Err(error),
        None => solution(py, problem.dynamics(), &solved),
    }
}
