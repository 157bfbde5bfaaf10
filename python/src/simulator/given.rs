//! States and inputs that a call is given.

use dualbody::State;
use nalgebra::DVector;
use pyo3::prelude::*;

use super::handle::PySimulator;
use crate::arrays::{Rows, argument, common_batch};
use crate::errors::{OrRaise, value_error};

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

pub(super) fn check_finite(name: &str, x: &[f64]) -> PyResult<()> {
    match x.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(k) => Err(value_error(format_args!("{name}[{k}] is {}", x[k]))),
    }
}

impl PySimulator {
    pub(crate) fn read<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Given<'py>> {
        let (nq, nv, nu, nc) = self.sizes();
        let read =
            |name, value: &Bound<'py, PyAny>, n: usize| Rows::read(&argument(name, value, &[n]));
        if contact.is_none() && nc > 0 {
            return Err(value_error(
                "contact is missing: this simulator's contacts have a state, which begins as simulator.neutral_contact()",
            ));
        }
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

    /// A state of a batch, checked.
    pub(super) fn state(&self, given: &Given<'_>, k: usize) -> PyResult<State> {
        let (nq, nv, _, nc) = self.sizes();
        let state = State::new(row(&given.q, k, nq), row(&given.v, k, nv));
        let state = match &given.contact {
            Some(contact) => state.with_contact(DVector::from_column_slice(row(contact, k, nc))),
            None => state,
        };
        state.check(self.simulator.model()).or_raise()?;
        Ok(state)
    }

    pub(crate) fn states(&self, given: &Given<'_>, count: usize) -> PyResult<Vec<State>> {
        (0..count).map(|k| self.state(given, k)).collect()
    }

    /// The inputs of all states, one after the other.
    pub(crate) fn inputs(&self, given: &Given<'_>, count: usize) -> PyResult<Vec<f64>> {
        let nu = self.simulator.nu();
        let Some(u) = &given.u else {
            return Ok(vec![0.0; count * nu]);
        };
        check_finite("u", u.as_slice())?;
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
