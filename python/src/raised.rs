//! Exceptions of functions of Python that a solver calls.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use dualbody::StopSignal;

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

    /// Raises the exception that was kept.
    pub(crate) fn check(&self) -> PyResult<()> {
        let first = self.lock().take();
        first.map_or(Ok(()), Err)
    }

    fn lock(&self) -> MutexGuard<'_, Option<PyErr>> {
        self.first.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
