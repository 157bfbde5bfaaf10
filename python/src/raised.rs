//! Exceptions of functions of Python that a solver calls.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use dualbody::StopSignal;
use pyo3::types::PyBool;

use crate::prelude::*;

/// The first exception of a solver's functions, which ends the solver.
#[derive(Clone, Default)]
pub(crate) struct Raised {
    first: Arc<Mutex<Option<PyErr>>>,
    /// Set by an exception.
    pub(crate) stop: StopSignal,
}

impl Raised {
    /// Calls functions, unless one has raised an exception; `None` if so, or if one does now, whose exception is kept.
    pub(crate) fn attempt<R>(&self, call: impl FnOnce() -> PyResult<R>) -> Option<R> {
        if self.lock().is_some() {
            return None;
        }
        match call() {
            Ok(found) => Some(found),
            Err(error) => {
                self.lock().get_or_insert(error);
                self.stop.stop();
                None
            }
        }
    }

    /// Writes the numbers that a function gives; what is not finite, which ends the solver, if one has raised an exception.
    pub(crate) fn fill(&self, out: &mut [f64], call: impl FnOnce() -> PyResult<Vec<f64>>) {
        match self.attempt(call) {
            Some(found) => out.copy_from_slice(&found),
            None => out.fill(f64::NAN),
        }
    }

    /// Calls a report of progress, if there is one; what it returns or raises may end the solver.
    pub(crate) fn tell(&self, report: Option<&Py<PyAny>>, numbers: (usize, f64, f64, f64)) {
        let Some(report) = report else { return };
        let call = |py: Python<'_>| {
            let found = report.call1(py, numbers)?;
            Ok(found.bind(py).is(&*PyBool::new(py, true)))
        };
        if self.attempt(|| Python::attach(call)) == Some(true) {
            self.stop.stop();
        }
    }

    /// Raises the exception that was kept.
    pub(crate) fn check(&self) -> PyResult<()> {
        let first = self.lock().take();
        first.map_or(Ok(()), Err)
    }

    fn lock(&self) -> MutexGuard<'_, Option<PyErr>> {
        self.first.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
