//! Experiments, their preparation, data.

use dualbody::identify::{
    Dataset, Experiment, LowPass, Preparation, Quantity, SavitzkyGolay, Segment, Unit,
};

use crate::prelude::*;

use Quantity::{Acceleration, Force, Position, Velocity};
use Unit::{Degree, Millimetre, Si, Turn, TurnPerMinute};

/// Segments as Python has them: name, start, rate, and q, v, a, tau with a row for each sample.
type Segments<'py> = Vec<Bound<'py, PyTuple>>;

functions! {
    /// Prepares experiments for a robot: segments, and stretches that were too short as (name, start, samples).
    fn _prepare(model: &Bound<'py, PyModel>, preparation, experiments: Vec<Bound<'py, PyAny>>) -> PyResult<(Segments<'py>, Vec<(String, f64, usize)>)> {
        let (py, model) = (model.py(), &*model.get().model);
        let preparation = preparation_of(preparation)?;
        let all: Vec<Experiment> = experiments.iter().map(experiment_of).collect::<PyResult<_>>()?;
        let data = py.detach(|| guarded(|| preparation.prepare(model, &all)))?.or_raise()?;
        let left_out = data.left_out.iter();
        let left_out = left_out.map(|own| (own.experiment.clone(), own.start, own.samples));
        Ok((numbers_of(py, &data)?, left_out.collect()))
    }

    /// Segments of training data, and of the last share of each segment.
    fn _hold_back(py: Python, data, share: f64) -> PyResult<[Segments<'py>; 2]> {
        let data = data_of(data)?;
        let (kept, held) = guarded(|| data.hold_back(share))?;
        Ok([numbers_of(py, &kept)?, numbers_of(py, &held)?])
    }
}

fn numbers_of<'py>(py: Python<'py>, data: &Dataset) -> PyResult<Segments<'py>> {
    let one = |own: &Segment| {
        let [q, v, a, tau] = [&own.q, &own.v, &own.a, &own.tau].map(|m| samples(py, m));
        (&own.experiment, own.start, own.rate, q, v, a, tau).into_pyobject(py)
    };
    data.segments.iter().map(one).collect()
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
        (attribute(value, "half_width")?, attribute(value, "degree")?);
    let mut out = Preparation::new(SavitzkyGolay::new(half_width, degree).or_raise()?)
        .with_decimation(attribute(value, "decimation")?);
    let low_pass: Option<(usize, f64)> = attribute(value, "low_pass")?;
    if let Some((order, cutoff)) = low_pass {
        out = out.with_low_pass(LowPass { order, cutoff });
    }
    Ok(out)
}

fn experiment_of(value: &Bound<'_, PyAny>) -> PyResult<Experiment> {
    let name: String = attribute(value, "name")?;
    let times = value.getattr("times")?;
    let mut out = match times.is_none() {
        true => Experiment::at_rate(name, attribute(value, "rate")?),
        false => Experiment::at_times(name, &read_vector("times", &times, None)?),
    };
    for channel in value.getattr("channels")?.try_iter()? {
        let channel = channel?;
        let text = |name: &str| -> PyResult<String> { attribute(&channel, name) };
        let quantity = variant(
            "quantity",
            &text("quantity")?,
            &[Position, Velocity, Acceleration, Force],
        )?;
        let unit = channel.getattr("unit")?;
        let unit = match unit.extract::<f64>() {
            Ok(factor) => Unit::Scale(factor),
            Err(_) => variant(
                "unit",
                &unit.extract::<String>()?,
                &[Si, Degree, Turn, TurnPerMinute, Millimetre],
            )?,
        };
        // Quantities of several numbers have a row for each sample.
        let values = channel.getattr("values")?.call_method0("ravel")?;
        let values = read_vector("values", &values, None)?;
        out = out.with_channel(text("joint")?, quantity, unit, &values);
    }
    for joint in attribute::<Vec<String>>(value, "passive")? {
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
            experiment: attribute(&segment, "experiment")?,
            start: attribute(&segment, "start")?,
            rate: attribute(&segment, "rate")?,
            q: columns("q")?,
            v: columns("v")?,
            a: columns("a")?,
            tau: columns("tau")?,
        })
    };
    let segments = segments.try_iter()?.map(one).collect::<PyResult<_>>()?;
    Ok(Dataset::new(segments))
}
