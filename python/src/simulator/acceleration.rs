//! Accelerations at a moment.

use dualbody::sim::StepScratch;
use pyo3::exceptions::PyFloatingPointError;
use pyo3::prelude::*;

use super::forces::with_forces;
use super::given::Given;
use super::gradient::each;
use super::handle::PySimulator;
use super::memory::check_batch;
use crate::arrays::{Array, checked_output, empty, numbers_mut};
use crate::model::PyModel;
use crate::python::methods;

fn not_finite(k: Option<usize>) -> PyErr {
    let which = k.map_or(String::new(), |k| format!(" of state {k} of the batch"));
    PyFloatingPointError::new_err(format!("the acceleration{which} is not finite"))
}

methods! { PySimulator {
    /// Acceleration dv/dt at a state under the input, (..., nv), rad/s² or m/s²: forward dynamics with all forces at this instant.
    ///
    /// Arguments as in step; out: an array for the result. Motors, limits, friction, springs, constraints and contact are evaluated at this state,
    /// while a step evaluates some of them at its end. Rigid contact has forces over a whole step only; the acceleration is the mean over one step.
    /// Raises FloatingPointError if an acceleration is not finite.
    fn acceleration(
        this: &Bound<'py, Self>, q, v, u = None, *, contact = None, forces = None, representation: &str = "mixed",
        models: Option<Vec<Py<PyModel>>> = None, out = None
    ) -> PyResult<Array<'py>> {
        if let Some(forces) = forces {
            let (forced, u) = with_forces(this, u, forces, representation, models.is_some())?;
            let u = u.as_ref();
            return Self::acceleration(&forced, q, v, u, contact, None, representation, None, out);
        }
        let own = this.get();
        let given = own.read(q, v, u, contact)?;
        check_batch(&given.batch, models.is_some())?;
        let shape = [given.batch.as_slice(), &[own.sizes().1]].concat();
        let array = match out {
            Some(out) => checked_output("out", out, &shape)?,
            None => empty(q.py(), &shape),
        };
        match given.batch.is_empty() {
            true => own.accelerate_one(&given, &array)?,
            false => own.accelerate_batch(q.py(), &given, models.as_deref(), &array)?,
        }
        Ok(array)
    }
} }

impl PySimulator {
    fn accelerate_one(&self, given: &Given<'_>, out: &Array<'_>) -> PyResult<()> {
        let is_finite = self.with_memory(given, |memory| {
            let (state, u, scratch) = (&memory.state, &memory.u, &mut memory.scratch);
            let a = self.simulator.acceleration_into(state, u, scratch);
            numbers_mut(out).copy_from_slice(a);
            a.iter().all(|a| a.is_finite())
        })?;
        match is_finite {
            true => Ok(()),
            false => Err(not_finite(None)),
        }
    }

    fn accelerate_batch(
        &self,
        py: Python<'_>,
        given: &Given<'_>,
        models: Option<&[Py<PyModel>]>,
        out: &Array<'_>,
    ) -> PyResult<()> {
        let (count, (_, nv, nu, _)) = (given.count(), self.sizes());
        let (states, inputs) = (self.states(given, count)?, self.inputs(given, count)?);
        let variants = self.variants(models, count)?;
        let own = &*self.simulator;
        let input = |k: usize| &inputs[k * nu..(k + 1) * nu];
        let one = |scratch: &mut StepScratch<f64>, k: usize| match &variants {
            Some(all) => all[k].acceleration(&states[k], input(k)).data.into(),
            None => own
                .acceleration_into(&states[k], input(k), scratch)
                .to_vec(),
        };
        let all: Vec<Vec<f64>> = each(py, count, || StepScratch::new(own), one)?;
        let is_not_finite = |a: &Vec<f64>| a.iter().any(|a| !a.is_finite());
        if let Some(k) = all.iter().position(is_not_finite) {
            return Err(not_finite(Some(k)));
        }
        let rows = numbers_mut(out).chunks_exact_mut(nv.max(1)).zip(&all);
        rows.for_each(|(row, a)| row.copy_from_slice(a));
        Ok(())
    }
}
