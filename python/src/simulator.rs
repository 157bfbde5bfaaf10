//! Simulators: steps, rollouts, Jacobians, of one state and of batches.

use std::cell::RefCell;
use std::sync::{Arc, Mutex};

use dualbody::linearize::LinearizeScratch;
use dualbody::sim::{BatchSimulator, BatchStates, Integrator, RolloutStatus, StepScratch};
use dualbody::{Linearization, Model, Simulator, State};
use nalgebra::DVector;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyFloatingPointError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple};

use crate::arrays::{
    Array, Rows, WIDTH, argument, checked_output, empty, numbers_mut, vector, write_matrix,
};
use crate::contact::{actuation_of, contacts_of, point_numbers, with_parts};
use crate::errors::{OrRaise, guarded, value_error};
use crate::model::{PyModel, next_id};
use crate::rollout::{Inputs, read_inputs};
use crate::threads::{on_pool, pool};

/// Simulator of a robot: what acts on it, and how it steps. Immutable; pickles, and steps to the same bits then.
#[pyclass(frozen, subclass, name = "Simulator", module = "dualbody", weakref)]
pub(crate) struct PySimulator {
    pub(crate) simulator: Arc<Simulator>,
    id: u64,
    model: Py<PyModel>,
    /// What it was made with, by name.
    parts: Py<PyDict>,
    /// Working memory of the last batch.
    batch: Mutex<Option<BatchSimulator>>,
}

/// A simulator of a batch that is in use.
pub(crate) struct Batch {
    pub(crate) simulator: BatchSimulator,
    /// Whether the next call may use it: all its robots are that of the simulator.
    is_kept: bool,
}

fn integrator_of(name: &str) -> PyResult<Integrator> {
    match name {
        "semi_implicit_euler" => Ok(Integrator::SemiImplicitEuler),
        "implicit_velocity" => Ok(Integrator::ImplicitVelocity),
        "runge_kutta_4" => Ok(Integrator::RungeKutta4),
        _ => Err(value_error(format_args!(
            "integrator is \"{name}\", not \"semi_implicit_euler\", \"implicit_velocity\" or \"runge_kutta_4\""
        ))),
    }
}

fn build(model: &Model, parts: &Bound<'_, PyDict>) -> PyResult<Simulator> {
    let get = |name: &str| parts.as_any().get_item(name);
    let mut simulator = guarded(|| Simulator::new(model.clone()))?;
    if let Some(time_step) = get("time_step")?.extract()? {
        simulator = guarded(|| simulator.with_time_step(time_step))?;
    }
    if let Some(bound) = get("divergence_bound")?.extract()? {
        simulator = guarded(|| simulator.with_divergence_bound(bound))?;
    }
    let integrator: String = get("integrator")?.extract()?;
    simulator = simulator.with_integrator(integrator_of(&integrator)?);
    if let Some(names) = get("actuated")?.extract::<Option<Vec<String>>>()? {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        simulator = guarded(|| simulator.with_actuated_joints(&names))?.or_raise()?;
    }
    let actuation = get("actuation")?;
    if !actuation.is_none() {
        let actuation = actuation_of(model, &actuation)?;
        simulator = guarded(|| simulator.with_actuation(actuation))?;
    }
    let contacts = get("contacts")?;
    if !contacts.is_none() {
        let contacts = contacts_of(model, &contacts)?;
        simulator = guarded(|| simulator.with_contacts(contacts))?;
    }
    with_parts(simulator, parts.as_any())
}

/// Working memory of a thread for a simulator.
struct StepMemory {
    id: u64,
    scratch: StepScratch<f64>,
    state: State,
    next: State,
    u: Vec<f64>,
    linear: Option<(LinearizeScratch, Linearization)>,
}

thread_local! {
    static MEMORIES: RefCell<Vec<StepMemory>> = const { RefCell::new(Vec::new()) };
}

/// Working memory that a thread keeps, for as many simulators.
const KEPT: usize = 8;

/// A state, or a batch of them, with an input.
struct Given<'py> {
    q: Rows<'py>,
    v: Rows<'py>,
    u: Option<Rows<'py>>,
    contact: Option<Rows<'py>>,
    batch: Vec<usize>,
}

