//! Recordings, their files and pages, plots.

use std::path::PathBuf;

use dualbody::sim::Rollout;
use dualbody::spatial::Transform;
use dualbody::view::{Camera, Plot, Recording};
use dualbody::{Model, Simulator, State};
use nalgebra::{DVector, Vector3};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};

use crate::arrays::{Rows, argument, read_vector};
use crate::contact::terrain_of;
use crate::errors::{OrRaise, guarded, type_error, value_error};
use crate::model::{PyModel, read_geometry, read_pose};
use crate::simulator::PySimulator;

/// Motion of robots: for pages, files and plots.
#[pyclass(subclass, name = "Recording", module = "dualbody")]
pub(crate) struct PyRecording {
    recording: Recording,
    models: Vec<Py<PyModel>>,
}

/// A trajectory of a rollout of Python as one of the library.
fn trajectory(
    model: &Model,
    simulator: Option<&Simulator>,
    rollout: &Bound<'_, PyAny>,
) -> PyResult<Rollout> {
    let (q, v, u) = (
        rollout.getattr("q")?,
        rollout.getattr("v")?,
        rollout.getattr("u")?,
    );
    let contact = rollout.getattr("contact")?;
    let nc: usize = contact.getattr("shape")?.get_item(-1)?.extract()?;
    let nu: usize = u.getattr("shape")?.get_item(-1)?.extract()?;
    let (q, v) = (
        read("rollout.q", &q, model.nq())?,
        read("rollout.v", &v, model.nv())?,
    );
    let (u, contact) = (
        read("rollout.u", &u, nu)?,
        read("rollout.contact", &contact, nc)?,
    );
    if q.batch().len() != 1 {
        return Err(value_error(
            "rollout is a batch: give one of its trajectories, rollout[i]",
        ));
    }
    let count: usize = rollout.getattr("n_states")?.extract()?;
    let piece = |rows: &Rows<'_>, k: usize, n: usize| rows.as_slice()[k * n..(k + 1) * n].to_vec();
    let states = (0..count).map(|k| {
        let state = State::new(&piece(&q, k, model.nq()), &piece(&v, k, model.nv()));
        state.with_contact(DVector::from_vec(piece(&contact, k, nc)))
    });
    let inputs = (0..count - 1).map(|k| DVector::from_vec(piece(&u, k, nu)));
    let names = match simulator {
        Some(simulator) => simulator.input_names(),
        None => rollout.getattr("input_names")?.extract()?,
    };
    let time_step = rollout.getattr("time_step")?.extract()?;
    let (states, inputs) = (states.collect(), inputs.collect());
    guarded(|| Rollout::new(model, time_step, states, inputs).with_input_names(names))
}

fn read<'py>(name: &'static str, value: &Bound<'py, PyAny>, n: usize) -> PyResult<Rows<'py>> {
    Rows::read(&argument(name, value, &[n]))
}

fn transform(placement: Option<&Bound<'_, PyAny>>) -> PyResult<Transform<f64>> {
    placement.map_or(Ok(Transform::identity()), |pose| {
        read_pose("placement", pose)
    })
}

fn models_of(models: &[Py<PyModel>]) -> Vec<&Model> {
    models.iter().map(|model| &*model.get().model).collect()
}

#[pymethods]
impl PyRecording {
    /// An empty recording of robots.
    #[new]
    #[pyo3(signature = (*models))]
    fn new(models: &Bound<'_, PyTuple>) -> PyResult<Self> {
        let models: Vec<Py<PyModel>> = models
            .iter()
            .map(|model| {
                Ok(model
                    .cast_into::<PyModel>()
                    .map_err(|_| type_error("models are Models"))?
                    .unbind())
            })
            .collect::<PyResult<_>>()?;
        let recording = guarded(|| Recording::of_robots(&models_of(&models)))?;
        Ok(Self { recording, models })
    }

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

    /// The recording of a rollout with what the simulator has: ground and constraints.
    #[staticmethod]
    fn of_simulation(
        py: Python<'_>,
        simulator: &Bound<'_, PySimulator>,
        rollout: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let own = &*simulator.get().simulator;
        let rollout = trajectory(own.model(), Some(own), rollout)?;
        let recording = guarded(|| Recording::of_simulation(own, &rollout))?;
        Ok(Self {
            recording,
            models: vec![simulator.get().model(py)],
        })
    }

    /// Reads a recording from a table or a JSON file; the robots are not in it.
    #[staticmethod]
    #[pyo3(signature = (path, *models))]
    fn read(path: PathBuf, models: &Bound<'_, PyTuple>) -> PyResult<Self> {
        let empty = Self::new(models)?;
        let robots = models_of(&empty.models);
        let is_table = path.extension().is_some_and(|extension| extension == "csv");
        let recording = guarded(|| match is_table {
            true => Recording::read_csv(&path, &robots),
            false => Recording::read_json(&path, &robots),
        })?;
        let recording = recording.or_raise()?;
        Ok(Self {
            recording,
            models: empty.models,
        })
    }

