//! Differential dynamic programming.

use dualbody::trajopt::{AnySystem, Curvature, Ddp, DdpOptions, Policy};

use super::problem::{Guess, is_of_user, problem_of};
use super::solution::{curvature_of, solve};
use crate::prelude::*;

pub(super) fn options_of(value: &Bound<'_, PyDict>) -> PyResult<DdpOptions> {
    read_options!(DdpOptions, "Ddp", value;
        max_iterations, tolerance, threads, line_search_steps, exact_curvature = curvature by curvature_of,
        constraint_tolerance = constraints.tolerance, penalty = constraints.penalty)
}

/// Gains of the feedback, (horizon, nu, ndx).
pub(super) fn gains<'py>(
    py: Python<'py>,
    dynamics: &dyn AnySystem,
    policy: &Policy,
) -> PyResult<Bound<'py, PyAny>> {
    let (ndx, nu, all) = (dynamics.ndx(), dynamics.nu(), &policy.gains);
    matrices(py, &[all.len()], [nu, ndx], all.iter()).map(Bound::into_any)
}

functions! {
    /// Solves a problem by differential dynamic programming: see `solution`, with the gains.
    fn _ddp(problem, options: &Bound<'py, PyDict>, guess: Option<Guess<'py>> = None, report = None) -> PyResult<Bound<'py, PyTuple>> {
        let options = options_of(options)?;
        if is_of_user(problem)? && options.curvature == Curvature::Exact {
            refuse!("exact_curvature needs second derivatives, and dynamics that are functions have first ones");
        }
        solve(
            problem,
            guess,
            report,
            problem_of,
            |problem, guess, report| {
                let mut ddp = Ddp::with_options(problem, options);
                ddp.solve_with(problem, guess, report).clone()
            },
            gains,
        )
    }
}
