//! Identified robots.

use dualbody::identify::Robot;
use pyo3::prelude::*;

use super::data::{data_of, samples};
use super::regressor::{friction_of, model_of};
use crate::arrays::{Array, Work, argument, map_rows, read_vector, vector};
use crate::errors::{OrRaise, guarded};

/// An identified robot as Python has it: all parameters of the model, dry friction, offsets.
pub(super) type RobotNumbers<'py> = [Bound<'py, PyAny>; 3];

pub(super) fn numbers_of<'py>(py: Python<'py>, robot: &Robot) -> RobotNumbers<'py> {
    let parameters = robot.model.parameters().as_slice().to_vec();
    let all = [
        parameters,
        robot.dry_friction.clone(),
        robot.offsets.clone(),
    ];
    all.map(|x| vector(py, x).into_any())
}

pub(super) fn robot_of(value: &Bound<'_, PyAny>) -> PyResult<Robot> {
    let model = (*model_of(value)?.get().model).clone();
    let all = |name: &'static str| read_vector(name, &value.getattr(name)?, Some(model.nv()));
    Ok(Robot {
        dry_friction: all("dry_friction")?,
        offsets: all("offsets")?,
        shape: friction_of(value.getattr("shape")?.extract()?)?,
        model,
    })
}

/// Joint forces that a robot needs for a motion, (…, nv).
#[pyfunction]
pub(crate) fn _predict<'py>(
    robot: &Bound<'py, PyAny>,
    q: &Bound<'py, PyAny>,
    v: &Bound<'py, PyAny>,
    a: &Bound<'py, PyAny>,
) -> PyResult<Array<'py>> {
    let (own, model) = (robot_of(robot)?, model_of(robot)?);
    let (m, id) = (&*model.get().model, model.get().id);
    let (nq, nv) = ([m.nq()], [m.nv()]);
    let arguments = [
        argument("q", q, &nq),
        argument("v", v, &nv),
        argument("a", a, &nv),
    ];
    let work = Work {
        one: &|_, x, out| out.copy_from_slice(own.predict(x[0], x[1], x[2]).as_slice()),
        wide: None,
    };
    map_rows(q.py(), (m, id), &arguments, &nv, None, work)
}

/// Errors (rms, mean, largest, rms of the measured) along each coordinate, and predicted forces (samples, nv) of each segment.
type Validation<'py> = (Vec<[f64; 4]>, Vec<Array<'py>>);

/// Compares predicted with measured forces.
#[pyfunction]
pub(crate) fn _validate<'py>(
    robot: &Bound<'py, PyAny>,
    data: &Bound<'py, PyAny>,
) -> PyResult<Validation<'py>> {
    let (own, data) = (robot_of(robot)?, data_of(data)?);
    let found = guarded(|| own.validate(&data))?.or_raise()?;
    let errors = found.coordinates.iter();
    let errors = errors.map(|own| [own.rms, own.mean, own.largest, own.measured]);
    let predicted = found.predicted.iter().map(|m| samples(robot.py(), m));
    Ok((errors.collect(), predicted.collect()))
}
