//! Motions that excite.

use dualbody::identify::{Excitation, ExcitationOptions, excite};

use super::regressor::regressor_of;
use crate::prelude::*;

fn options_of(value: &Bound<'_, PyDict>) -> PyResult<ExcitationOptions> {
    read_options!(ExcitationOptions, "excite", value;
        period, harmonics, range, reach, speed, acceleration, force_deviations, max_iterations, starts, seed)
}

functions! {
    /// Finds a periodic motion that tells much of the unknowns: (period, centre, coefficients, condition, condition of the start).
    fn _excite(py: Python, regressor, options: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyTuple>> {
        let (regressor, options) = (regressor_of(regressor)?, options_of(options)?);
        let found = on_pool_stopped(py, || excite(&regressor, &options))?;
        let found = found.or_raise()?;
        let (center, coefficients) = (vector(py, &found.center), matrix(py, &found.coefficients));
        (found.period, center, coefficients, found.condition, found.start_condition).into_pyobject(py)
    }

    /// Configurations, velocities and accelerations of a motion at times, (times, n) each.
    fn _excited(py: Python, motion, times) -> PyResult<[Array<'py>; 3]> {
        let center = read_vector("center", &motion.getattr("center")?, None)?;
        let (n, times) = (center.len(), read_vector("times", times, None)?);
        let motion = Excitation {
            period: attribute(motion, "period")?,
            coefficients: read_matrix("coefficients", &motion.getattr("coefficients")?)?,
            condition: attribute(motion, "condition")?,
            start_condition: attribute(motion, "start_condition")?,
            center,
        };
        let out = [(); 3].map(|()| empty(py, &[times.len(), n]));
        for (k, &time) in times.iter().enumerate() {
            let at = motion.at(time);
            for (out, x) in out.iter().zip([&at.q, &at.v, &at.a]) {
                numbers_mut(out)[k * n..(k + 1) * n].copy_from_slice(x.as_slice());
            }
        }
        Ok(out)
    }
}
