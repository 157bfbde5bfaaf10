//! A simulation in the browser while it runs.

use std::sync::{Mutex, MutexGuard, PoisonError};

use dualbody::view::{Live, Recording};

use super::recording::PyRecording;
use crate::prelude::*;

/// A simulation that a page shows while it runs; a notebook shows it in a frame. It ends with `stop`, or when nothing refers to it.
#[pyclass(name = "Live", module = "dualbody", frozen)]
pub(crate) struct PyLive {
    /// `None` once it has ended.
    live: Mutex<Option<Live>>,
    url: String,
    model: Py<PyModel>,
}

getters! { PyLive {
    /// URL of the page, for browsers of this machine; it contains a secret.
    url: &str = |own| &own.url;
} }

impl PyLive {
    /// The result of `read` on the simulation.
    fn of<R: Send>(&self, py: Python<'_>, read: impl FnOnce(&Live) -> R + Send) -> PyResult<R> {
        py.detach(|| self.lock().as_ref().map(read))
            .ok_or_else(|| value_error("the simulation has ended"))
    }

    fn lock(&self) -> MutexGuard<'_, Option<Live>> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl PyLive {
    /// The recording since the start or the last reset, with at most 60 times per second.
    fn recording(&self, py: Python<'_>) -> PyResult<PyRecording> {
        let recording: Recording = self.of(py, Live::recording)?;
        Ok(PyRecording {
            recording,
            models: vec![self.model.clone_ref(py)],
        })
    }

    /// The current state: (nq,) and (nv,).
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let State { q, v, .. } = self.of(py, Live::state)?;
        let array = |x: &[f64]| vector(py, x);
        Ok((array(q.as_slice()), array(v.as_slice())))
    }

    /// Ends the simulation; its page reports this.
    fn stop(&self, py: Python<'_>) {
        py.detach(|| drop(self.lock().take()));
    }

    fn _repr_html_(&self) -> String {
        let url = &self.url;
        format!("<iframe src=\"{url}\" width=\"100%\" height=\"640\" style=\"border:0\"></iframe>")
    }

    fn __repr__(&self) -> String {
        format!("Live(\"{}\")", self.url)
    }
}

methods! { PySimulator {
    /// Runs the simulation interactively in the browser, from a state (the neutral one at rest by default): pause, step, speed, reset, pull bodies
    /// with the mouse, move joints by sliders (through servos). Its address is `.url`; a notebook shows it in a frame.
    fn live(&self, py: Python, q = None, v = None) -> PyResult<PyLive> {
        let simulator: &Simulator = &self.simulator;
        let mut start: State = simulator.neutral_state();
        if let Some(q) = q {
            let q = read_vector("q", q, Some(simulator.model().nq()))?;
            start.q.copy_from_slice(&q);
        }
        if let Some(v) = v {
            let v = read_vector("v", v, Some(simulator.model().nv()))?;
            start.v.copy_from_slice(&v);
        }
        start.check(simulator.model()).or_raise()?;
        let live = guarded(|| Live::start(simulator.clone(), &start))??;
        Ok(PyLive {
            url: live.url().to_owned(),
            live: Mutex::new(Some(live)),
            model: self.model(py),
        })
    }
} }
