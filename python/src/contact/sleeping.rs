//! Sleep of resting islands.

use dualbody::Simulator;
use dualbody::sim::Sleeping;
use pyo3::prelude::*;

use crate::errors::{guarded, value_error};

/// The simulator with the sleep that its parts name: `True` for the default, `False` for none, or (speed, time).
pub(super) fn add(simulator: Simulator, parts: &Bound<'_, PyAny>) -> PyResult<Simulator> {
    let given = parts.get_item("sleeping")?;
    // A scene has its own, which only a part replaces.
    if given.is_none() {
        return Ok(simulator);
    }
    let sleeping = match given.extract::<bool>() {
        Ok(sleeps) => sleeps.then(Sleeping::default),
        Err(_) => {
            let [speed, time] = given.extract().map_err(|_| {
                value_error(format_args!(
                    "sleeping is {given}, expected True, False, or (speed in m/s and rad/s, time in s)"
                ))
            })?;
            Some(Sleeping { speed, time })
        }
    };
    guarded(|| simulator.with_sleeping(sleeping))
}
