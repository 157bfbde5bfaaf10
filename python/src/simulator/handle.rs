//! The class `Simulator`.

use std::sync::{Arc, Mutex};

use dualbody::contact::Contacts;
use dualbody::sim::{BatchSimulator, BatchStates, Integrator};

use crate::contact::{actuation_of, contacts_of, point_numbers, with_parts};
use crate::model::{_scene_model, PyScene, next_id};
use crate::prelude::*;

/// A simulator of a batch.
pub(crate) struct Batch {
    pub(crate) simulator: BatchSimulator,
    /// Memory for the states of a step, once there was one.
    pub(super) states: Option<BatchStates>,
    /// Whether the next call may use it: all its robots are that of the simulator.
    pub(super) is_kept: bool,
}

/// Simulator of a robot: what acts on it, and how it steps. Immutable; pickles, and steps to the same bits then.
///
/// actuated: names of the joints that have inputs, in the order of u; all joints if it is left out, a floating base never. actuation: an Actuation,
/// "ideal" or "model" (motors, limits and dry friction of the description, which act in no other case). contacts: Contacts; without them a
/// robot falls through the ground. tendon_servos: TendonServos, whose inputs are the last ones of u. activations: {name of an input: Activation}, filters, integrators, delays and
/// learned actuators before motors and servos. sleeping: lets resting islands sleep, True or (speed in m/s and rad/s, time in s) instead of (0.001, 0.5); what
/// sleeps is in `contact`, which steps return and take. parameters: all numbers by `parameter_names`, in place of those of the parts.
#[pyclass(frozen, subclass, name = "Simulator", module = "dualbody", weakref)]
pub(crate) struct PySimulator {
    pub(crate) simulator: Arc<Simulator>,
    pub(crate) id: u64,
    pub(super) model: Py<PyModel>,
    /// The robot that it was made with, before `parameters` changed it.
    pub(super) base: Py<PyModel>,
    /// The arguments that made it, by name.
    pub(super) parts: Py<PyDict>,
    /// Working memory of the last batch.
    pub(super) batch: Mutex<Option<Batch>>,
}

const INTEGRATORS: [(&str, Integrator); 4] = [
    ("semi_implicit_euler", Integrator::SemiImplicitEuler),
    ("implicit_velocity", Integrator::ImplicitVelocity),
    ("runge_kutta_4", Integrator::RungeKutta4),
    ("implicit_midpoint", Integrator::ImplicitMidpoint),
];

fn build(model: &Model, parts: &Bound<'_, PyDict>) -> PyResult<Simulator> {
    let get = |name: &str| parts.as_any().get_item(name);
    let mut simulator = match scene_of(parts)? {
        None => Simulator::new(model.clone()),
        Some(scene) => of_scene(model, scene.get())?,
    };
    if let Some(time_step) = get("time_step")?.extract()? {
        simulator = simulator.with_time_step(time_step);
    }
    if let Some(bound) = get("divergence_bound")?.extract()? {
        simulator = simulator.with_divergence_bound(bound);
    }
    if let Some(integrator) = get("integrator")?.extract::<Option<String>>()? {
        let integrator = choice("integrator", &integrator, &INTEGRATORS)?;
        simulator = simulator.with_integrator(integrator);
    }
    if let Some(names) = get("actuated")?.extract::<Option<Vec<String>>>()? {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        simulator = simulator.with_actuated_joints(&names).or_raise()?;
    }
    let actuation = get("actuation")?;
    if !actuation.is_none() {
        let actuation = actuation_of(model, &actuation)?;
        simulator = simulator.with_actuation(actuation);
    }
    let contacts = get("contacts")?;
    if !contacts.is_none() {
        let contacts = contacts_of(model, &contacts)?;
        warn_of_shapes(parts.py(), model, &contacts)?;
        simulator = simulator.with_contacts(contacts);
    }
    with_parts(simulator, parts.as_any())
}

/// The description among the arguments.
fn scene_of<'py>(parts: &Bound<'py, PyDict>) -> PyResult<Option<Bound<'py, PyScene>>> {
    Ok(parts.as_any().get_item("_scene")?.extract()?)
}

/// Makes the simulator of everything that a description holds.
fn of_scene(model: &Model, scene: &PyScene) -> PyResult<Simulator> {
    let simulator = scene.simulator()?;
    match simulator.model() == model {
        true => Ok(simulator),
        false => simulator.with_model(model.clone()).or_raise(),
    }
}

