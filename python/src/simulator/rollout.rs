//! Rollouts.

use dualbody::sim::Rollout;

use super::given::read_inputs;
use super::memory::check_batch;
use super::single::{Control, roll_controlled, roll_with_inputs};
use super::trajectories::Trajectories;
use crate::prelude::*;

methods! { PySimulator {
    /// Takes steps from a state, or from each state of a batch, and returns a Rollout.
    ///
    /// q (..., nq), v (..., nv), contact (..., n_contact; neutral if left out); inputs (..., steps, nu) or (steps, nu) for all, or control(k, q, v) -> u with the
    /// arrays of all states of step k, which counts steps and is no time; without both, the inputs are zero. models: a robot for each state of a batch,
    /// of the same structure. progress: True for a bar (tqdm, if it is installed), or a function of the number of steps done. A trajectory that stops
    /// says so in the status; its numbers are NaN from there on: ask `is_completed` before the last state is used.
    fn rollout(
        this: &Bound<'py, Self>, q, v, steps = None, *, control = None, inputs = None, contact = None, models: Option<Vec<Py<PyModel>>> = None,
        progress = None
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, own) = (q.py(), this.get());
        let asked = Asked::read(own.simulator.nu(), steps, control, inputs)?;
        let given = own.read(q, v, None, contact)?;
        let batch = common_batch([("q", &given.batch[..]), ("inputs", asked.batch())].into_iter())?;
        let count = batch.iter().product();
        check_some(&batch, models.is_some())?;
        asked.check_memory(count, own)?;
        let states = own.states(&given, count)?;
        if batch.is_empty() {
            let roll = |initial: &State, steps, control: &mut Control<'_>| {
                own.simulator.rollout(initial, steps, control)
            };
            return asked.one(this, &states[0], progress, roll);
        }
        let bar = asked.bar(py, progress, count)?;
        let taken = py.detach(|| own.take_batch(count, models.as_deref()))?;
        let (bar, steps) = (bar.as_ref(), asked.steps);
        let found = match asked.control {
            Some(control) => {
                own.roll_batch_controlled(py, taken, &states, &batch, steps, control, bar)?
            }
            None => {
                let inputs = asked.inputs.as_ref().map(Rows::view);
                let found = own.roll_batch(py, taken, &states, steps, inputs, bar)?;
                (found, Vec::new())
            }
        };
        asked.finish(this, batch, states[0].len(), found, bar)
    }
} }

impl PySimulator {
    /// All q, v, and states of contact if there is room for them, of rollouts.
    pub(crate) fn rollout_slice(
        &self,
        states: &[State],
        inputs: &[f64],
        steps: usize,
        out: &mut [&mut [f64]],
    ) -> PyResult<()> {
        let (nq, nv, nu, nc) = self.sizes();
        let given = Some(View::of_batch(inputs, steps * nu));
        let all = Python::attach(|py| -> PyResult<Vec<f64>> {
            match states {
                [] => Ok(Vec::new()),
                [one] => {
                    let roll =
                        |control: &mut Control<'_>| self.simulator.rollout(one, steps, control);
                    Ok(roll_with_inputs(py, given, nu, steps, None, roll)?.states)
                }
                all => {
                    let batch = self.take_batch(all.len(), None)?;
                    Ok(self.roll_batch(py, batch, all, steps, given, None)?.states)
                }
            }
        })?;
        let rows = all
            .chunks((nq + nv + nc).max(1))
            .take(states.len() * (steps + 1));
        for (k, row) in rows.enumerate() {
            let parts = [&row[..nq], &row[nq..nq + nv], &row[nq + nv..]];
            for (out, x) in out.iter_mut().zip(parts) {
                out[k * x.len()..(k + 1) * x.len()].copy_from_slice(x);
            }
        }
        Ok(())
    }
}

/// Options of a rollout besides its states.
pub(super) struct Asked<'a, 'py> {
    steps: usize,
    control: Option<&'a Bound<'py, PyAny>>,
    inputs: Option<Rows<'py>>,
}

impl<'a, 'py> Asked<'a, 'py> {
    pub(super) fn read(
        nu: usize,
        steps: Option<&Bound<'py, PyAny>>,
        control: Option<&'a Bound<'py, PyAny>>,
        inputs: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        if control.is_some() && inputs.is_some() {
            refuse!("control and inputs are both given");
        }
        let (inputs, steps) = read_inputs(inputs, steps, nu)?;
        Ok(Self {
            steps,
            control,
            inputs,
        })
    }

    /// Refuses more steps than memory holds.
    pub(super) fn check_memory(&self, count: usize, of: &PySimulator) -> PyResult<()> {
        let simulator = &of.simulator;
        let width = simulator.model().nq() + simulator.n_tangent() + simulator.nu();
        check_trajectories(count.max(1), self.steps, width)
    }

    /// Leading dimensions of the inputs.
    pub(super) fn batch(&self) -> &[usize] {
        self.inputs
            .as_ref()
            .map_or(&[][..], |inputs| inputs.batch())
    }

    /// The rollout of one state by what takes the steps, as a Rollout of Python.
    pub(super) fn one(
        self,
        of: &Bound<'py, PySimulator>,
        initial: &State,
        progress: Option<&Bound<'py, PyAny>>,
        roll: impl FnOnce(&State, usize, &mut Control<'_>) -> Rollout + Send,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, nu) = (of.py(), of.get().simulator.nu());
        let bar = self.bar(py, progress, 1)?;
        let bar = bar.as_ref();
        let run = |control: &mut Control<'_>| roll(initial, self.steps, control);
        let found = match self.control {
            Some(control) => roll_controlled(control, nu, self.steps, bar, run)?,
            None => {
                let inputs = self.inputs.as_ref().map(Rows::view);
                let found = roll_with_inputs(py, inputs, nu, self.steps, bar, run)?;
                (found, Vec::new())
            }
        };
        self.finish(of, Vec::new(), initial.len(), found, bar)
    }

    /// The progress bar, if it is requested.
    fn bar(
        &self,
        py: Python<'py>,
        progress: Option<&Bound<'py, PyAny>>,
        count: usize,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let asked = (progress, (self.steps, count), self.control.is_some(), WIDTH);
        let bar = of_package!(py, "_rollout", "_progress");
        let bar = bar.call1(asked)?;
        Ok(Some(bar).filter(|bar| !bar.is_none()))
    }

    /// Trajectories, and the inputs that a control gave, as a Rollout of Python.
    ///
    /// * `width` – entries of a state
    fn finish(
        self,
        of: &Bound<'py, PySimulator>,
        batch: Vec<usize>,
        width: usize,
        (out, u): (Trajectories, Vec<f64>),
        bar: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, nu) = (of.py(), of.get().simulator.nu());
        let count: usize = batch.iter().product();
        let shape = [out.padded, self.steps + 1, width];
        let all = PyArray1::from_vec(py, out.states).reshape(shape)?;
        let u = match self.control {
            Some(_) => Some(PyArray1::from_vec(py, u).reshape([count, self.steps, nu])?),
            None => None,
        };
        let arrays = (all, u, self.inputs.map(Rows::into_array));
        let ends = (count, out.stopped, out.failures);
        of_package!(py, "_rollout", "_rollout").call1((of, batch, arrays, ends, bar))
    }
}

fn check_some(batch: &[usize], has_models: bool) -> PyResult<()> {
    check_batch(batch, has_models)?;
    if batch.contains(&0) {
        refuse!("the batch is empty");
    }
    Ok(())
}