impl<'py> Given<'py> {
    fn all(&self) -> impl Iterator<Item = &Rows<'py>> {
        [
            Some(&self.q),
            Some(&self.v),
            self.u.as_ref(),
            self.contact.as_ref(),
        ]
        .into_iter()
        .flatten()
    }

    fn count(&self) -> usize {
        self.batch.iter().product()
    }
}

pub(crate) fn row<'a>(rows: &'a Rows<'_>, k: usize, width: usize) -> &'a [f64] {
    let k = if rows.batch().is_empty() { 0 } else { k };
    &rows.as_slice()[k * width..(k + 1) * width]
}

/// Checks that all arguments are of one batch, or of none.
fn common_batch<'a>(
    batches: impl Iterator<Item = (&'static str, &'a [usize])>,
) -> PyResult<Vec<usize>> {
    let mut known: Option<(&'static str, &[usize])> = None;
    for (name, batch) in batches.filter(|(_, batch)| !batch.is_empty()) {
        match known {
            Some((other, shape)) if shape != batch => {
                return Err(value_error(format_args!(
                    "{name} is a batch of shape {batch:?}, {other} one of shape {shape:?}"
                )));
            }
            _ => known = Some((name, batch)),
        }
    }
    Ok(known.map_or(Vec::new(), |(_, batch)| batch.to_vec()))
}

fn check_finite(name: &str, x: &[f64]) -> PyResult<()> {
    match x.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(k) => Err(value_error(format_args!("{name}[{k}] is {}", x[k]))),
    }
}

impl PySimulator {
    pub(crate) fn sizes(&self) -> (usize, usize, usize, usize) {
        let model = self.simulator.model();
        (
            model.nq(),
            model.nv(),
            self.simulator.nu(),
            self.simulator.n_contact(),
        )
    }

