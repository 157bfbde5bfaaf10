//! Runs of solvers: their options, progress and results.

use dualbody::trajopt::{AnySystem, Curvature, Problem, Progress, Solution, Trajectory};

use super::problem::{Guess, guess_of};
use crate::prelude::*;

/// Whether second derivatives of the steps are taken.
pub(super) fn curvature_of(exact: &Bound<'_, PyAny>) -> PyResult<Curvature> {
    Ok(match exact.extract()? {
        true => Curvature::Exact,
        false => Curvature::GaussNewton,
    })
}

/// Runs a solver on the pool, without the interpreter lock but while its progress is reported. Ctrl-C, an exception of any function of Python,
/// and a report that returns True end it.
///
/// * `report` – called with iteration, cost, violation and gap after each iteration
/// * `read` – reads the problem
/// * `own` – what only this solver finds, as arrays
pub(super) fn solve<'py, S: Send>(
    problem: &Bound<'py, PyAny>,
    guess: Option<Guess<'py>>,
    report: Option<&Bound<'py, PyAny>>,
    read: impl FnOnce(&Bound<'py, PyAny>, &Raised) -> PyResult<Problem>,
    run: impl FnOnce(&Problem, &Trajectory, &mut dyn FnMut(&Progress)) -> Solution<S> + Send,
    own: impl FnOnce(Python<'py>, &dyn AnySystem, &S) -> PyResult<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyTuple>> {
    let (py, of_functions) = (problem.py(), Raised::default());
    let problem = read(problem, &of_functions)?;
    let guess = guess_of(&problem, guess)?;
    let report = report.map(|report| report.clone().unbind());
    let raised = &of_functions;
    let mut tell = |p: &Progress| {
        raised.tell(report.as_ref(), (p.iteration, p.cost, p.violation, p.gap));
    };
    let run = || raised.stop.watch(|| run(&problem, &guess, &mut tell));
    let found = on_pool_stopped(py, run);
    of_functions.check()?;
    let found = found?;
    let dynamics = problem.dynamics();
    solution(py, dynamics, &found, own(py, dynamics, &found.own)?)
}

/// (x, u, own, cost, status, converged, iterations, cost history, violation, gap)
pub(super) fn solution<'py, S>(
    py: Python<'py>,
    dynamics: &dyn AnySystem,
    s: &Solution<S>,
    own: Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyTuple>> {
    let (x, u) = trajectory(py, dynamics, &s.trajectory)?;
    let history = PyArray1::from_vec(py, s.cost_history.clone());
    (
        x,
        u,
        own,
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

/// States and inputs, a row for each node.
pub(super) fn trajectory<'py>(
    py: Python<'py>,
    dynamics: &dyn AnySystem,
    given: &Trajectory,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let states = nodes(py, &given.states, dynamics.nx());
    Ok((states, nodes(py, &given.inputs, dynamics.nu())))
}

/// Rows of `n` numbers as an array.
pub(super) fn nodes<'py>(py: Python<'py>, rows: &[DVector<f64>], n: usize) -> Bound<'py, PyAny> {
    stack(py, &[rows.len()], &[n], rows.iter().map(DVector::as_slice)).into_any()
}
