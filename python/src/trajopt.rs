//! Trajectory optimisation of simulators: problems, differential dynamic programming, receding horizon.

use std::sync::{Mutex, MutexGuard, PoisonError};

use dualbody::Simulator;
use dualbody::model::FrameId;
use dualbody::trajopt::{
    Activation, CenterOfMass, CentroidalMomentum, Constraint, Cost, Curvature, Ddp, DdpOptions,
    DdpSolution, FrameDistance, FrameOrientation, FramePose, FramePosition, FrameVelocity,
    InitialState, InputError, Obstacle, Problem, Progress, RecedingHorizon, Residual, StateError,
    System, Trajectory,
};
use nalgebra::DVector;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::arrays::{Array, empty, numbers_mut, read_matrix, read_vector, write_matrix};
use crate::dynamics::representation;
use crate::errors::{OrRaise, guarded, value_error};
use crate::model::read_pose;
use crate::simulator::PySimulator;

type Owned = Problem<Simulator>;

fn activation_of(value: &Bound<'_, PyAny>) -> PyResult<Activation> {
    let (kind, x, y): (String, Vec<f64>, Vec<f64>) = value.call_method0("_numbers")?.extract()?;
    match (kind.as_str(), x.as_slice()) {
        ("quadratic", _) => Ok(Activation::Quadratic),
        ("weighted", _) => Ok(Activation::Weighted(x)),
        ("smooth_abs", &[width]) => Ok(Activation::SmoothAbs { width }),
        ("flat", &[width]) => Ok(Activation::Flat { width }),
        ("barrier", _) => guarded(|| Activation::barrier(&x, &y)),
        _ => Err(value_error(format_args!(
            "activation is of the unknown kind \"{kind}\""
        ))),
    }
}

/// What is done with a residual, whatever its type.
trait Use {
    type Out;
    fn with<R: Residual<Simulator> + 'static>(self, residual: R) -> PyResult<Self::Out>;
}

/// Makes the residual that a class of Python describes, and uses it.
fn with_residual<U: Use>(
    simulator: &Simulator,
    value: &Bound<'_, PyAny>,
    then: U,
) -> PyResult<U::Out> {
    let kind: String = value.getattr("_kind")?.extract()?;
    let model = simulator.model();
    let frame = |name: &str| -> PyResult<FrameId> {
        let frame: String = value.getattr(name)?.extract()?;
        model.find_frame(&frame).or_raise()
    };
    let target = || value.getattr("target");
    let three = || -> PyResult<[f64; 3]> { Ok(target()?.extract()?) };
    let six = || -> PyResult<[f64; 6]> { Ok(target()?.extract()?) };
    match kind.as_str() {
        "state" => {
            let reference = value.getattr("reference")?;
            if reference.is_none() {
                return then.with(StateError::to_neutral(simulator));
            }
            let rows = reference_rows("reference", &reference, simulator.nx())?;
            match &rows[..] {
                [one] => then.with(guarded(|| StateError::to(one))?),
                all => then.with(guarded(|| StateError::along(all))?),
            }
        }
        "input" => {
            let reference = value.getattr("reference")?;
            if reference.is_none() {
                return then.with(InputError::to_zero(simulator));
            }
            let rows = reference_rows("reference", &reference, Simulator::nu(simulator))?;
            match &rows[..] {
                [one] => then.with(guarded(|| InputError::to(one))?),
                all => then.with(guarded(|| InputError::along(all))?),
            }
        }
        "frame_position" => then.with(FramePosition::new(frame("frame")?, three()?)),
        "frame_orientation" => {
            let target = read_pose("target", &target()?)?.rotation;
            then.with(FrameOrientation {
                frame: frame("frame")?,
                target,
            })
        }
        "frame_pose" => then.with(FramePose {
            frame: frame("frame")?,
            target: read_pose("target", &target()?)?,
        }),
        "frame_velocity" => {
            let name: String = value.getattr("representation")?.extract()?;
            then.with(FrameVelocity {
                frame: frame("frame")?,
                representation: representation(&name)?,
                target: six()?,
            })
        }
        "frame_distance" => {
            let from = value.getattr("from_")?;
            let from = match from.extract::<String>() {
                Ok(name) => Obstacle::Frame(model.find_frame(&name).or_raise()?),
                Err(_) => Obstacle::Point(from.extract::<[f64; 3]>()?.into()),
            };
            then.with(FrameDistance {
                frame: frame("frame")?,
                from,
            })
        }
        "center_of_mass" => then.with(CenterOfMass {
            target: three()?.into(),
        }),
        "centroidal_momentum" => then.with(CentroidalMomentum { target: six()? }),
        _ => Err(value_error(format_args!(
            "residual is of the unknown kind \"{kind}\""
        ))),
    }
}

