//! The limit of memory: results that would not fit are refused before any work, as a process that runs out of memory ends without an exception.

use std::fs::read_to_string;
use std::sync::atomic::{AtomicUsize, Ordering};

use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;

use crate::counts::whole;

/// The limit that was set, bytes; zero for what the machine has.
static LIMIT: AtomicUsize = AtomicUsize::new(0);

/// Bytes of a state of one trajectory beside its numbers: while it is found each of its parts is a vector of its own.
const STATE_OVERHEAD: usize = 256;

/// Copies of a result that there are at a time: as it is found, and as an array.
const COPIES: usize = 2;

/// Returns the bytes above which a result is refused with a MemoryError before any work.
#[pyfunction]
pub(crate) fn memory_limit() -> usize {
    match LIMIT.load(Ordering::Relaxed) {
        0 => machine(),
        limit => limit,
    }
}

/// Sets the bytes above which a result is refused with a MemoryError before any work; None for what the machine has.
#[pyfunction]
#[pyo3(signature = (bytes))]
pub(crate) fn set_memory_limit(bytes: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    let bytes: Option<usize> = bytes.map(|bytes| whole("bytes", bytes)).transpose()?;
    LIMIT.store(bytes.unwrap_or(0), Ordering::Relaxed);
    Ok(())
}

/// Memory of the machine, or what its control group may use of it, bytes; as much as can be addressed where that is not known.
fn machine() -> usize {
    let total = read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text
            .lines()
            .find_map(|line| line.strip_prefix("MemTotal:"))?;
        let kilobytes: usize = line.trim().trim_end_matches("kB").trim().parse().ok()?;
        kilobytes.checked_mul(1024)
    });
    let group = read_to_string("/sys/fs/cgroup/memory.max");
    let group = group.ok().and_then(|text| text.trim().parse().ok());
    let known = [total, group].into_iter().flatten().min();
    known.unwrap_or(isize::MAX as usize)
}

/// Refuses trajectories that would not fit.
///
/// * `count` – number of trajectories
/// * `width` – numbers of a state and an input
pub(crate) fn check_trajectories(count: usize, steps: usize, width: usize) -> PyResult<()> {
    let of_state = (width * size_of::<f64>())
        .saturating_mul(COPIES)
        .saturating_add(if count == 1 { STATE_OVERHEAD } else { 0 });
    let states = count.saturating_mul(steps.saturating_add(1));
    check(
        format_args!("{count} trajectories of {steps} steps"),
        states.saturating_mul(of_state),
    )
}

/// Refuses what would need more bytes than the limit.
pub(crate) fn check(what: impl std::fmt::Display, bytes: usize) -> PyResult<()> {
    let limit = memory_limit();
    if bytes <= limit {
        return Ok(());
    }
    Err(PyMemoryError::new_err(format!(
        "{what} need {:.1e} bytes, and the limit is {:.1e}: set_memory_limit changes it",
        bytes as f64, limit as f64
    )))
}
