//! Motors.

use dualbody::sim::{
    Actuation, Actuator, CoulombFriction, Interval, PositionLimits, Servo, TorqueSpeed,
    VelocityLimit,
};

use super::law::normal_of;
use crate::prelude::*;

pub(crate) fn actuation_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<Actuation> {
    let name: Option<String> = value.extract().ok();
    let base = match &name {
        Some(base) => base.clone(),
        None => {
            let hint = " (or \"ideal\", \"model\")";
            check_kind("actuation", value, "sim", &["Actuation"], hint)?;
            attribute(value, "base")?
        }
    };
    let mut actuation = match base.as_str() {
        "ideal" => Actuation::ideal(model),
        "model" => Actuation::from_model(model),
        _ => {
            refuse!("actuation is \"{base}\", not \"ideal\" or \"model\"");
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
    let torque_speed = attribute::<Option<(f64, f64, f64)>>(value, "torque_speed")?;
    let friction = value.getattr("friction")?;
    let friction = match friction.extract::<Option<f64>>() {
        Ok(force) => force.map(CoulombFriction::exact),
        Err(_) => {
            let (force, slip_velocity) = friction.extract()?;
            Some(CoulombFriction::smoothed(force, slip_velocity))
        }
    };
    let velocity = attribute::<Option<(f64, f64)>>(value, "velocity")?;
    let position =
        attribute::<Option<(Option<f64>, Option<f64>, Bound<'_, PyAny>)>>(value, "position")?;
    Ok(Actuator {
        servo: servo_of(value)?,
        torque_speed: torque_speed.map(|(torque, threshold, maximum)| TorqueSpeed {
            torque,
            threshold,
            maximum,
        }),
        effort: attribute(value, "effort")?,
        friction,
        position: position.map(limits_of).transpose()?,
        velocity: velocity.map(|(speed, damping)| VelocityLimit { speed, damping }),
    })
}

/// The servo that a part of a robot has, with its ranges.
pub(super) fn servo_of(value: &Bound<'_, PyAny>) -> PyResult<Option<Servo>> {
    let range = |name: &str| -> PyResult<Option<Interval>> {
        let ends: Option<(f64, f64)> = attribute(value, name)?;
        Ok(ends.map(|(lower, upper)| Interval { lower, upper }))
    };
    let servo: Option<[f64; 5]> = attribute(value, "servo")?;
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