    fn read<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Given<'py>> {
        let (nq, nv, nu, nc) = self.sizes();
        let read =
            |name, value: &Bound<'py, PyAny>, n: usize| Rows::read(&argument(name, value, &[n]));
        if contact.is_none() && nc > 0 {
            return Err(value_error(
                "contact is missing: this simulator's contacts have a state, which begins as simulator.neutral_contact()",
            ));
        }
        let given = Given {
            q: read("q", q, nq)?,
            v: read("v", v, nv)?,
            u: u.map(|u| read("u", u, nu)).transpose()?,
            contact: contact
                .map(|contact| read("contact", contact, nc))
                .transpose()?,
            batch: Vec::new(),
        };
        let names = ["q", "v", "u", "contact"];
        let present = [
            Some(&given.q),
            Some(&given.v),
            given.u.as_ref(),
            given.contact.as_ref(),
        ];
        let batches = names.into_iter().zip(present);
        let batch = common_batch(batches.filter_map(|(name, rows)| Some((name, rows?.batch()))))?;
        Ok(Given { batch, ..given })
    }

    /// A state of a batch, checked.
    fn state(&self, given: &Given<'_>, k: usize) -> PyResult<State> {
        let (nq, nv, _, nc) = self.sizes();
        let state = State::new(row(&given.q, k, nq), row(&given.v, k, nv));
        let state = match &given.contact {
            Some(contact) => state.with_contact(DVector::from_column_slice(row(contact, k, nc))),
            None => state,
        };
        state.check(self.simulator.model()).or_raise()?;
        Ok(state)
    }

    fn states(&self, given: &Given<'_>, count: usize) -> PyResult<Vec<State>> {
        (0..count).map(|k| self.state(given, k)).collect()
    }

    /// The inputs of all states, one after the other.
    fn inputs(&self, given: &Given<'_>, count: usize) -> PyResult<Vec<f64>> {
        let nu = self.simulator.nu();
        let Some(u) = &given.u else {
            return Ok(vec![0.0; count * nu]);
        };
        check_finite("u", u.as_slice())?;
        Ok((0..count)
            .flat_map(|k| row(u, k, nu).iter().copied())
            .collect())
    }

    /// Runs work with this thread's memory for one state, in which state and input are set.
    fn with_memory<R>(
        &self,
        given: &Given<'_>,
        work: impl FnOnce(&mut StepMemory) -> R,
    ) -> PyResult<R> {
        let (nq, nv, nu, nc) = self.sizes();
        MEMORIES.with_borrow_mut(|all| {
            let at = match all.iter().position(|memory| memory.id == self.id) {
                Some(at) => at,
                None => {
                    if all.len() == KEPT {
                        all.remove(0);
                    }
                    all.push(guarded(|| self.memory())?);
                    all.len() - 1
                }
            };
            let memory = &mut all[at];
            memory
                .state
                .q
                .as_mut_slice()
                .copy_from_slice(row(&given.q, 0, nq));
            memory
                .state
                .v
                .as_mut_slice()
                .copy_from_slice(row(&given.v, 0, nv));
            if let Some(contact) = &given.contact {
                memory
                    .state
                    .contact
                    .as_mut_slice()
                    .copy_from_slice(row(contact, 0, nc));
            }
            match &given.u {
                Some(u) => memory.u.copy_from_slice(row(u, 0, nu)),
                None => memory.u.fill(0.0),
            }
            check_finite("u", &memory.u)?;
            memory.state.check(self.simulator.model()).or_raise()?;
            guarded(|| work(memory))
        })
    }

    fn memory(&self) -> StepMemory {
        let state = self.simulator.neutral_state();
        StepMemory {
            id: self.id,
            scratch: StepScratch::new(&self.simulator),
            next: state.clone(),
            state,
            u: vec![0.0; self.simulator.nu()],
            linear: None,
        }
    }

    /// Runs work with the memory for batches of a length, on the pool.
    fn on_batch<R: Send>(
        &self,
        py: Python<'_>,
        length: usize,
        work: impl FnOnce(&mut BatchSimulator) -> R + Send,
    ) -> PyResult<R> {
        let mut batch = self.take_batch(py, length, None)?;
        let (out, batch) = on_pool(py, move || (work(&mut batch.simulator), batch))?;
        self.put_batch(batch);
        Ok(out)
    }

    /// The memory for batches of a length, each state with a robot of its own if there are `models`.
    pub(crate) fn take_batch(
        &self,
        py: Python<'_>,
        length: usize,
        models: Option<&[Py<PyModel>]>,
    ) -> PyResult<Batch> {
        let threads = pool()?
            .current_num_threads()
            .min(length.div_ceil(WIDTH))
            .max(1);
        if let Some(models) = models {
            if models.len() != length {
                let given = models.len();
                return Err(value_error(format_args!(
                    "{given} models for {length} states"
                )));
            }
            let models: Vec<Model> = models.iter().map(|m| (*m.get().model).clone()).collect();
            let made = on_pool(py, || BatchSimulator::of_variants(&self.simulator, models))?;
            let simulator = made.or_raise()?.with_threads(threads);
            return Ok(Batch {
                simulator,
                is_kept: false,
            });
        }
        let kept = self
            .batch
            .try_lock()
            .ok()
            .and_then(|mut batch| batch.take());
        let simulator = match kept {
            Some(batch) if batch.len() == length && batch.threads() == threads => batch,
            _ => {
                let simulator = (*self.simulator).clone();
                on_pool(py, || {
                    BatchSimulator::new(simulator, length).with_threads(threads)
                })?
            }
        };
        Ok(Batch {
            simulator,
            is_kept: true,
        })
    }

    pub(crate) fn put_batch(&self, batch: Batch) {
        if batch.is_kept
            && let Ok(mut kept) = self.batch.try_lock()
        {
            *kept = Some(batch.simulator);
        }
    }

    /// Arrays for the next state: those of the caller, or new ones.
    fn outputs<'py>(
        &self,
        py: Python<'py>,
        given: &Given<'py>,
        out: Option<&Bound<'py, PyTuple>>,
    ) -> PyResult<Vec<Array<'py>>> {
        let (nq, nv, _, nc) = self.sizes();
        let widths = [("out[0]", nq), ("out[1]", nv), ("out[2]", nc)];
        let count = if given.contact.is_some() { 3 } else { 2 };
        let shape = |n: usize| [given.batch.as_slice(), &[n]].concat();
        let Some(out) = out else {
            return Ok(widths[..count]
                .iter()
                .map(|&(_, n)| empty(py, &shape(n)))
                .collect());
        };
        if out.len() != count {
            return Err(value_error(format_args!(
                "out has {} arrays, expected {count}",
                out.len()
            )));
        }
        let arrays = widths[..count].iter().zip(out.iter());
        arrays
            .map(|(&(name, n), array)| checked_output(name, &array, &shape(n)))
            .collect()
    }
}

