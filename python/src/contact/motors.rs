//! Motors.

use dualbody::Model;
use dualbody::sim::{
    Actuation, Actuator, CoulombFriction, Interval, PositionLimits, Servo, TorqueSpeed,
    VelocityLimit,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::law::normal_of;
use crate::errors::{OrRaise, value_error};
use crate::kinds::check_kind;

pub(crate) fn actuation_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<Actuation> {
    let name: Option<String> = value.extract().ok();
    let base = match &name {
        Some(base) => base.clone(),
        None => {
            let hint = " (or \"ideal\", \"model\")";
            check_kind("actuation", value, "sim", &["Actuation"], hint)?;
            value.getattr("base")?.extract()?
        }
    };
    let mut actuation = match base.as_str() {
        "ideal" => Actuation::ideal(model),
        "model" => Actuation::from_model(model),
        _ => {
            return Err(value_error(format_args!(
                "actuation is \"{base}\", not \"ideal\" or \"model\""
            )));
        }
    };
    if name.is_some() {
        return Ok(actuation);
    }
    for (joint, actuator) in value.getattr("actuators")?.cast::<PyDict>()? {
        let joint: String = joint.extract()?;
        let of = format_args!("actuators[\"{joint}\"]");
        check_kind(of, &actuator, "sim", &["Actuator"], "")?;
        let actuator = actuator_of(&actuator)?;
        actuation = actuation
            .with_actuator(model, &joint, actuator)
            .or_raise()?;
    }
    Ok(actuation)
}

fn actuator_of(value: &Bound<'_, PyAny>) -> PyResult<Actuator> {
    let torque_speed = value
        .getattr("torque_speed")?
        .extract::<Option<(f64, f64, f64)>>()?;
    let friction = value.getattr("friction")?;
    let friction = match friction.extract::<Option<f64>>() {
        Ok(force) => force.map(CoulombFriction::exact),
        Err(_) => {
            let (force, slip_velocity) = friction.extract()?;
            Some(CoulombFriction::smoothed(force, slip_velocity))
        }
    };
    let velocity = value.getattr("velocity")?.extract::<Option<(f64, f64)>>()?;
    let position =
        value
            .getattr("position")?
            .extract::<Option<(Option<f64>, Option<f64>, Bound<'_, PyAny>)>>()?;
    Ok(Actuator {
        servo: servo_of(value)?,
        torque_speed: torque_speed.map(|(torque, threshold, maximum)| TorqueSpeed {
            torque,
            threshold,
            maximum,
        }),
        effort: value.getattr("effort")?.extract()?,
        friction,
        position: position.map(limits_of).transpose()?,
        velocity: velocity.map(|(speed, damping)| VelocityLimit { speed, damping }),
    })
}

/// The servo that a part of a robot has, with its ranges.
pub(super) fn servo_of(value: &Bound<'_, PyAny>) -> PyResult<Option<Servo>> {
    let range = |name: &str| -> PyResult<Option<Interval>> {
        let ends: Option<(f64, f64)> = value.getattr(name)?.extract()?;
        Ok(ends.map(|(lower, upper)| Interval { lower, upper }))
    };
    let servo: Option<[f64; 5]> = value.getattr("servo")?.extract()?;
    let (input_range, force_range) = (range("input_range")?, range("force_range")?);
    Ok(
        servo.map(|[gear, gain, bias, position_gain, velocity_gain]| Servo {
            gear,
            gain,
            bias,
            position_gain,
            velocity_gain,
            input_range,
            force_range,
        }),
    )
}

fn limits_of(
    (lower, upper, stop): (Option<f64>, Option<f64>, Bound<'_, PyAny>),
) -> PyResult<PositionLimits> {
    let stop = normal_of(&stop)?;
    Ok(PositionLimits { lower, upper, stop })
}
