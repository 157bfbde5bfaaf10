//! Problems: costs, constraints, bounds.

use dualbody::Simulator;
use dualbody::trajopt::{
    Activation, Constraint, Cost, InitialState, Problem, Residual, System, Trajectory,
};
use nalgebra::DVector;
use pyo3::prelude::*;

use super::residual::{Use, activation_of, reference_rows, with_residual};
use crate::arrays::read_vector;
use crate::errors::{guarded, value_error};
use crate::simulator::PySimulator;

type Owned = Problem<Simulator>;

struct AddTerm(Cost<Simulator>, f64, Activation, Option<(usize, usize)>);

impl Use for AddTerm {
    type Out = Cost<Simulator>;

    fn with<R: Residual<Simulator> + 'static>(self, residual: R) -> PyResult<Self::Out> {
        let Self(cost, weight, activation, stages) = self;
        guarded(|| match stages {
            None => cost.with(weight, activation, residual),
            Some((first, end)) => cost.with_during(first..end, weight, activation, residual),
        })
    }
}

enum AddConstraint<'a> {
    Within(&'a [f64], &'a [f64]),
    Zero(&'a Simulator),
}

impl Use for AddConstraint<'_> {
    type Out = Constraint<Simulator>;

    fn with<R: Residual<Simulator> + 'static>(self, residual: R) -> PyResult<Self::Out> {
        guarded(|| match self {
            Self::Within(lower, upper) => Constraint::within(residual, lower, upper),
            Self::Zero(simulator) => Constraint::equal_to_zero(simulator, residual),
        })
    }
}

pub(super) fn cost_of(
    simulator: &Simulator,
    terms: &Bound<'_, PyAny>,
) -> PyResult<Cost<Simulator>> {
    let mut cost = Cost::new();
    for term in terms.try_iter()? {
        let term = term?;
        let (weight, stages) = (
            term.getattr("weight")?.extract()?,
            term.getattr("stages")?.extract()?,
        );
        let activation = activation_of(&term.getattr("activation")?)?;
        cost = with_residual(
            simulator,
            &term.getattr("residual")?,
            AddTerm(cost, weight, activation, stages),
        )?;
    }
    Ok(cost)
}

fn constraint_of(
    simulator: &Simulator,
    value: &Bound<'_, PyAny>,
) -> PyResult<Constraint<Simulator>> {
    let residual = value.getattr("residual")?;
    let bounds: Option<(Vec<f64>, Vec<f64>)> = value.getattr("bounds")?.extract()?;
    match &bounds {
        None => with_residual(simulator, &residual, AddConstraint::Zero(simulator)),
        Some((lower, upper)) => {
            with_residual(simulator, &residual, AddConstraint::Within(lower, upper))
        }
    }
}

pub(super) fn problem_of(value: &Bound<'_, PyAny>) -> PyResult<Owned> {
    let simulator = value.getattr("simulator")?.cast_into::<PySimulator>()?;
    let simulator = &*simulator.get().simulator;
    let horizon: usize = value.getattr("horizon")?.extract()?;
    let start = read_vector("start", &value.getattr("start")?, Some(simulator.nx()))?;
    let mut problem = guarded(|| Problem::new(simulator.clone(), horizon, &start))?
        .with_stage_cost(cost_of(simulator, &value.getattr("stage_cost")?)?)
        .with_final_cost(cost_of(simulator, &value.getattr("final_cost")?)?);
    let bounds = value.getattr("input_bounds")?;
    if !bounds.is_none() {
        let nu = Some(Simulator::nu(simulator));
        let bound = |k: usize| read_vector("input_bounds", &bounds.get_item(k)?, nu);
        let (lower, upper) = (bound(0)?, bound(1)?);
        problem = guarded(|| problem.with_input_bounds(&lower, &upper))?;
    }
    for constraint in value.getattr("constraints")?.try_iter()? {
        problem = problem.with_constraint(constraint_of(simulator, &constraint?)?);
    }
    for constraint in value.getattr("final_constraints")?.try_iter()? {
        problem = problem.with_final_constraint(constraint_of(simulator, &constraint?)?);
    }
    if value.getattr("free_start")?.extract()? {
        problem = problem.with_initial_state(InitialState::Free);
    }
    Ok(problem)
}

pub(super) fn guess_of(
    problem: &Owned,
    guess: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
) -> PyResult<Trajectory> {
    let Some((states, inputs)) = guess else {
        return guarded(|| Trajectory::zero_input(problem));
    };
    let simulator = problem.dynamics();
    let rows = |name, value, n, count: usize| -> PyResult<Vec<DVector<f64>>> {
        let rows = reference_rows(name, value, n)?;
        match rows.len() == count {
            true => Ok(rows.into_iter().map(DVector::from_vec).collect()),
            false => Err(value_error(format_args!(
                "{name} has {} rows, expected {count}",
                rows.len()
            ))),
        }
    };
    let inputs = rows(
        "guess of the inputs",
        &inputs,
        Simulator::nu(simulator),
        problem.horizon(),
    )?;
    if states.is_none() {
        return guarded(|| Trajectory::rollout(problem, &inputs));
    }
    let states = rows(
        "guess of the states",
        &states,
        simulator.nx(),
        problem.horizon() + 1,
    )?;
    Ok(Trajectory { states, inputs })
}

/// Cost and constraint violation of a trajectory.
#[pyfunction]
pub(crate) fn _trajectory_cost(
    problem: &Bound<'_, PyAny>,
    states: Bound<'_, PyAny>,
    inputs: Bound<'_, PyAny>,
) -> PyResult<(f64, f64)> {
    let problem = problem_of(problem)?;
    let trajectory = guess_of(&problem, Some((states, inputs)))?;
    guarded(|| (trajectory.cost(&problem), trajectory.violation(&problem)))
}

/// Barriers and bounds of a robot's limits: (lower, upper) of positions as states, and of efforts.
#[pyfunction]
pub(crate) fn _position_bounds(simulator: &Bound<'_, PySimulator>) -> (Vec<f64>, Vec<f64>) {
    dualbody::trajopt::position_bounds(&*simulator.get().simulator)
}