/// Writes the states of a batch into arrays of q, v and the state of contact.
pub(crate) fn write_states(states: &BatchStates, out: &[Array<'_>]) {
    let mut out: Vec<&mut [f64]> = out.iter().map(|array| numbers_mut(array)).collect();
    for (k, group) in states.groups().enumerate() {
        for lane in 0..WIDTH.min(states.len() - k * WIDTH) {
            let parts = [&group.q, &group.v, &group.contact];
            for (out, x) in out.iter_mut().zip(parts) {
                let start = (k * WIDTH + lane) * x.len();
                let row = &mut out[start..start + x.len()];
                row.iter_mut()
                    .zip(x.iter())
                    .for_each(|(out, x)| *out = x.0[lane]);
            }
        }
    }
}

fn diverged(k: Option<usize>) -> PyErr {
    let which = k.map_or(String::new(), |k| format!(" of state {k} of the batch"));
    PyFloatingPointError::new_err(format!("the step{which} diverged"))
}

#[pymethods]
impl PySimulator {
    #[new]
    #[pyo3(signature = (model, *, time_step=None, integrator="semi_implicit_euler", actuated=None, contacts=None, actuation=None,
        constraints=None, external_forces=None, frame_actuators=None, divergence_bound=None))]
    fn new(
        py: Python<'_>,
        model: &Bound<'_, PyModel>,
        time_step: Option<f64>,
        integrator: &str,
        actuated: Option<Bound<'_, PyAny>>,
        contacts: Option<Bound<'_, PyAny>>,
        actuation: Option<Bound<'_, PyAny>>,
        constraints: Option<Vec<Bound<'_, PyAny>>>,
        external_forces: Option<Vec<Bound<'_, PyAny>>>,
        frame_actuators: Option<Vec<Bound<'_, PyAny>>>,
        divergence_bound: Option<f64>,
    ) -> PyResult<Self> {
        let parts = PyDict::new(py);
        parts.set_item("time_step", time_step)?;
        parts.set_item("integrator", integrator)?;
        parts.set_item("actuated", actuated)?;
        parts.set_item("contacts", contacts)?;
        parts.set_item("actuation", actuation)?;
        parts.set_item("constraints", constraints.unwrap_or_default())?;
        parts.set_item("external_forces", external_forces.unwrap_or_default())?;
        parts.set_item("frame_actuators", frame_actuators.unwrap_or_default())?;
        parts.set_item("divergence_bound", divergence_bound)?;
        Ok(Self {
            simulator: Arc::new(build(&model.get().model, &parts)?),
            id: next_id(),
            model: model.clone().unbind(),
            parts: parts.unbind(),
            batch: Mutex::new(None),
        })
    }

    #[getter]
    pub(crate) fn model(&self, py: Python<'_>) -> Py<PyModel> {
        self.model.clone_ref(py)
    }

    /// Time step, s.
    #[getter]
    fn time_step(&self) -> f64 {
        self.simulator.time_step()
    }

    #[getter]
    fn integrator(&self) -> &'static str {
        match self.simulator.integrator() {
            Integrator::ImplicitVelocity => "implicit_velocity",
            Integrator::RungeKutta4 => "runge_kutta_4",
            _ => "semi_implicit_euler",
        }
    }

    /// Number of inputs.
    #[getter]
    fn nu(&self) -> usize {
        self.simulator.nu()
    }

    /// Numbers of the state of contact: zero but for contacts with bristles.
    #[getter]
    fn n_contact(&self) -> usize {
        self.simulator.n_contact()
    }

    /// Number of tangent directions of the state.
    #[getter]
    fn n_tangent(&self) -> usize {
        self.simulator.n_tangent()
    }

    #[getter]
    fn divergence_bound(&self) -> f64 {
        self.simulator.divergence_bound()
    }

    /// Names of the inputs.
    #[getter]
    fn input_names(&self) -> Vec<String> {
        self.simulator.input_names()
    }

    /// The least and the largest input that the joints' effort limits allow: (nu,) twice, infinite where there is no limit.
    #[getter]
    fn effort_bounds<'py>(&self, py: Python<'py>) -> (Bound<'py, PyAny>, Bound<'py, PyAny>) {
        let (lower, upper) = self.simulator.effort_bounds();
        (vector(py, lower).into_any(), vector(py, upper).into_any())
    }

    /// The points of contact: [(link, centre in its frame (3,), kind)].
    #[getter]
    fn contact_points(&self) -> Vec<(String, [f64; 3], String)> {
        let model = self.simulator.model();
        let points = self
            .simulator
            .contacts()
            .map_or(&[][..], |contacts| contacts.points());
        let one = |point| {
            let (link, _, center, kind, _) = point_numbers(point);
            (model.frames()[link].name.clone(), center, kind)
        };
        points.iter().map(one).collect()
    }

    /// Collision shapes that cannot touch: [(link, reason)].
    #[getter]
    fn shapes_without_points(&self) -> Vec<(String, String)> {
        let shapes = self
            .simulator
            .contacts()
            .map_or(&[][..], |c| c.shapes_without_points());
        shapes
            .iter()
            .map(|shape| (shape.link.clone(), shape.reason.clone()))
            .collect()
    }

    /// The state of contact of a robot that touches nothing, (n_contact,).
    fn neutral_contact<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, vec![0.0; self.simulator.n_contact()]).into_any()
    }

    /// Advances by one time step with the input held: the next (q, v), or (q, v, contact) if contact is given.
    ///
    /// q (..., nq), v (..., nv), u (..., nu; N·m or N; zero if left out), contact (..., n_contact) where contacts have a state.
    /// out: arrays for the next state, which may be those of the state. Raises FloatingPointError if the next state is not finite.
    #[pyo3(signature = (q, v, u=None, *, contact=None, out=None))]
    fn step<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
        out: Option<&Bound<'py, PyTuple>>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let py = q.py();
        let given = self.read(q, v, u, contact)?;
        let arrays = self.outputs(py, &given, out)?;
        if given.batch.is_empty() {
            let finite = self.with_memory(&given, |memory| {
                let StepMemory {
                    scratch,
                    state,
                    next,
                    u,
                    ..
                } = memory;
                self.simulator.step_into(state, u, scratch, next);
                let parts = [
                    next.q.as_slice(),
                    next.v.as_slice(),
                    next.contact.as_slice(),
                ];
                arrays
                    .iter()
                    .zip(parts)
                    .for_each(|(array, x)| numbers_mut(array).copy_from_slice(x));
                next.is_finite()
            })?;
            if !finite {
                return Err(diverged(None));
            }
        } else if given.count() > 0 {
            let count = given.count();
            let (states, inputs) = (self.states(&given, count)?, self.inputs(&given, count)?);
            let next = self.on_batch(py, count, |batch| {
                let mut all = batch.states(&states);
                batch.step(&mut all, &inputs);
                all
            })?;
            let stopped = |i: &usize| !matches!(next.status(*i), RolloutStatus::Completed);
            if let Some(i) = (0..count).find(stopped) {
                return Err(diverged(Some(i)));
            }
            write_states(&next, &arrays);
        }
        PyTuple::new(py, arrays)
    }

    /// Jacobians of the step in tangent coordinates: a (..., n_tangent, n_tangent), b (..., n_tangent, nu). Arguments as in step.
    #[pyo3(signature = (q, v, u=None, *, contact=None))]
    fn linearize<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = q.py();
        let given = self.read(q, v, u, contact)?;
        let (n, nu) = (self.simulator.n_tangent(), self.simulator.nu());
        let shape = |columns: usize| [given.batch.as_slice(), &[n, columns]].concat();
        let (a, b) = (empty(py, &shape(n)), empty(py, &shape(nu)));
        let write = |k: usize, linear: &Linearization| {
            write_matrix(&linear.a, &mut numbers_mut(&a)[k * n * n..(k + 1) * n * n]);
            write_matrix(
                &linear.b,
                &mut numbers_mut(&b)[k * n * nu..(k + 1) * n * nu],
            );
        };
        if given.batch.is_empty() {
            self.with_memory(&given, |memory| {
                let StepMemory {
                    state, u, linear, ..
                } = memory;
                let (scratch, out) = linear.get_or_insert_with(|| {
                    (
                        LinearizeScratch::new(&self.simulator),
                        Linearization::zeros(&self.simulator),
                    )
                });
                self.simulator.linearize_into(state, u, scratch, out);
                write(0, out);
            })?;
        } else if given.count() > 0 {
            let count = given.count();
            let (states, inputs) = (self.states(&given, count)?, self.inputs(&given, count)?);
            let all = self.on_batch(py, count, |batch| batch.linearize(&states, &inputs))?;
            all.iter()
                .enumerate()
                .for_each(|(k, linear)| write(k, linear));
        }
        static LINEARIZATION: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        LINEARIZATION
            .import(py, "dualbody.sim", "Linearization")?
            .call1((a, b))
    }

    /// Takes steps from a state, or from each state of a batch, and returns a Rollout.
    ///
    /// q (..., nq), v (..., nv), contact (..., n_contact); inputs (..., steps, nu) or (steps, nu) for all, or control(k, q, v) -> u with the
    /// arrays of all states of step k; without both, the inputs are zero. models: a robot for each state of a batch, of the same structure. progress: True for a bar (tqdm, if it is installed), or a
    /// function of the number of steps done. A trajectory that stops says so in the status; its numbers are NaN from there on.
    #[pyo3(signature = (q, v, steps=None, *, control=None, inputs=None, contact=None, models=None, progress=None))]
    fn rollout<'py>(
        this: &Bound<'py, Self>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        steps: Option<usize>,
        control: Option<&Bound<'py, PyAny>>,
        inputs: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
        models: Option<Vec<Py<PyModel>>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, own) = (q.py(), this.get());
        let (nq, nv, nu, nc) = own.sizes();
        if control.is_some() && inputs.is_some() {
            return Err(value_error("control and inputs are both given"));
        }
        let given = own.read(q, v, None, contact)?;
        let (inputs, steps) = read_inputs(inputs, steps, nu)?;
        let own_batch = inputs.as_ref().map_or(&[][..], |inputs| inputs.batch());
        let names = given
            .all()
            .map(|rows| ("q", rows.batch()))
            .chain([("inputs", own_batch)]);
        let batch = common_batch(names)?;
        let count: usize = batch.iter().product();
        if batch.is_empty() && models.is_some() {
            return Err(value_error(
                "models are for a batch, and there is one state",
            ));
        }
        let states = own.states(&given, count)?;
        let numbers = match &inputs {
            None => Inputs::None,
            Some(inputs) => Inputs::Given {
                numbers: inputs.as_slice(),
                shared: inputs.batch().is_empty(),
            },
        };
        let helper = py.import("dualbody.sim")?;
        let sizes = (steps, count);
        let bar =
            helper
                .getattr("_progress")?
                .call1((progress, sizes, control.is_some(), WIDTH))?;
        let bar = Some(&bar).filter(|bar| !bar.is_none());
        let (out, u) = match (control, batch.is_empty()) {
            (Some(control), true) => {
                own.roll_one_controlled(py, &states[0], steps, control, bar)?
            }
            (Some(control), false) => {
                let taken = own.take_batch(py, count, models.as_deref())?;
                own.roll_batch_controlled(py, taken, &states, &batch, steps, control, bar)?
            }
            (None, true) => (
                own.roll_one(py, &states[0], steps, &numbers, bar)?,
                Vec::new(),
            ),
            (None, false) if count == 0 => return Err(value_error("the batch is empty")),
            (None, false) => (
                {
                    let taken = own.take_batch(py, count, models.as_deref())?;
                    own.roll_batch(py, taken, &states, steps, &numbers, bar)?
                },
                Vec::new(),
            ),
        };
        let width = nq + nv + nc;
        let all = PyArray1::from_vec(py, out.states).reshape([out.padded, steps + 1, width])?;
        let u = match control {
            Some(_) => Some(PyArray1::from_vec(py, u).reshape([count, steps, nu])?),
            None => None,
        };
        let make = helper.getattr("_rollout")?;
        make.call1((
            this,
            batch,
            (all, u, inputs.map(Rows::into_array)),
            out.statuses,
            out.failures,
            bar,
        ))
    }

    /// What touches and how in a state under an input: a ContactReport.
    #[pyo3(signature = (q, v, u=None, *, contact=None))]
    fn contact_report<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = q.py();
        let given = self.one(q, v, u, contact)?;
        let report = self.with_memory(&given, |memory| {
            self.simulator.contact_report(&memory.state, &memory.u)
        })?;
        let rows = |n: usize, x: Vec<f64>| {
            PyArray1::from_vec(py, x).reshape([report.points.len().min(n), 3])
        };
        let n = report.points.len();
        let three = |f: fn(&dualbody::contact::PointState<f64>) -> [f64; 3]| {
            rows(n, report.points.iter().flat_map(f).collect())
        };
        let forces = report.forces.iter().flat_map(|f| [f.x, f.y, f.z]).collect();
        let links: Vec<f64> = report.links.iter().flat_map(|f| f.to_array()).collect();
        let links = PyArray1::from_vec(py, links).reshape([report.links.len(), 6])?;
        let c = &report.certificate;
        let certificate = (
            format!("{:?}", c.status),
            c.iterations,
            c.residual,
            c.cone_violation,
            c.complementarity,
            c.dual_violation,
        );
        let depths: Vec<f64> = report.points.iter().map(|p| p.depth).collect();
        let fields = (
            three(|p| p.position.into())?,
            three(|p| p.velocity.into())?,
            three(|p| p.normal.into())?,
            vector(py, depths),
            rows(n, forces)?,
            links,
            report
                .modes
                .iter()
                .map(|mode| format!("{mode:?}"))
                .collect::<Vec<_>>(),
            report
                .reasons
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>(),
            vector(py, report.constraints.clone()),
            certificate,
        );
        py.import("dualbody.sim")?
            .getattr("ContactReport")?
            .call1(fields)
    }

    /// Errors of the constraints in a state, row by row.
    fn constraint_errors<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let given = self.one(q, v, None, None)?;
        let errors = self.with_memory(&given, |memory| {
            self.simulator.constraint_errors(&memory.state)
        })?;
        Ok(vector(q.py(), errors).into_any())
    }

    /// The nearest state in which the constraints hold: (q, v). A ValueError says how far it came if there is none.
    fn assemble<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let given = self.one(q, v, None, None)?;
        let state = self
            .with_memory(&given, |memory| self.simulator.assemble(&memory.state))?
            .or_raise()?
            .state;
        let array = |x: &DVector<f64>| vector(q.py(), x.as_slice().to_vec()).into_any();
        Ok((array(&state.q), array(&state.v)))
    }

    /// The simulator with parts replaced: the keywords of its constructor.
    #[pyo3(signature = (**changes))]
    fn replace<'py>(
        this: &Bound<'py, Self>,
        changes: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = this.py();
        let parts = this.get().parts.bind(py).copy()?;
        let model = this.get().model.clone_ref(py).into_any();
        let mut model = model.into_bound(py);
        for (name, value) in changes.into_iter().flatten() {
            match name.extract::<String>()?.as_str() {
                "model" => model = value,
                _ => parts.set_item(name, value)?,
            }
        }
        this.get_type().call((model,), Some(&parts))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let s = &self.simulator;
        let mut text = format!(
            "Simulator({}, time_step={}, integrator=\"{}\", nu={}",
            self.model.bind(py).repr()?,
            s.time_step(),
            self.integrator(),
            s.nu()
        );
        if let Some(contacts) = s.contacts() {
            text += &format!(", {} contact points", contacts.points().len());
        }
        if !s.constraints().is_empty() {
            text += &format!(", {} constraints", s.constraints().len());
        }
        Ok(text + ")")
    }

    fn __reduce__<'py>(this: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Py<PyAny>)> {
        let (py, own) = (this.py(), this.get());
        let parts = own.parts.bind(py).copy()?;
        if let Some(contacts) = own.simulator.contacts() {
            // Points of meshes travel with the simulator: their files may be missing elsewhere.
            let points: Vec<_> = contacts.points().iter().map(point_numbers).collect();
            let described = parts
                .as_any()
                .get_item("contacts")?
                .call_method1("_with_points", (points,))?;
            parts.set_item("contacts", described)?;
        }
        let make = py.import("dualbody._dualbody")?.getattr("_simulator")?;
        let arguments = (this.get_type(), own.model.clone_ref(py), parts).into_pyobject(py)?;
        Ok((make, arguments.into_any().unbind()))
    }
}

impl PySimulator {
    /// One state, not a batch.
    fn one<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Given<'py>> {
        let given = self.read(q, v, u, contact)?;
        match given.batch.is_empty() {
            true => Ok(given),
            false => Err(value_error(format_args!(
                "one state is expected, not a batch of shape {:?}",
                given.batch
            ))),
        }
    }
}

/// Makes a simulator again.
#[pyfunction]
pub(crate) fn _simulator<'py>(
    class: &Bound<'py, PyAny>,
    model: &Bound<'py, PyAny>,
    parts: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    class.call((model,), Some(parts))
}