/// Warns of a robot that touches nothing although contacts were given, and of shapes that touch nothing.
fn warn_of_shapes(py: Python<'_>, model: &Model, contacts: &Contacts) -> PyResult<()> {
    let shapes = contacts.shapes_without_points();
    let (name, is_empty) = (model.name(), contacts.points().is_empty());
    if !is_empty && shapes.is_empty() {
        return Ok(());
    }
    let mut text = match is_empty {
        true => format!("\"{name}\" touches nothing: its contacts have no point"),
        false => format!("parts of \"{name}\" touch nothing"),
    };
    if shapes.is_empty() {
        text += ", as it has no collision shapes";
    }
    for shape in shapes {
        text += &format!("; {shape}");
    }
    warn(py, &text)
}

functions! {
    /// Makes a simulator again.
    fn _simulator(class, model, parts: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyAny>> {
        class.call((model,), Some(parts))
    }
}

getters! { PySimulator {
    /// The robot.
    model: Py<PyModel> = |own, py| own.model.clone_ref(py);

    /// Time step, s.
    time_step: f64 = |own| own.simulator.time_step();
} }

impl PySimulator {
    /// The simulator of everything that a description holds.
    fn from_description<'py>(
        format: &'static str,
        description: &Bound<'py, PyAny>,
        keywords: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = description.py();
        let scene = PyScene::of_description(format, description, keywords)?;
        let model = _scene_model(&scene)?;
        let parts = dict!(py; integrator = py.None(), _scene = scene);
        py.get_type::<Self>().call((model,), Some(&parts))
    }
}

#[pymethods]
impl PySimulator {
    /// Named states of the MJCF file: {name: (q, v, u, contact)}, first "qpos0" at rest without inputs; empty for other simulators. contact ends with the
    /// activations; what the file does not state of it is zero.
    #[getter]
    fn keyframes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        let scene = scene_of(self.parts.bind(py))?;
        let Some(scene) = scene.as_ref().and_then(|scene| scene.get().mjcf.as_ref()) else {
            return Ok(out);
        };
        let state_of = |state: &State, u: Vec<f64>| {
            let [q, v] = [&state.q, &state.v].map(|x| vector(py, x.as_slice()));
            let mut contact = self.simulator.neutral_state::<f64>();
            // A simulator with other activations starts without those of the file.
            if contact.activation.len() == state.activation.len() {
                contact.activation.clone_from(&state.activation);
            }
            let all = contact.contact.iter().chain(&contact.activation);
            let all: Vec<f64> = all.chain(&contact.sleep).copied().collect();
            (q, v, vector(py, &u), vector(py, &all))
        };
        let still = vec![0.0; self.simulator.nu()];
        out.set_item("qpos0", state_of(&scene.reference, still.clone()))?;
        for key in &scene.keyframes {
            let u = match key.control.is_empty() {
                true => still.clone(),
                false => scene.inputs(key.control.as_slice()),
            };
            out.set_item(&key.name, state_of(&key.state, u))?;
        }
        Ok(out)
    }

    /// Integrator: "semi_implicit_euler", "implicit_velocity", "runge_kutta_4" or "implicit_midpoint".
    #[getter]
    fn integrator(&self) -> &'static str {
        let own = self.simulator.integrator();
        let found = INTEGRATORS
            .iter()
            .find(|(_, integrator)| *integrator == own);
        found.map_or("", |(name, _)| name)
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

    fn __reduce__<'py>(this: &Bound<'py, Self>) -> Recipe<'py> {
        let (py, own) = (this.py(), this.get());
        let parts = own.parts.bind(py).copy()?;
        let has_described = !parts.as_any().get_item("contacts")?.is_none();
        if let Some(contacts) = own.simulator.contacts().filter(|_| has_described) {
            // Points of meshes travel with the simulator: their files may be missing elsewhere.
            let points: Vec<_> = contacts.points().iter().map(point_numbers).collect();
            let described = parts
                .as_any()
                .get_item("contacts")?
                .call_method1("_with_points", (points,))?;
            parts.set_item("contacts", described)?;
        }
        let make = of_package!(py, "_dualbody", "_simulator");
        let arguments = (this.get_type(), own.base.clone_ref(py), parts).into_pyobject(py)?;
        Ok((make.clone(), arguments.into_any()))
    }
}