/// One vector, or one for each stage.
fn reference_rows(
    name: &'static str,
    value: &Bound<'_, PyAny>,
    n: usize,
) -> PyResult<Vec<Vec<f64>>> {
    let axes: usize = crate::arrays::numbers(name, value)?
        .getattr("ndim")?
        .extract()?;
    if axes == 1 {
        return Ok(vec![read_vector(name, value, Some(n))?]);
    }
    let matrix = read_matrix(name, value)?;
    if matrix.ncols() != n {
        return Err(value_error(format_args!(
            "{name} has the shape {:?}, expected (stages, {n})",
            matrix.shape()
        )));
    }
    Ok(matrix
        .row_iter()
        .map(|row| row.iter().copied().collect())
        .collect())
}

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

fn cost_of(simulator: &Simulator, terms: &Bound<'_, PyAny>) -> PyResult<Cost<Simulator>> {
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

fn problem_of(value: &Bound<'_, PyAny>) -> PyResult<Owned> {
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

fn options_of(value: &Bound<'_, PyDict>) -> PyResult<DdpOptions> {
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
fn solution<'py>(
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

fn guess_of(
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

/// Model-predictive controller: solves the problem from where the robot is, a few iterations at each step, and moves the plan along.
#[pyclass(frozen, name = "RecedingHorizon", module = "dualbody.trajopt")]
pub(crate) struct PyRecedingHorizon {
    controller: Mutex<RecedingHorizon<Simulator>>,
}

#[pymethods]
impl PyRecedingHorizon {
    /// problem: a Problem; the keywords are those of Ddp, max_iterations those of each step.
    #[new]
    #[pyo3(signature = (problem, guess=None, **options))]
    fn new(
        py: Python<'_>,
        problem: &Bound<'_, PyAny>,
        guess: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let problem = problem_of(problem)?;
        let none = PyDict::new(py);
        let options = options_of(options.unwrap_or(&none))?;
        let guess = guess_of(&problem, guess)?;
        let controller = guarded(|| RecedingHorizon::from_guess(problem, options, guess))?;
        Ok(Self {
            controller: Mutex::new(controller),
        })
    }

    /// Input (nu,) for the state (q, v).
    #[pyo3(signature = (q, v, contact=None))]
    fn control<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut controller = self.lock();
        let simulator = controller.problem().dynamics();
        let model = simulator.model();
        let mut x = read_vector("q", q, Some(model.nq()))?;
        x.extend(read_vector("v", v, Some(model.nv()))?);
        if let Some(contact) = contact {
            x.extend(read_vector(
                "contact",
                contact,
                Some(simulator.n_contact()),
            )?);
        }
        if let Some(k) = x.iter().position(|x| !x.is_finite()) {
            return Err(value_error(format_args!(
                "the state (q, v)[{k}] is {}",
                x[k]
            )));
        }
        let u = guarded(|| controller.control(&x).to_vec())?;
        Ok(crate::arrays::vector(q.py(), u).into_any())
    }

    /// Replaces the costs.
    fn set_costs(
        &self,
        stage_cost: &Bound<'_, PyAny>,
        final_cost: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let mut controller = self.lock();
        let simulator = controller.problem().dynamics().clone();
        let (stage, last) = (
            cost_of(&simulator, stage_cost)?,
            cost_of(&simulator, final_cost)?,
        );
        let problem = controller.problem_mut();
        guarded(|| {
            problem.set_stage_cost(stage);
            problem.set_final_cost(last);
        })
    }

    /// The plan as a tuple of numbers; see `dualbody.trajopt.plan`.
    fn _solution<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let controller = self.lock();
        solution(py, controller.problem().dynamics(), controller.solution())
    }
}

impl PyRecedingHorizon {
    fn lock(&self) -> MutexGuard<'_, RecedingHorizon<Simulator>> {
        self.controller
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}
