//! Rollouts.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

use super::handle::PySimulator;
use super::inputs::{Inputs, read_inputs};
use crate::arrays::{Rows, WIDTH, common_batch};
use crate::errors::value_error;
use crate::model::PyModel;

#[pymethods]
impl PySimulator {
    /// Takes steps from a state, or from each state of a batch, and returns a Rollout.
    ///
    /// q (..., nq), v (..., nv), contact (..., n_contact); inputs (..., steps, nu) or (steps, nu) for all, or control(k, q, v) -> u with the
    /// arrays of all states of step k; without both, the inputs are zero. models: a robot for each state of a batch, of the same structure. progress: True for a bar (tqdm, if it is installed), or a
    /// function of the number of steps done. A trajectory that stops says so in the status; its numbers are NaN from there on.
    #[pyo3(signature = (q, v, steps=None, *, control=None, inputs=None, contact=None, models=None, progress=None))]
    pub(super) fn rollout<'py>(
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
        if control.is_some() && inputs.is_some() {
            return Err(value_error("control and inputs are both given"));
        }
        let given = own.read(q, v, None, contact)?;
        let (inputs, steps) = read_inputs(inputs, steps, own.simulator.nu())?;
        let own_batch = inputs.as_ref().map_or(&[][..], |inputs| inputs.batch());
        let batch = common_batch([("q", &given.batch[..]), ("inputs", own_batch)].into_iter())?;
        let count = batch.iter().product();
        check_batch(&batch, models.is_some())?;
        let states = own.states(&given, count)?;
        let helper = py.import("dualbody.sim")?;
        let asked = (progress, (steps, count), control.is_some(), WIDTH);
        let bar = helper.getattr("_progress")?.call1(asked)?;
        let bar = Some(&bar).filter(|bar| !bar.is_none());
        let taken = match batch.is_empty() {
            true => None,
            false => Some(own.take_batch(py, count, models.as_deref())?),
        };
        let numbers = Inputs::of(inputs.as_ref());
        let (out, u) = match (control, taken) {
            (Some(control), None) => {
                own.roll_one_controlled(py, &states[0], steps, control, bar)?
            }
            (Some(control), Some(taken)) => {
                own.roll_batch_controlled(py, taken, &states, &batch, steps, control, bar)?
            }
            (None, None) => (
                own.roll_one(py, &states[0], steps, &numbers, bar)?,
                Vec::new(),
            ),
            (None, Some(taken)) => (
                own.roll_batch(py, taken, &states, steps, &numbers, bar)?,
                Vec::new(),
            ),
        };
        let shape = [out.padded, steps + 1, states[0].len()];
        let all = PyArray1::from_vec(py, out.states).reshape(shape)?;
        let u = match control {
            Some(_) => {
                Some(PyArray1::from_vec(py, u).reshape([count, steps, own.simulator.nu()])?)
            }
            None => None,
        };
        let arrays = (all, u, inputs.map(Rows::into_array));
        let ends = (count, out.stopped, out.failures);
        helper
            .getattr("_rollout")?
            .call1((this, batch, arrays, ends, bar))
    }
}

fn check_batch(batch: &[usize], has_models: bool) -> PyResult<()> {
    if batch.is_empty() && has_models {
        return Err(value_error(
            "models are for a batch, and there is one state",
        ));
    }
    if batch.contains(&0) {
        return Err(value_error("the batch is empty"));
    }
    Ok(())
}
