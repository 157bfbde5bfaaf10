//! Rollouts.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

use super::given::common_batch;
use super::handle::PySimulator;
use super::inputs::{Inputs, read_inputs};
use crate::arrays::{Rows, WIDTH};
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
}