    /// Adds the states of all robots at a time: (q, v) or (q, v, u) of each.
    #[pyo3(signature = (time, *states))]
    fn push(&mut self, time: f64, states: &Bound<'_, PyTuple>) -> PyResult<()> {
        if states.len() != self.models.len() {
            return Err(value_error(format_args!(
                "{} states, expected {}",
                states.len(),
                self.models.len()
            )));
        }
        let mut all = Vec::new();
        for (state, model) in states.iter().zip(&self.models) {
            let (model, state) = (&model.get().model, state.cast_into::<PyTuple>()?);
            let part = |k: usize, name, n| read_vector(name, &state.get_item(k)?, n);
            let own = State::new(
                &part(0, "q", Some(model.nq()))?,
                &part(1, "v", Some(model.nv()))?,
            );
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

    #[getter]
    fn title(&self) -> &str {
        self.recording.title()
    }

    #[setter]
    fn set_title(&mut self, title: String) {
        self.recording = self.recording.clone().with_title(title);
    }

    fn __len__(&self) -> usize {
        self.recording.len()
    }

    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        crate::arrays::vector(py, self.recording.times().to_vec()).into_any()
    }

    /// Names of the robots.
    #[getter]
    fn robots(&self) -> Vec<&str> {
        self.recording
            .robots()
            .iter()
            .map(|robot| robot.name())
            .collect()
    }

    /// Adds a number for each time, drawn over time beside the robot.
    fn add_series(&mut self, name: String, values: &Bound<'_, PyAny>) -> PyResult<()> {
        let values = read_vector("values", values, Some(self.recording.len()))?;
        guarded(|| self.recording.add_series(name, values)).map(|_| ())
    }

    /// Draws the path of a frame.
    #[pyo3(signature = (frame, robot=0))]
    fn trace(&mut self, frame: &str, robot: usize) -> PyResult<()> {
        guarded(|| self.recording.robot_mut(robot).trace(frame).map(|_| ()))?.or_raise()
    }

    /// Draws the axes of a frame.
    #[pyo3(signature = (frame, robot=0))]
    fn show_frame(&mut self, frame: &str, robot: usize) -> PyResult<()> {
        guarded(|| {
            self.recording
                .robot_mut(robot)
                .show_frame(frame)
                .map(|_| ())
        })?
        .or_raise()
    }

    /// Draws forces at the origin of a frame, in the world's axes: (len, 3), N.
    #[pyo3(signature = (frame, values, robot=0))]
    fn add_force(&mut self, frame: &str, values: &Bound<'_, PyAny>, robot: usize) -> PyResult<()> {
        let shape = [self.recording.len(), 3];
        let rows = Rows::read(&argument("values", values, &shape))?;
        let forces: Vec<_> = rows
            .as_slice()
            .chunks(3)
            .map(Vector3::from_column_slice)
            .collect();
        guarded(|| {
            self.recording
                .robot_mut(robot)
                .add_force(frame, forces)
                .map(|_| ())
        })?
        .or_raise()
    }

    /// Draws the forces that act in a simulator, frame by frame.
    #[pyo3(signature = (simulator, robot=0))]
    fn add_applied_forces(
        &mut self,
        simulator: &Bound<'_, PySimulator>,
        robot: usize,
    ) -> PyResult<()> {
        let simulator = &simulator.get().simulator;
        guarded(|| {
            self.recording
                .robot_mut(robot)
                .add_applied_forces(simulator)
        })
        .map(|_| ())
    }

    /// Places a robot elsewhere in the picture, by a pose (4, 4) or a translation.
    #[pyo3(signature = (placement, robot=0))]
    fn place(&mut self, placement: &Bound<'_, PyAny>, robot: usize) -> PyResult<()> {
        let placement = read_pose("placement", placement)?;
        guarded(|| self.recording.robot_mut(robot).place(placement)).map(|_| ())
    }

    /// Places the robots side by side.
    fn spread(&mut self, distance: f64) -> PyResult<()> {
        guarded(|| self.recording.spread(distance)).map(|_| ())
    }

    /// Adds a shape (Box, Sphere, …) that stands still.
    #[pyo3(signature = (name, shape, placement=None, color=[0.6, 0.6, 0.65, 1.0]))]
    fn add_shape(
        &mut self,
        name: String,
        shape: &Bound<'_, PyAny>,
        placement: Option<&Bound<'_, PyAny>>,
        color: [f64; 4],
    ) -> PyResult<()> {
        let (geometry, placement) = (read_geometry(shape)?, transform(placement)?);
        guarded(|| self.recording.add_shape(name, geometry, placement, color)).map(|_| ())
    }

    /// Adds axes that stand still.
    #[pyo3(signature = (name, placement=None))]
    fn add_axes(&mut self, name: String, placement: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let placement = transform(placement)?;
        guarded(|| self.recording.add_axes(name, placement)).map(|_| ())
    }

    /// Draws a terrain.
    fn show_ground(&mut self, terrain: &Bound<'_, PyAny>) -> PyResult<()> {
        let terrain = terrain_of(terrain)?;
        guarded(|| self.recording.show_ground(&terrain)).map(|_| ())
    }

    /// Sets the camera: point in the middle (m), distance (m), azimuth and elevation (degrees).
    fn set_camera(
        &mut self,
        look_at: [f64; 3],
        distance: f64,
        azimuth: f64,
        elevation: f64,
    ) -> PyResult<()> {
        let (recording, camera) = (
            self.recording.clone(),
            Camera {
                look_at,
                distance,
                azimuth,
                elevation,
            },
        );
        self.recording = guarded(|| recording.with_camera(camera))?;
        Ok(())
    }

    /// The page as a text: it works offline, in one file.
    fn to_html(&self) -> PyResult<String> {
        guarded(|| self.recording.to_html())
    }

    /// The page in a frame of a size, for notebooks: width and height as in HTML.
    #[pyo3(signature = (width="100%", height="480"))]
    fn show<'py>(&self, py: Python<'py>, width: &str, height: &str) -> PyResult<Bound<'py, PyAny>> {
        py.import("dualbody.view")?
            .getattr("Page")?
            .call1((self.to_html()?, width, height))
    }

    fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.show(py, "100%", "480")?.call_method0("_repr_html_")
    }

    fn save_html(&self, path: PathBuf) -> PyResult<()> {
        guarded(|| self.recording.save_html(path))?.or_raise()
    }

    fn to_csv(&self) -> PyResult<String> {
        guarded(|| self.recording.to_csv())
    }

    fn save_csv(&self, path: PathBuf) -> PyResult<()> {
        guarded(|| self.recording.save_csv(path))?.or_raise()
    }

    fn to_json(&self) -> PyResult<String> {
        guarded(|| self.recording.to_json())
    }

    fn save_json(&self, path: PathBuf) -> PyResult<()> {
        guarded(|| self.recording.save_json(path))?.or_raise()
    }

    /// Plots columns over time, named as in the table.
    #[pyo3(signature = (*columns))]
    fn plot(&self, columns: Vec<String>) -> PyResult<PyPlot> {
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        Ok(PyPlot {
            plot: guarded(|| self.recording.plot(&columns))?.or_raise()?,
        })
    }

    /// Plots one column over another.
    fn phase_plot(&self, x: &str, y: &str) -> PyResult<PyPlot> {
        Ok(PyPlot {
            plot: guarded(|| self.recording.phase_plot(x, y))?.or_raise()?,
        })
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

/// Plot of curves; shows itself in notebooks.
#[pyclass(frozen, name = "Plot", module = "dualbody")]
pub(crate) struct PyPlot {
    plot: Plot,
}

#[pymethods]
impl PyPlot {
    /// An empty plot: title, names of the axes, size in pixels.
    #[new]
    #[pyo3(signature = (title="", *, x="", y="", size=None, logarithmic=false))]
    fn new(
        title: &str,
        x: &str,
        y: &str,
        size: Option<(u32, u32)>,
        logarithmic: bool,
    ) -> PyResult<Self> {
        let mut plot = Plot::new(title).with_axes(x, y);
        if let Some((width, height)) = size {
            plot = guarded(|| plot.with_size(width, height))?;
        }
        if logarithmic {
            plot = plot.with_logarithmic_axes();
        }
        Ok(Self { plot })
    }

    /// The plot with one more curve through the points (x, y).
    fn with_line(
        &self,
        name: String,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let x = read_vector("x", x, None)?;
        let y = read_vector("y", y, Some(x.len()))?;
        let plot = self.plot.clone();
        let plot = guarded(|| plot.with_line(name, x.into_iter().zip(y)))?;
        Ok(Self { plot })
    }

    /// The plot in another size, pixels.
    fn with_size(&self, width: u32, height: u32) -> PyResult<Self> {
        let plot = self.plot.clone();
        Ok(Self {
            plot: guarded(|| plot.with_size(width, height))?,
        })
    }

    fn to_svg(&self) -> PyResult<String> {
        guarded(|| self.plot.to_svg())
    }

    fn to_png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &guarded(|| self.plot.to_png())?))
    }

    fn save_svg(&self, path: PathBuf) -> PyResult<()> {
        guarded(|| self.plot.save_svg(path))?.or_raise()
    }

    fn save_png(&self, path: PathBuf) -> PyResult<()> {
        guarded(|| self.plot.save_png(path))?.or_raise()
    }

    fn _repr_svg_(&self) -> PyResult<String> {
        self.to_svg()
    }
}
