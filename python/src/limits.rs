//! The limit of memory: results that would not fit are refused before any work, as a process that runs out of memory ends without an exception.

use dualbody::error::OutOfMemory;
use dualbody::memory;
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;

use crate::errors::{OrRaise, Raise};
use crate::kinds::whole;
use crate::python::functions;

/// Bytes of a state of one trajectory beside its numbers: while it is found each of its parts is a vector of its own.
const STATE_OVERHEAD: usize = 256;

/// Copies of a result in memory at a time: the computed one, and the array.
const COPIES: usize = 2;

/// Bytes of a height of a grid on its way: where it is, as an array and as a number of Python, in the library with a weight of its spline.
const HEIGHT: usize = 96;

/// Returns the bytes above which a result is refused with a MemoryError before any work.
#[pyfunction]
pub(crate) fn memory_limit() -> usize {
    memory::limit()
}

functions! {
    /// Sets the bytes above which a result is refused with a MemoryError before any work; None for what the machine has.
    fn set_memory_limit(bytes: Option<&Bound<'py, PyAny>>) -> PyResult<()> {
        let bytes: Option<usize> = bytes.map(|bytes| whole("bytes", bytes)).transpose()?;
        memory::set_limit(bytes);
        Ok(())
    }
}

/// Refuses trajectories that would not fit.
///
/// * `count` – number of trajectories
/// * `width` – entries of a state and an input
pub(crate) fn check_trajectories(count: usize, steps: usize, width: usize) -> PyResult<()> {
    let of_state = width
        .saturating_mul(size_of::<f64>() * COPIES)
        .saturating_add(if count == 1 { STATE_OVERHEAD } else { 0 });
    let states = count.saturating_mul(steps.saturating_add(1));
    check(
        format_args!("{count} trajectories of {steps} steps"),
        states.saturating_mul(of_state),
    )
}

/// Refuses a grid of nx × ny heights that would not fit.
#[pyfunction]
pub(crate) fn _check_grid(nx: &Bound<'_, PyAny>, ny: &Bound<'_, PyAny>) -> PyResult<()> {
    check_grid(whole("nx", nx)?, whole("ny", ny)?)
}

/// [`_check_grid`] of numbers.
pub(crate) fn check_grid(nx: usize, ny: usize) -> PyResult<()> {
    let bytes = nx.saturating_mul(ny).saturating_mul(HEIGHT);
    check(format_args!("grids of {nx} × {ny} heights"), bytes)
}

/// Refuses an array that would not fit.
pub(crate) fn check_array(what: impl std::fmt::Display, shape: &[usize]) -> PyResult<()> {
    let bytes = shape
        .iter()
        .fold(size_of::<f64>(), |bytes, n| bytes.saturating_mul(*n));
    check(format_args!("{what} of the shape {shape:?}"), bytes)
}

/// Refuses what would need more bytes than the limit.
pub(crate) fn check(what: impl std::fmt::Display, bytes: usize) -> PyResult<()> {
    memory::check(what, bytes).or_raise()
}

impl Raise for OutOfMemory {
    fn raise(self) -> PyErr {
        let (bytes, limit) = (self.bytes as f64, self.limit as f64);
        PyMemoryError::new_err(format!(
            "{} need {bytes:.1e} bytes, and the limit is {limit:.1e}: set_memory_limit changes it",
            self.what
        ))
    }
}
