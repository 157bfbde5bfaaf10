//! Sensors with noise, of many states.

use std::sync::Mutex;

use dualbody::sim::{NoisySensors, Sensors};

use super::{check_rows, spec};
use crate::prelude::*;

/// Sensors with noise, of one state for each seed: made by `Sensors.noisy`. The same seed gives the same readings, whatever other states there are.
#[pyclass(frozen, name = "NoisySensors", module = "dualbody.sim")]
pub(crate) struct PyNoisySensors {
    states: Mutex<Vec<NoisySensors>>,
    /// Numbers that are read.
    len: usize,
}

impl PyNoisySensors {
    pub(super) fn new(
        sensors: &Sensors,
        noise: &Bound<'_, PyDict>,
        time_step: f64,
        seeds: &[u64],
    ) -> PyResult<Self> {
        let mut one = guarded(|| NoisySensors::new(sensors, time_step, 0))?;
        for (name, noise) in noise {
            let name: String = name.extract()?;
            let noise = spec::noise(&name, &noise)?;
            one = guarded(|| one.with_noise(&name, noise))?.or_raise()?;
        }
        let seeded = |&seed: &u64| {
            let mut own = one.clone();
            own.reset(seed);
            own
        };
        Ok(Self {
            states: Mutex::new(seeds.iter().map(seeded).collect()),
            len: sensors.len(),
        })
    }
}

#[pymethods]
impl PyNoisySensors {
    /// Returns readings with noise from exact readings of a step, (n, len), or (len,) for one state.
    fn sample<'py>(&self, readings: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        let rows = Rows::read(&argument("readings", readings, &[self.len]))?;
        let mut states = self.lock()?;
        check_rows(rows.batch(), states.len())?;
        let shape = [rows.batch(), &[self.len]].concat();
        let out = empty(readings.py(), &shape);
        let width = self.len.max(1);
        let numbers = rows.as_slice().chunks_exact(width);
        let outputs = numbers_mut(&out).chunks_exact_mut(width);
        for (state, (exact, out)) in states.iter_mut().zip(numbers.zip(outputs)) {
            state.sample_into(exact, out);
        }
        Ok(out)
    }

    fn __len__(&self) -> PyResult<usize> {
        Ok(self.lock()?.len())
    }
}

methods! { PyNoisySensors {
    /// Restarts states with the random numbers of their seeds: (n,) whole numbers. mask: (n,), the selected states; all by default.
    fn reset(&self, seeds: Vec<u64>, mask: Option<Vec<bool>> = None) -> PyResult<()> {
        let mut states = self.lock()?;
        let mask = mask.unwrap_or_else(|| vec![true; states.len()]);
        if (seeds.len(), mask.len()) != (states.len(), states.len()) {
            refuse!("{} seeds and a mask of {} for {} states",
                seeds.len(),
                mask.len(),
                states.len());
        }
        for (state, (&seed, _)) in states.iter_mut().zip(seeds.iter().zip(&mask)).filter(|(_, (_, mask))| **mask)
        {
            state.reset(seed);
        }
        Ok(())
    }
} }

impl PyNoisySensors {
    fn lock(&self) -> PyResult<std::sync::MutexGuard<'_, Vec<NoisySensors>>> {
        let poisoned = |_| value_error("the sensors were left in the middle of a sample");
        self.states.lock().map_err(poisoned)
    }
}
