//! Accelerations at a moment.

use pyo3::exceptions::PyFloatingPointError;

use super::memory::check_batch;
use super::step::with_forces;
use crate::prelude::*;

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
        let variants = own.variants(models.as_deref(), given.count())?;
        let (simulator, nv) = (&*own.simulator, own.sizes().1);
        let array = own.rows(q.py(), &given, nv, out, |k, memory, row| {
            let (state, u, scratch) = (&memory.state, &memory.u, &mut memory.scratch);
            match &variants {
                Some(all) => row.copy_from_slice(all[k].acceleration(state, u).as_slice()),
                None => row.copy_from_slice(simulator.acceleration_into(state, u, scratch)),
            }
        })?;
        match numbers_mut(&array).iter().position(|a| !a.is_finite()) {
            None => Ok(array),
            Some(k) => Err(not_finite((!given.batch.is_empty()).then(|| k / nv))),
        }
    }
} }
