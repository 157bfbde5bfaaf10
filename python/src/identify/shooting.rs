//! Fits through the simulator.

use dualbody::identify::{Adjustable, ShootingOptions, Starts, shoot};
use dualbody::least_squares::Status;

use super::data::data_of;
use super::estimate::interval;
use crate::prelude::*;

fn options_of(value: &Bound<'_, PyDict>) -> PyResult<ShootingOptions> {
    let starts = chosen("starts", &[Starts::Measured, Starts::Free]);
    read_options!(ShootingOptions, "shoot", value;
        samples, starts = starts by starts, position_deviation, velocity_deviation, regularization, max_iterations)
}

/// The adjusted parameter.
fn adjustable_of(value: &Bound<'_, PyAny>) -> PyResult<Adjustable> {
    let text = |name: &str| -> PyResult<String> { attribute(value, name) };
    Ok(match kind_of(value)?.as_str() {
        "Inertia" => Adjustable::Inertia(text("link")?),
        "LinkMass" => Adjustable::LinkMass(text("link")?),
        "Parameter" => Adjustable::Parameter(text("name")?),
        _ => {
            let points = value.getattr("points")?.try_iter()?;
            let points = points.map(|point| whole("points", &point?));
            Adjustable::Friction(points.collect::<PyResult<_>>()?)
        }
    })
}

functions! {
    /// Adjusts numbers of a simulator until its motion is that of the data: (values, intervals, deviation, status, converged, iterations, parameters of the model).
    fn _shoot(
        py: Python, simulator: &Bound<'py, PySimulator>, data, adjustable: Vec<Bound<'py, PyAny>>, level: f64, options: &Bound<'py, PyDict>
    ) -> PyResult<Bound<'py, PyTuple>> {
        let (data, options) = (data_of(data)?, options_of(options)?);
        let all: Vec<Adjustable> = adjustable.iter().map(adjustable_of).collect::<PyResult<_>>()?;
        let own = &*simulator.get().simulator;
        let found = on_pool_stopped(py, || shoot(own, &data, &all, level, &options))?;
        let found = found.or_raise()?;
        let parameters = vector(py, found.simulator.model().parameters().as_slice());
        let intervals: Option<Vec<_>> = found.intervals.map(|all| all.into_iter().map(interval).collect());
        let (values, status) = (vector(py, &found.values), found.status.to_string());
        let is_converged = found.status == Status::Converged;
        (values, intervals, found.deviation, status, is_converged, found.iterations, parameters).into_pyobject(py)
    }
}
