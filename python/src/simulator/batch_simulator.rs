//! The class `BatchSimulator`: states that stay in lanes between steps.

use dualbody::sim::{BatchSimulator, BatchStates, RolloutStatus};
use numpy::PyArrayLike1;
use pyo3::exceptions::PyKeyError;

use super::given::{States, check_finite};
use super::memory::threads_for;
use super::spread::Spread;
use super::step::write_parts;
use crate::prelude::*;

/// Many states of a robot that stay where they are between steps, in the lanes of vector units: faster than Simulator.step, which reads and checks all states at each step.
///
/// n: number of states, at first neutral; parameters: {name: (n,)} of Simulator.parameter_names in which states differ: masses, friction, contact models, heights of the ground,
/// gains and limits of motors, external forces. A state that diverges stays where it was; the others go on.
#[pyclass(name = "BatchSimulator", module = "dualbody.sim")]
pub(crate) struct PyBatchSimulator {
    simulator: Py<PySimulator>,
    /// Taken while it gets more threads.
    batch: Option<BatchSimulator>,
    states: BatchStates,
    spread: Spread,
}

getters! { PyBatchSimulator {
    /// The simulator of all states, without the parameters in which they differ.
    simulator: Py<PySimulator> = |own, py| own.simulator.clone_ref(py);

    /// Configurations (n, nq): a copy.
    q: Array<'py> = |own, py| own.part(py, 0);

    /// Velocities (n, nv): a copy.
    v: Array<'py> = |own, py| own.part(py, 1);

    /// States of contact (n, n_contact): a copy.
    contact: Array<'py> = |own, py| own.part(py, 2);
} }

#[pymethods]
impl PyBatchSimulator {
    fn __len__(&self) -> usize {
        self.states.len()
    }

    /// Whether each state runs (n,): it does until it diverges, and again once it is set.
    #[getter]
    fn running<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        let runs = |i| self.states.status(i) == RolloutStatus::Completed;
        PyArray1::from_iter(py, (0..self.states.len()).map(runs))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let simulator = self.simulator.bind(py).repr()?;
        Ok(format!(
            "BatchSimulator({simulator}, {})",
            self.states.len()
        ))
    }
}

methods! { PyBatchSimulator {
    #[new]
    fn new(simulator: &Bound<'py, PySimulator>, n, *, parameters: Option<&Bound<'py, PyDict>> = None) -> PyResult<Self> {
        let own = &simulator.get().simulator;
        let n: usize = whole("n", n)?;
        check_array("states", &[n, own.neutral_state::<f64>().len()])?;
        let batch = match parameters {
            None => BatchSimulator::new((**own).clone(), n),
            Some(given) => {
                let rows = rows_of_parameters(simulator.get(), n, given)?;
                guarded(|| BatchSimulator::of_parameters(own, &rows))?
            }
        };
        let batch = batch.with_threads(1);
        let states = batch.states(&vec![own.neutral_state(); n]);
        Ok(Self {
            simulator: simulator.clone().unbind(),
            batch: Some(batch),
            states,
            spread: Spread::new(),
        })
    }

    /// Sets states: all, or those whose flag is true in mask (n,). q (n, nq) or (nq,), v likewise; contact is neutral if it is left out.
    fn set(&mut self, q, v, *, contact = None, mask: Option<PyArrayLike1<'py, bool>> = None) -> PyResult<()> {
        let (own, n) = (self.simulator.get(), self.states.len());
        let given = own.read(q, v, None, contact)?;
        let mask = mask.map(|mask| mask.as_array().to_vec());
        if !given.batch.is_empty() && given.batch != [n] {
            refuse!("the states are a batch of shape {:?}, expected ({n},)",
                given.batch);
        }
        if let Some(mask) = mask.as_ref().filter(|mask| mask.len() != n) {
            refuse!("mask has {} entries, expected {n}",
                mask.len());
        }
        let is_set = |i: &usize| mask.as_ref().is_none_or(|mask| mask[*i]);
        let mut state: State = own.simulator.neutral_state();
        let given = States {
            is_batch: true,
            ..States::from(&given)
        };
        // All are read before the first one is set.
        (0..n).filter(is_set).try_for_each(|i| own.read_state(&given, i, &mut state))?;
        for i in (0..n).filter(is_set) {
            own.read_state(&given, i, &mut state)?;
            self.states.set(i, &state);
        }
        Ok(())
    }

    /// Takes time steps with the input held: u (n, nu) or (nu,), N·m or N, zero if it is left out; steps: their number, the decimation of a policy.
    fn step(&mut self, py: Python, u = None, *, steps = None) -> PyResult<()> {
        let steps: usize = steps.map_or(Ok(1), |steps| whole("steps", steps))?;
        let inputs = self.inputs(u)?;
        let n = self.states.len();
        if self.spread.begins() {
            let threads = threads_for(n)?;
            self.batch = self.batch.take().map(|batch| batch.with_threads(threads));
        }
        let (batch, states) = (&mut self.batch, &mut self.states);
        self.spread.run(py, || {
            if let Some(batch) = batch {
                batch.step_times(states, &inputs, steps);
            }
        })
    }
} }

impl PyBatchSimulator {
    fn part<'py>(&self, py: Python<'py>, part: usize) -> Array<'py> {
        let (nq, nv, _, nc) = self.simulator.get().sizes();
        let n = self.states.len();
        let array = empty(py, &[n, [nq, nv, nc][part]]);
        let mut out: [&mut [f64]; 3] = Default::default();
        out[part] = numbers_mut(&array);
        write_parts(&self.states, &mut out);
        array
    }

    fn inputs(&self, u: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<f64>> {
        let (_, _, nu, _) = self.simulator.get().sizes();
        let n = self.states.len();
        let Some(u) = u else {
            return Ok(vec![0.0; n * nu]);
        };
        let rows = Rows::read(&argument("u", u, &[nu]))?;
        check_finite("u", rows.as_slice())?;
        match rows.batch() {
            [] => Ok(rows.as_slice().repeat(n)),
            [given] if *given == n => Ok(rows.as_slice().to_vec()),
            other => Err(invalid!("u is a batch of shape {other:?}, expected ({n},)")),
        }
    }
}

/// A row of parameters for each state.
fn rows_of_parameters(
    simulator: &PySimulator,
    n: usize,
    given: &Bound<'_, PyDict>,
) -> PyResult<Vec<f64>> {
    let own = &simulator.simulator;
    let row = own.parameters();
    check_array("parameters of states", &[n, row.len()])?;
    let mut rows = row.as_slice().repeat(n);
    let layout = own.parameter_layout();
    for (name, values) in given {
        let name: String = name.extract()?;
        let place = layout.find(&name);
        let place = place.map_err(|error| PyKeyError::new_err(error.to_string()))?;
        let values = Rows::read(&argument("parameters", &values, &[n]))?;
        check_finite(&name, values.as_slice())?;
        let rows = rows.chunks_exact_mut(row.len());
        rows.zip(values.as_slice())
            .for_each(|(row, x)| row[place] = *x);
    }
    Ok(rows)
}
