//! Experiments, their preparation, data.

use dualbody::identify::{
    Dataset, Experiment, LowPass, Preparation, Quantity, SavitzkyGolay, Segment, Unit,
};
use nalgebra::DMatrix;
use pyo3::prelude::*;

use crate::arrays::{Array, empty, numbers_mut, read_matrix, read_vector};
use crate::counts::whole_of;
use crate::errors::{OrRaise, choice, guarded};
use crate::model::PyModel;
use crate::python::functions;

const QUANTITIES: [(&str, Quantity); 4] = [
    ("position", Quantity::Position),
    ("velocity", Quantity::Velocity),
    ("acceleration", Quantity::Acceleration),
    ("force", Quantity::Force),
];

const UNITS: [(&str, Unit); 5] = [
    ("si", Unit::Si),
    ("degree", Unit::Degree),
    ("turn", Unit::Turn),
    ("turn_per_minute", Unit::TurnPerMinute),
    ("millimetre", Unit::Millimetre),
];

/// A segment as Python has it: name, start, rate, and q, v, a, tau with a row for each sample.
type SegmentNumbers<'py> = (String, f64, f64, [Array<'py>; 4]);

functions! {
    /// Prepares experiments for a robot: segments, and stretches that were too short as (name, start, samples).
    fn _prepare(
        model: &Bound<'py, PyModel>, preparation, experiments: Vec<Bound<'py, PyAny>>
    ) -> PyResult<(Vec<SegmentNumbers<'py>>, Vec<(String, f64, usize)>)> {
        let (py, model) = (model.py(), &*model.get().model);
        let preparation = preparation_of(preparation)?;
        let all: Vec<Experiment> = experiments
            .iter()
            .map(experiment_of)
            .collect::<PyResult<_>>()?;
        let data = py.detach(|| guarded(|| preparation.prepare(model, &all)))?;
        let data = data.or_raise()?;
        let left_out = data.left_out.into_iter();
        let left_out = left_out.map(|own| (own.experiment, own.start, own.samples));
        let segments = data.segments.iter().map(|own| numbers_of(py, own));
        Ok((segments.collect(), left_out.collect()))
    }
}

fn numbers_of<'py>(py: Python<'py>, segment: &Segment) -> SegmentNumbers<'py> {
    let rows = [&segment.q, &segment.v, &segment.a, &segment.tau].map(|m| samples(py, m));
    (
        segment.experiment.clone(),
        segment.start,
        segment.rate,
        rows,
    )
}

/// A matrix whose columns are samples, as an array whose rows are.
pub(super) fn samples<'py>(py: Python<'py>, m: &DMatrix<f64>) -> Array<'py> {
    let array = empty(py, &[m.ncols(), m.nrows()]);
    // Columns after each other are rows after each other.
    numbers_mut(&array).copy_from_slice(m.as_slice());
    array
}

fn preparation_of(value: &Bound<'_, PyAny>) -> PyResult<Preparation> {
    let (half_width, degree): (usize, usize) =
        (whole_of(value, "half_width")?, whole_of(value, "degree")?);
    let mut out = Preparation::new(SavitzkyGolay::new(half_width, degree).or_raise()?)
        .with_decimation(whole_of(value, "decimation")?);
    let low_pass: Option<(usize, f64)> = whole_of(value, "low_pass")?;
    if let Some((order, cutoff)) = low_pass {
        out = out.with_low_pass(LowPass { order, cutoff });
    }
    Ok(out)
}

fn experiment_of(value: &Bound<'_, PyAny>) -> PyResult<Experiment> {
    let name: String = value.getattr("name")?.extract()?;
    let times = value.getattr("times")?;
    let mut out = match times.is_none() {
        true => Experiment::at_rate(name, value.getattr("rate")?.extract()?),
        false => Experiment::at_times(name, &read_vector("times", &times, None)?),
    };
    for channel in value.getattr("channels")?.try_iter()? {
        let channel = channel?;
        let text = |name: &str| -> PyResult<String> { channel.getattr(name)?.extract() };
        let quantity = choice("quantity", &text("quantity")?, &QUANTITIES)?;
        let unit = channel.getattr("unit")?;
        let unit = match unit.extract::<f64>() {
            Ok(factor) => Unit::Scale(factor),
            Err(_) => choice("unit", &unit.extract::<String>()?, &UNITS)?,
        };
        // Quantities of several numbers have a row for each sample.
        let values = channel.getattr("values")?.call_method0("ravel")?;
        let values = read_vector("values", &values, None)?;
        out = out.with_channel(text("joint")?, quantity, unit, &values);
    }
    for joint in value.getattr("passive")?.extract::<Vec<String>>()? {
        out = out.with_passive_joint(joint);
    }
    Ok(out)
}

/// Data from their description in Python.
pub(super) fn data_of(value: &Bound<'_, PyAny>) -> PyResult<Dataset> {
    let segments = value.getattr("segments")?;
    let one = |segment: PyResult<Bound<'_, PyAny>>| -> PyResult<Segment> {
        let segment = segment?;
        let columns = |name| -> PyResult<DMatrix<f64>> {
            Ok(read_matrix(name, &segment.getattr(name)?)?.transpose())
        };
        Ok(Segment {
            experiment: whole_of(&segment, "experiment")?,
            start: segment.getattr("start")?.extract()?,
            rate: segment.getattr("rate")?.extract()?,
            q: columns("q")?,
            v: columns("v")?,
            a: columns("a")?,
            tau: columns("tau")?,
        })
    };
    let segments = segments.try_iter()?.map(one).collect::<PyResult<_>>()?;
    Ok(Dataset::new(segments))
}
