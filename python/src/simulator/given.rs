//! States and inputs that a call is given.

use dualbody::State;
use pyo3::prelude::*;

use super::handle::PySimulator;
use crate::arrays::{Rows, argument, common_batch, vector};
use crate::errors::{OrRaise, about_base, value_error};

/// A state, or a batch of them, with an input.
pub(crate) struct Given<'py> {
    pub(crate) q: Rows<'py>,
    pub(crate) v: Rows<'py>,
    pub(crate) u: Option<Rows<'py>>,
    pub(crate) contact: Option<Rows<'py>>,
    pub(crate) batch: Vec<usize>,
}

impl Given<'_> {
    pub(crate) fn count(&self) -> usize {
        self.batch.iter().product()
    }
}

pub(crate) fn row<'a>(rows: &'a Rows<'_>, k: usize, width: usize) -> &'a [f64] {
    let k = if rows.batch().is_empty() { 0 } else { k };
    &rows.as_slice()[k * width..(k + 1) * width]
}

/// Sets the numbers beside q and v: the state of contact, then activations.
pub(super) fn set_beside(state: &mut State, numbers: &[f64]) {
    let own = state.contact.iter_mut().chain(&mut state.activation);
    own.zip(numbers).for_each(|(own, &given)| *own = given);
}

/// The error of a state of a batch, with its index.
pub(super) fn of_row(k: usize, error: PyErr, py: Python<'_>) -> PyErr {
    value_error(format_args!("state {k} of the batch: {}", error.value(py)))
}

pub(crate) fn check_finite(name: &str, x: &[f64]) -> PyResult<()> {
    match x.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(k) => Err(value_error(format_args!("{name}[{k}] is {}", x[k]))),
    }
}

impl PySimulator {
    /// Reads states and inputs; the state of contact is neutral where none is given.
    pub(crate) fn read<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Given<'py>> {
        let (nq, nv, nu, nc) = self.sizes();
        let read = |name, value: &Bound<'py, PyAny>, n: usize| {
            let rows = Rows::read(&argument(name, value, &[n]));
            rows.map_err(|error| about_base(q.py(), self.simulator.model(), error))
        };
        let neutral = || vector(q.py(), vec![0.0; nc]).into_any();
        let neutral = (contact.is_none() && nc > 0).then(neutral);
        let contact = contact.or(neutral.as_ref());
        let given = Given {
            q: read("q", q, nq)?,
            v: read("v", v, nv)?,
            u: u.map(|u| read("u", u, nu)).transpose()?,
            contact: contact
                .map(|contact| read("contact", contact, nc))
                .transpose()?,
            batch: Vec::new(),
        };
        let names = ["q", "v", "u", "contact"];
        let present = [
            Some(&given.q),
            Some(&given.v),
            given.u.as_ref(),
            given.contact.as_ref(),
        ];
        let batches = names.into_iter().zip(present);
        let batch = common_batch(batches.filter_map(|(name, rows)| Some((name, rows?.batch()))))?;
        Ok(Given { batch, ..given })
    }

    /// Reads a state of a batch, checked, into memory whose state of contact is neutral.
    pub(super) fn read_state(&self, given: &Given<'_>, k: usize, out: &mut State) -> PyResult<()> {
        let (nq, nv, _, nc) = self.sizes();
        out.q.copy_from_slice(row(&given.q, k, nq));
        out.v.copy_from_slice(row(&given.v, k, nv));
        if let Some(contact) = &given.contact {
            set_beside(out, row(contact, k, nc));
        }
        out.check(self.simulator.model()).or_raise()
    }

    /// A state of a batch, checked.
    pub(super) fn state(&self, given: &Given<'_>, k: usize) -> PyResult<State> {
        let mut state = self.simulator.neutral_state();
        self.read_state(given, k, &mut state)?;
        Ok(state)
    }

    pub(crate) fn states(&self, given: &Given<'_>, count: usize) -> PyResult<Vec<State>> {
        let named = |k: usize| {
            let state = self.state(given, k);
            match given.batch.is_empty() {
                true => state,
                false => state.map_err(|error| of_row(k, error, given.q.py())),
            }
        };
        (0..count).map(named).collect()
    }

    /// The inputs of all states, one after the other.
    pub(crate) fn inputs(&self, given: &Given<'_>, count: usize) -> PyResult<Vec<f64>> {
        let nu = self.simulator.nu();
        let Some(u) = &given.u else {
            return Ok(vec![0.0; count * nu]);
        };
        if let Some(k) = u.as_slice().iter().position(|x| !x.is_finite()) {
            let (k, x) = (k / nu, &u.as_slice()[k - k % nu..][..nu]);
            let error = check_finite("u", x);
            return match u.batch().is_empty() {
                true => error.map(|()| Vec::new()),
                false => error
                    .map_err(|error| of_row(k, error, u.py()))
                    .map(|()| Vec::new()),
            };
        }
        Ok((0..count)
            .flat_map(|k| row(u, k, nu).iter().copied())
            .collect())
    }

    /// One state, not a batch.
    pub(super) fn one<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Given<'py>> {
        let given = self.read(q, v, u, contact)?;
        match given.batch.is_empty() {
            true => Ok(given),
            false => Err(value_error(format_args!(
                "one state is expected, not a batch of shape {:?}",
                given.batch
            ))),
        }
    }
}
