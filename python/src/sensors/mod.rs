//! Sensors: what they read in a step, with C and D; noise.

mod noise;
mod spec;

use std::sync::Arc;

use dualbody::linearize::SensorLinearization;
use dualbody::sim::{SensorScratch, Sensors};
use pyo3::exceptions::PyFloatingPointError;
use pyo3::types::PySlice;

use crate::prelude::*;

pub(crate) use noise::PyNoisySensors;

/// The sensors of a robot, which read one vector: a mapping from names to `sim.Sensor`. Immutable; pickles.
///
/// Readings belong to a step: to the state before it, its input, and the acceleration and forces that act over it.
#[pyclass(frozen, name = "Sensors", module = "dualbody.sim")]
pub(crate) struct PySensors {
    sensors: Arc<Sensors>,
    model: Py<PyModel>,
    /// The arguments that made it.
    given: Py<PyDict>,
}

getters! { PySensors {
    /// Name of each reading: that of its sensor, with ".x", ".qw", ".fx" and so on if the sensor has several readings.
    names: Vec<&str> = |own| own.sensors.names();

    /// Unit of each reading; empty for dimensionless readings.
    units: Vec<&'static str> = |own| own.sensors.units();
} }

#[pymethods]
impl PySensors {
    #[new]
    fn new(model: Py<PyModel>, sensors: &Bound<'_, PyDict>) -> PyResult<Self> {
        let of = &model.get().model;
        let mut all = Vec::with_capacity(sensors.len());
        for (name, sensor) in sensors {
            let name: String = name.extract()?;
            let read = spec::read(of, &name, &sensor)?;
            all.push((name, read));
        }
        let made = guarded(|| Sensors::new(of, all))?;
        Ok(Self {
            sensors: Arc::new(made),
            given: sensors.copy()?.unbind(),
            model,
        })
    }

    /// Collision shapes that range finders do not see, a sentence each; empty without range finders.
    #[getter]
    fn missing_shapes(&self) -> Vec<String> {
        let shapes = self.sensors.missing_shapes().iter();
        shapes.map(ToString::to_string).collect()
    }

    fn __len__(&self) -> usize {
        self.sensors.len()
    }

    /// Range of a sensor's readings in the vector. Raises KeyError if there is no sensor of this name.
    fn slice<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PySlice>> {
        let missing = || pyo3::exceptions::PyKeyError::new_err(name.to_owned());
        let range = self.sensors.range(name).ok_or_else(missing)?;
        Ok(slice(py, range))
    }

    fn __repr__(&self) -> String {
        let model = self.model.get().model.name();
        format!(
            "Sensors of \"{model}\": {}",
            self.sensors.names().join(", ")
        )
    }

    fn __reduce__<'py>(this: &Bound<'py, Self>) -> Recipe<'py> {
        let (py, own) = (this.py(), this.get());
        let arguments = (own.model.clone_ref(py), own.given.clone_ref(py)).into_pyobject(py)?;
        Ok((this.get_type().into_any(), arguments.into_any()))
    }
}

methods! { PySensors {
    /// Readings (..., len) of the step from a state under the input; the state is not changed. Arguments as in Simulator.step; out: an array for the result.
    ///
    /// Raises FloatingPointError if a reading is not finite.
    fn read(&self, simulator: &Bound<'py, PySimulator>, q, v, u = None, *, contact = None, out = None) -> PyResult<Array<'py>> {
        let own = simulator.get();
        let given = own.read(q, v, u, contact)?;
        let simulator = &own.simulator;
        let array = own.rows(q.py(), &given, self.sensors.len(), out, |_, memory, row| {
            let (state, u) = (&memory.state, &memory.u);
            let read = |scratch: &mut _| self.sensors.read_into(simulator, state, u, scratch, row);
            with_kept(own.id, || SensorScratch::new(simulator), read);
        })?;
        match numbers_mut(&array).iter().position(|y| !y.is_finite()) {
            None => Ok(array),
            Some(k) => Err(self.not_finite(k)),
        }
    }

    /// Jacobians of the step and of its readings, in tangent coordinates: SensorLinearization of a, b as from Simulator.linearize, c (..., len,
    /// n_tangent) and d (..., len, nu). Arguments as in Simulator.step.
    fn linearize(&self, simulator: &Bound<'py, PySimulator>, q, v, u = None, *, contact = None) -> PyResult<Bound<'py, PyAny>> {
        let (py, own) = (q.py(), simulator.get());
        let given = own.read(q, v, u, contact)?;
        let (states, inputs) = own.states_and_inputs(&given)?;
        let (sensors, of, nu) = (&*self.sensors, &*own.simulator, own.simulator.nu());
        let one = |k: usize| sensors.linearize(of, &states[k], &inputs[k * nu..(k + 1) * nu]);
        let all: Vec<SensorLinearization> = py.detach(|| each(states.len(), one))?;
        let (n, len, batch) = (of.n_tangent(), sensors.len(), &given.batch);
        let parts = (
            matrices(py, batch, [n, n], all.iter().map(|own| &own.step.a))?,
            matrices(py, batch, [n, nu], all.iter().map(|own| &own.step.b))?,
            matrices(py, batch, [len, n], all.iter().map(|own| &own.c))?,
            matrices(py, batch, [len, nu], all.iter().map(|own| &own.d))?,
        );
        of_package!(py, "_rollout", "SensorLinearization").call1(parts)
    }

    /// The sensors with noise, for one state per seed: a NoisySensors. noise: a mapping from names to `sim.SensorNoise`; time_step: time between
    /// two samples, s; seeds: (n,), whole numbers.
    fn noisy(&self, noise: &Bound<'py, PyDict>, time_step: f64, seeds: Vec<u64>) -> PyResult<PyNoisySensors> {
        PyNoisySensors::new(&self.sensors, noise, time_step, &seeds)
    }
} }

impl PySensors {
    fn not_finite(&self, k: usize) -> PyErr {
        let (names, len) = (self.sensors.names(), self.sensors.len());
        let (state, name) = (k / len, names[k % len]);
        let text = format!("the reading {name} of state {state} is not finite");
        PyFloatingPointError::new_err(text)
    }
}

/// The numbers of a batch, a row for each of `n` states.
fn check_rows(batch: &[usize], n: usize) -> PyResult<()> {
    match batch {
        [rows] if *rows == n => Ok(()),
        [] if n == 1 => Ok(()),
        _ => Err(invalid!(
            "readings of a batch of shape {batch:?} for {n} seeds"
        )),
    }
}