methods! { PySimulator {
    #[new]
    fn new(
        py: Python, model: &Bound<'py, PyModel>, *, time_step: Option<f64> = None, integrator: Option<&str> = "semi_implicit_euler",
        actuated: Option<Bound<'py, PyAny>> = None, contacts: Option<Bound<'py, PyAny>> = None, actuation: Option<Bound<'py, PyAny>> = None,
        constraints: Option<Vec<Bound<'py, PyAny>>> = None, external_forces: Option<Vec<Bound<'py, PyAny>>> = None,
        frame_actuators: Option<Vec<Bound<'py, PyAny>>> = None, tendon_servos: Option<Vec<Bound<'py, PyAny>>> = None,
        activations: Option<Bound<'py, PyDict>> = None, sleeping: Option<Bound<'py, PyAny>> = None, divergence_bound: Option<f64> = None, parameters: Option<Bound<'py, PyAny>> = None,
        _scene: Option<Bound<'py, PyScene>> = None
    ) -> PyResult<Self> {
        let parts = dict!(py; _scene, time_step, integrator, actuated, contacts, actuation, constraints, external_forces, frame_actuators,
            tendon_servos, activations, sleeping, divergence_bound);
        let mut simulator = build(&model.get().model, &parts)?;
        let mut own = model.clone();
        if let Some(parameters) = parameters {
            let count = simulator.parameters().len();
            let x = read_vector("parameters", &parameters, Some(count))?;
            simulator = simulator.with_parameters(&x);
            let of_model = vector(py, &x[..model.get().model.parameters().len()]);
            own = Bound::new(py, PyModel::with_parameters(model, of_model.as_any())?)?;
            parts.set_item("parameters", vector(py, &x))?;
        }
        Ok(Self {
            simulator: Arc::new(simulator),
            id: next_id(),
            model: own.unbind(),
            base: model.clone().unbind(),
            parts: parts.unbind(),
            batch: Mutex::new(None),
        })
    }

    /// Makes a simulator of the supported content of an MJCF file, the XML of MuJoCo: a text that begins with "<", or the path of a file.
    ///
    /// The time step and the method, joint limits and friction, constraints, contacts with the ground and between bodies, and an input for each actuator that
    /// is modelled: its control, those of joints first, then those of sites, then those of tendons and further ones of joints. What is not used is in
    /// model.import_report. The keywords are those of Model.from_mjcf. `replace` changes parts, and adds constraints, forces, frame_actuators and
    /// tendon_servos to those of the file. keyframes has its named states.
    #[staticmethod]
    fn from_mjcf(description, **keywords) -> PyResult<Bound<'py, PyAny>> {
        Self::from_description("mjcf", description, keywords)
    }

    /// Makes a simulator of a URDF, a text that begins with "<", or the path of a file, with the inputs that it states in <ros2_control> or <transmission>.
    ///
    /// Limits and friction of joints act as with actuation="model". Joints with a command interface have inputs, in the order of the file; if the file
    /// states none at all, all joints have one. An effort is the input itself. A position or velocity with gains (parameters kp, kd, p, d, pos_kp,
    /// position_kp, vel_kp, … of the interface or its joint) is the target of a servo; without gains the input is the effort, with a warning. min and max are the
    /// range of the input, the reduction of a simple transmission is the gear of the servo. What is not used is in model.import_report. The
    /// keywords are those of Model.from_urdf.
    #[staticmethod]
    fn from_urdf(description, **keywords) -> PyResult<Bound<'py, PyAny>> {
        Self::from_description("urdf", description, keywords)
    }

    /// The simulator with parts replaced: the keywords of its constructor.
    fn replace(this: &Bound<'py, Self>, **changes) -> PyResult<Bound<'py, PyAny>> {
        let py = this.py();
        let parts = this.get().parts.bind(py).copy()?;
        let model = this.get().base.clone_ref(py).into_any();
        let mut model = model.into_bound(py);
        let has_parameters = parts.get_item("parameters")?.is_some_and(|own| !own.is_none());
        if has_parameters && !changes.is_some_and(|all| all.contains("parameters").unwrap_or(false))
        {
            refuse!("this simulator has other parameters than its parts: give parameters too, or None for those of the parts");
        }
        for (name, value) in changes.into_iter().flatten() {
            match name.extract::<String>()?.as_str() {
                "model" => model = value,
                _ => parts.set_item(name, value)?,
            }
        }
        this.get_type().call((model,), Some(&parts))
    }

    /// The simulator with other parameters, (n,), named by parameter_names. Raises a ValueError that names a parameter out of range.
    ///
    /// Placements are relative to those of the description, as in Model.with_parameters.
    fn with_parameters(this: &Bound<'py, Self>, parameters) -> PyResult<Bound<'py, PyAny>> {
        Self::replace(this, Some(&dict!(this.py(); parameters)))
    }
} }

impl PySimulator {
    /// The number that identifies this simulator in this process.
    pub(crate) fn id(&self) -> u64 {
        self.id
    }

    pub(crate) fn sizes(&self) -> (usize, usize, usize, usize) {
        let model = self.simulator.model();
        (
            model.nq(),
            model.nv(),
            self.simulator.nu(),
            self.simulator.n_contact() + self.simulator.n_activation() + self.simulator.n_sleep(),
        )
    }
}
