//! Identified robots.

use dualbody::identify::Robot;

use super::data::{data_of, samples};
use super::regressor::{friction_of, map_motion, model_of};
use crate::prelude::*;

/// An identified robot as Python has it: all parameters of the model, dry friction, offsets.
pub(super) type RobotNumbers<'py> = [Bound<'py, PyAny>; 3];

pub(super) fn numbers_of<'py>(py: Python<'py>, robot: &Robot) -> RobotNumbers<'py> {
    let parameters = robot.model.parameters().as_slice().to_vec();
    let all = [
        parameters,
        robot.dry_friction.clone(),
        robot.offsets.clone(),
    ];
    all.map(|x| vector(py, &x))
}

pub(super) fn robot_of(value: &Bound<'_, PyAny>) -> PyResult<Robot> {
    let model = (*model_of(value)?.get().model).clone();
    let all = |name: &'static str| read_vector(name, &value.getattr(name)?, Some(model.nv()));
    Ok(Robot {
        dry_friction: all("dry_friction")?,
        offsets: all("offsets")?,
        shape: friction_of(attribute(value, "shape")?)?,
        model,
    })
}

functions! {
    /// Joint forces that a robot needs for a motion, (…, nv).
    fn _predict(robot, q, v, a) -> PyResult<Array<'py>> {
        let own = robot_of(robot)?;
        let tail = [own.model.nv()];
        map_motion(&model_of(robot)?, [q, v, a], &tail, &|[q, v, a], out| {
            out.copy_from_slice(own.predict(q, v, a).as_slice());
        })
    }

    /// Compares predicted with measured forces: errors (rms, mean, largest, rms of the measured) along each coordinate, forces (samples, nv) of each segment.
    fn _validate(robot, data) -> PyResult<(Vec<[f64; 4]>, Vec<Array<'py>>)> {
        let (own, data) = (robot_of(robot)?, data_of(data)?);
        let found = guarded(|| own.validate(&data))?.or_raise()?;
        let errors = found.coordinates.iter();
        let errors = errors.map(|own| [own.rms, own.mean, own.largest, own.measured]);
        let predicted = found.predicted.iter().map(|m| samples(robot.py(), m));
        Ok((errors.collect(), predicted.collect()))
    }
}
