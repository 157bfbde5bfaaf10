//! Fits through the simulator.

use dualbody::identify::{Adjustable, ShootingOptions, Starts, shoot};
use dualbody::least_squares::Status;

use super::data::data_of;
use super::estimate::{IntervalNumbers, interval};
use crate::prelude::*;

fn options_of(value: &Bound<'_, PyDict>) -> PyResult<ShootingOptions> {
    let starts = chosen(
        "starts",
        &[("measured", Starts::Measured), ("free", Starts::Free)],
    );
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

/// (values, intervals, deviation, status, converged, iterations, parameters of the model).
type Found<'py> = (
    Bound<'py, PyAny>,
    Option<Vec<IntervalNumbers>>,
    f64,
    String,
    bool,
    usize,
    Bound<'py, PyAny>,
);

functions! {
    /// Adjusts numbers of a simulator until its motion is that of the data.
    fn _shoot(
        py: Python, simulator: &Bound<'py, PySimulator>, data, adjustable: Vec<Bound<'py, PyAny>>, level: f64, options: &Bound<'py, PyDict>
    ) -> PyResult<Found<'py>> {
        let (data, options) = (data_of(data)?, options_of(options)?);
        let all: Vec<Adjustable> = adjustable
            .iter()
            .map(adjustable_of)
            .collect::<PyResult<_>>()?;
        let own = &*simulator.get().simulator;
        let found = on_pool_stopped(py, || shoot(own, &data, &all, level, &options))?;
        let found = found.or_raise()?;
        let parameters = found.simulator.model().parameters();
        let intervals = found.intervals;
        Ok((
            vector(py, &found.values),
            intervals.map(|all| all.into_iter().map(interval).collect()),
            found.deviation,
            found.status.to_string(),
            found.status == Status::Converged,
            found.iterations,
            vector(py, parameters.as_slice()),
        ))
    }
}
