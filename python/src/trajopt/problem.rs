//! Problems: costs, constraints, bounds.

use dualbody::trajopt::{AnySystem, Constraint, Cost, InitialState, Problem, System, Trajectory};

use super::residual::{activation_of, reference_rows, residual_of};
use super::user::UserSystem;
use crate::prelude::*;
use crate::simulator::check_finite;

pub(super) fn cost_of(
    dynamics: &dyn AnySystem,
    terms: &Bound<'_, PyAny>,
    raised: &Raised,
) -> PyResult<Cost> {
    let mut cost = Cost::new();
    for term in terms.try_iter()? {
        let term = term?;
        let (weight, stages) = (attribute(&term, "weight")?, attribute(&term, "stages")?);
        let activation = activation_of(&term.getattr("activation")?)?;
        let residual = residual_of(dynamics, &term.getattr("residual")?, raised)?;
        cost = guarded(|| match stages {
            None => cost.with(weight, activation, residual),
            Some((first, end)) => cost.with_during(first..end, weight, activation, residual),
        })?;
    }
    Ok(cost)
}

fn constraint_of(
    dynamics: &dyn AnySystem,
    value: &Bound<'_, PyAny>,
    raised: &Raised,
) -> PyResult<Constraint> {
    let residual = residual_of(dynamics, &value.getattr("residual")?, raised)?;
    let bounds: Option<(Vec<f64>, Vec<f64>)> = attribute(value, "bounds")?;
    guarded(|| match &bounds {
        None => Constraint::equal_to_zero(dynamics, residual),
        Some((lower, upper)) => Constraint::within(residual, lower, upper),
    })
}

/// Whether the dynamics of a problem are functions of Python.
pub(super) fn is_of_user(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    Ok(!value.getattr("simulator")?.is_instance_of::<PySimulator>())
}

/// A problem whose dynamics are a simulator, or functions of Python.
pub(super) fn problem_of(value: &Bound<'_, PyAny>, raised: &Raised) -> PyResult<Problem> {
    match is_of_user(value)? {
        true => {
            let system = UserSystem::read(&value.getattr("simulator")?, raised)?;
            problem_with(system, value, raised)
        }
        false => problem_of_simulator(value, raised),
    }
}

/// A problem whose dynamics are a simulator.
pub(super) fn problem_of_simulator(value: &Bound<'_, PyAny>, raised: &Raised) -> PyResult<Problem> {
    let simulator = value.getattr("simulator")?;
    let simulator = &simulator.cast::<PySimulator>()?.get().simulator;
    problem_with((**simulator).clone(), value, raised)
}

fn problem_with(
    dynamics: impl System,
    value: &Bound<'_, PyAny>,
    raised: &Raised,
) -> PyResult<Problem> {
    let horizon: usize = attribute(value, "horizon")?;
    let (nx, nu) = (System::nx(&dynamics), System::nu(&dynamics));
    let start = read_vector("start", &value.getattr("start")?, Some(nx))?;
    check_finite("start", &start)?;
    // Jacobians and Hessians of each stage.
    let n = nx.saturating_add(nu);
    check_trajectories(2, horizon, n.saturating_mul(n).saturating_mul(3))?;
    let mut problem = Problem::new(dynamics, horizon, &start);
    let cost = |problem: &Problem, name| cost_of(problem.dynamics(), &value.getattr(name)?, raised);
    let (stage, last) = (cost(&problem, "stage_cost")?, cost(&problem, "final_cost")?);
    problem = problem.with_stage_cost(stage).with_final_cost(last);
    let bounds = value.getattr("input_bounds")?;
    if !bounds.is_none() {
        let nu = Some(problem.dynamics().nu());
        let bound = |k: usize| read_vector("input_bounds", &bounds.get_item(k)?, nu);
        let (lower, upper) = (bound(0)?, bound(1)?);
        problem = problem.with_input_bounds(&lower, &upper);
    }
    for constraint in value.getattr("constraints")?.try_iter()? {
        let constraint = constraint_of(problem.dynamics(), &constraint?, raised)?;
        problem = problem.with_constraint(constraint);
    }
    for constraint in value.getattr("final_constraints")?.try_iter()? {
        let constraint = constraint_of(problem.dynamics(), &constraint?, raised)?;
        problem = problem.with_final_constraint(constraint);
    }
    if attribute(value, "free_start")? {
        problem = problem.with_initial_state(InitialState::Free);
    }
    Ok(problem)
}

/// States, or None where they are rolled out, and inputs.
pub(super) type Guess<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

pub(super) fn guess_of(problem: &Problem, guess: Option<Guess<'_>>) -> PyResult<Trajectory> {
    let Some((states, inputs)) = guess else {
        return guarded(|| Trajectory::zero_input(problem));
    };
    let dynamics = problem.dynamics();
    let (nu, horizon) = (dynamics.nu(), problem.horizon());
    let inputs = rows("guess of the inputs", &inputs, nu, horizon)?;
    if states.is_none() {
        return guarded(|| Trajectory::rollout(problem, &inputs));
    }
    let states = rows("guess of the states", &states, dynamics.nx(), horizon + 1)?;
    Ok(Trajectory { states, inputs })
}

/// So many rows of `n` numbers.
pub(super) fn rows(
    name: &'static str,
    value: &Bound<'_, PyAny>,
    n: usize,
    count: usize,
) -> PyResult<Vec<DVector<f64>>> {
    let rows = reference_rows(name, value, n)?;
    match rows.len() == count {
        true => Ok(rows.into_iter().map(DVector::from_vec).collect()),
        false => Err(invalid!("{name} has {} rows, expected {count}", rows.len())),
    }
}

functions! {
    /// Cost and constraint violation of a trajectory.
    fn _trajectory_cost(problem, states: Bound<'py, PyAny>, inputs: Bound<'py, PyAny>) -> PyResult<(f64, f64)> {
        let (py, raised) = (problem.py(), Raised::default());
        let problem = problem_of(problem, &raised)?;
        let trajectory = guess_of(&problem, Some((states, inputs)))?;
        let both = || (trajectory.cost(&problem), trajectory.violation(&problem));
        let found = py.detach(|| guarded(both));
        raised.check()?;
        found
    }
}

/// Barriers and bounds of a robot's limits: (lower, upper) of positions as states, and of efforts.
#[pyfunction]
pub(crate) fn _position_bounds(simulator: &Bound<'_, PySimulator>) -> (Vec<f64>, Vec<f64>) {
    dualbody::trajopt::position_bounds(&*simulator.get().simulator)
}
