//! Times of a function of many states.

use dualbody_cuda::{CudaError, Real};

use crate::ceilings::{median_of, timed};
use crate::functions::Loaded;
use crate::gpu::{Arrays, Gpu};
use crate::rates::Measured;

/// Runs that are timed.
const RUNS: usize = 7;
/// The least time that a run should take, s, and the most calls for it.
const LEAST: (f64, f64) = (2e-3, 50.0);

/// Times of a function.
pub(crate) struct Time {
    pub(crate) states: usize,
    /// Of a call, timed on the device, s.
    pub(crate) seconds: f64,
    /// Of a call that is waited for, by the clock, s.
    pub(crate) waited: f64,
    /// States that did not end as they should.
    pub(crate) flagged: usize,
}

/// Times a function of so many states.
pub(crate) fn time<R: Real>(
    gpu: &Gpu,
    loaded: &Loaded<R>,
    measured: &Measured<'_>,
    states: usize,
) -> Result<Time, CudaError> {
    let device = &gpu.device;
    let schedule = [measured.steps, 0];
    let mut arrays = Arrays::<R>::new(device, loaded, measured.cases, states, schedule)?;
    arrays.reset(loaded)?;
    arrays.run(loaded)?;
    arrays.reset(loaded)?;
    let once = timed(device, || arrays.run(loaded))?;
    let calls = (LEAST.0 / once).clamp(1.0, LEAST.1) as usize;
    let seconds = median_of(RUNS, || {
        arrays.reset(loaded)?;
        timed(device, || (0..calls).try_for_each(|_| arrays.run(loaded)))
    })?;
    arrays.reset(loaded)?;
    device.synchronize()?;
    let start = std::time::Instant::now();
    arrays.run(loaded)?;
    device.synchronize()?;
    let waited = start.elapsed().as_secs_f64();
    let (found, taken) = (arrays.status.found()?, arrays.status.taken()?);
    let is_wrong = |i: &usize| found[*i] != 0 || taken[*i] as usize != measured.steps;
    Ok(Time {
        states,
        seconds: seconds / calls as f64,
        waited,
        flagged: (0..states).filter(is_wrong).count(),
    })
}
