//! Recordings: from rollouts, or state by state.

use dualbody::sim::Rollout;
use dualbody::view::Recording;

use crate::prelude::*;

/// Motion of robots: for pages, files and plots.
#[pyclass(subclass, name = "Recording", module = "dualbody")]
pub(crate) struct PyRecording {
    pub(super) recording: Recording,
    pub(super) models: Vec<Py<PyModel>>,
}

/// A trajectory of a rollout of Python as one of the library.
fn trajectory(
    model: &Model,
    simulator: Option<&Simulator>,
    rollout: &Bound<'_, PyAny>,
) -> PyResult<Rollout> {
    let part = |name: &'static str, width: Option<usize>| -> PyResult<Rows<'_>> {
        let value = rollout.getattr(name.trim_start_matches("rollout."))?;
        let own = |value: &Bound<'_, PyAny>| value.getattr("shape")?.get_item(-1)?.extract();
        let width = width.map_or_else(|| own(&value), Ok)?;
        Rows::read(&argument(name, &value, &[width]))
    };
    let (q, v) = (
        part("rollout.q", Some(model.nq()))?,
        part("rollout.v", Some(model.nv()))?,
    );
    let (u, contact) = (part("rollout.u", None)?, part("rollout.contact", None)?);
    if q.batch().len() != 1 {
        refuse!("rollout is a batch: give one of its trajectories, rollout[i]");
    }
    let count: usize = attribute(rollout, "n_states")?;
    let states = (0..count).map(|k| {
        let rest = contact.view().row(k);
        let n = simulator.map_or(rest.len(), Simulator::n_contact);
        let (contact, rest) = rest.split_at(n.min(rest.len()));
        let n = simulator.map_or(0, Simulator::n_activation);
        let (activation, sleep) = rest.split_at(n.min(rest.len()));
        let mut state = State::new(q.view().row(k), v.view().row(k));
        [state.contact, state.activation, state.sleep] =
            [contact, activation, sleep].map(DVector::from_column_slice);
        state
    });
    let inputs = (0..count - 1).map(|k| DVector::from_column_slice(u.view().row(k)));
    let names = match simulator {
        Some(simulator) => simulator.input_names(),
        None => attribute(rollout, "input_names")?,
    };
    let time_step = attribute(rollout, "time_step")?;
    let (states, inputs) = (states.collect(), inputs.collect());
    guarded(|| {
        let mut rollout = Rollout::new(model, time_step, states, inputs);
        rollout.input_names = names;
        rollout
    })
}

pub(super) fn models_of(models: &[Py<PyModel>]) -> Vec<&Model> {
    models.iter().map(|model| &*model.get().model).collect()
}

functions! {
    /// Makes a recording again that was pickled.
    fn _recording(class, text: &str, models: Vec<Py<PyModel>>) -> PyResult<Bound<'py, PyAny>> {
        let recording = guarded(|| Recording::from_json(text, &models_of(&models)))?.or_raise()?;
        let arguments = PyTuple::new(class.py(), &models)?;
        let made = class.call1(arguments)?;
        made.cast::<PyRecording>()?.borrow_mut().recording = recording;
        Ok(made)
    }
}

getters! { PyRecording {
    /// Title of the page.
    title: &str = |own| own.recording.title();

    /// Recorded times, (n,), s.
    times: Bound<'py, PyAny> = |own, py| vector(py, own.recording.times());
} }

#[pymethods]
impl PyRecording {
    /// The recording of a rollout of one state (of a batch: of rollout[i]).
    #[staticmethod]
    fn from_rollout(model: &Bound<'_, PyModel>, rollout: &Bound<'_, PyAny>) -> PyResult<Self> {
        let own = &model.get().model;
        let rollout = trajectory(own, None, rollout)?;
        let recording = guarded(|| Recording::from_rollout(own, &rollout))?;
        Ok(Self {
            recording,
            models: vec![model.clone().unbind()],
        })
    }

    #[setter]
    fn set_title(&mut self, title: String) {
        self.recording = self.recording.clone().with_title(title);
    }

    fn __len__(&self) -> usize {
        self.recording.len()
    }

    /// Names of the robots.
    #[getter]
    pub(super) fn robots(&self) -> Vec<&str> {
        self.recording
            .robots()
            .iter()
            .map(|robot| robot.name())
            .collect()
    }

    fn __reduce__<'py>(this: &Bound<'py, Self>) -> Recipe<'py> {
        let (py, own) = (this.py(), this.borrow());
        let make = of_package!(py, "_dualbody", "_recording");
        let models: Vec<_> = own.models.iter().map(|model| model.clone_ref(py)).collect();
        let parts = (this.get_type(), own.recording.to_json(), models);
        Ok((make.clone(), parts.into_pyobject(py)?.into_any()))
    }

    fn __repr__(&self) -> String {
        let robots = self.recording.robots().len();
        let times = self.recording.times();
        let last = times.last().copied().unwrap_or(0.0);
        format!(
            "Recording(\"{}\", {robots} robots, {} moments, {last:.3} s)",
            self.recording.title(),
            times.len()
        )
    }
}

methods! { PyRecording {
    /// An empty recording of robots.
    #[new]
    fn new(*models) -> PyResult<Self> {
        let models: Vec<Py<PyModel>> = models.iter()
            .map(|model| {
                Ok(model.cast_into::<PyModel>().map_err(|_| type_error("models are Models"))?.unbind())
            }).collect::<PyResult<_>>()?;
        let recording = guarded(|| Recording::of_robots(&models_of(&models)))?;
        Ok(Self { recording, models })
    }

    /// The recording of a rollout with the ground, contacts and constraints of the simulator.
    #[staticmethod]
    fn of_simulation(py: Python, simulator: &Bound<'py, PySimulator>, rollout) -> PyResult<Self> {
        let own = &*simulator.get().simulator;
        let rollout = trajectory(own.model(), Some(own), rollout)?;
        let recording = guarded(|| Recording::of_simulation(own, &rollout))?;
        Ok(Self {
            recording,
            models: vec![simulator.get().model(py)],
        })
    }

    /// Adds the states of all robots at a time: (q, v) or (q, v, u) of each.
    fn push(&mut self, time: f64, *states) -> PyResult<()> {
        if states.len() != self.models.len() {
            refuse!("{} states, expected {}",
                states.len(),
                self.models.len());
        }
        let mut all = Vec::new();
        for (state, model) in states.iter().zip(&self.models) {
            let (model, state) = (&model.get().model, state.cast_into::<PyTuple>()?);
            let part = |k: usize, name, n| read_vector(name, &state.get_item(k)?, n);
            let own = State::new(&part(0, "q", Some(model.nq()))?, &part(1, "v", Some(model.nv()))?);
            own.check(model).or_raise()?;
            let u = if state.len() > 2 {
                part(2, "u", None)?
            } else {
                Vec::new()
            };
            all.push((own, u));
        }
        let moments: Vec<(&State, &[f64])> =
            all.iter().map(|(state, u)| (state, u.as_slice())).collect();
        guarded(|| self.recording.push_all(time, &moments))
    }
} }
