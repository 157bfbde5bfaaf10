//! Reads sensors and their noise from small classes of Python.

use dualbody::Model;
use dualbody::sim::{ScanAngles, Sensor, SensorNoise};
use dualbody::spatial::Representation;
use pyo3::prelude::*;

use crate::dynamics::named;
use crate::errors::{OrRaise, value_error};
use crate::kinds::check_kind;

/// The kinds, of the field of the same name.
const KINDS: [&str; 17] = [
    "joint_position",
    "joint_velocity",
    "joint_force",
    "gyro",
    "accelerometer",
    "magnetometer",
    "frame_pose",
    "frame_velocity",
    "frame_acceleration",
    "wrench",
    "touch",
    "contact_force",
    "range_finder",
    "lidar",
    "center_of_mass",
    "center_of_mass_velocity",
    "momentum",
];

/// A sensor of a model.
pub(super) fn read(model: &Model, name: &str, value: &Bound<'_, PyAny>) -> PyResult<Sensor> {
    check_kind(
        format_args!("sensors[\"{name}\"]"),
        value,
        "sim",
        &["Sensor"],
        "",
    )?;
    let kind: String = value.getattr("kind")?.extract()?;
    let on: Option<String> = value.getattr("on")?.extract()?;
    let missing = || {
        value_error(format_args!(
            "sensors[\"{name}\"] is on nothing: on= names its joint, link or frame"
        ))
    };
    let place = || on.as_deref().ok_or_else(missing);
    let joint = || model.find_joint(place()?).or_raise();
    let frame = || model.find_frame(place()?).or_raise();
    let representation = || {
        let given: String = value.getattr("representation")?.extract()?;
        named::<Representation>(model, &given)
    };
    Ok(match kind.as_str() {
        "joint_position" => Sensor::JointPosition(joint()?),
        "joint_velocity" => Sensor::JointVelocity(joint()?),
        "joint_force" => Sensor::JointForce(joint()?),
        "gyro" => Sensor::Gyro(frame()?),
        "accelerometer" => Sensor::Accelerometer(frame()?),
        "magnetometer" => Sensor::Magnetometer {
            frame: frame()?,
            field: value.getattr("field")?.extract()?,
        },
        "frame_pose" => Sensor::FramePose(frame()?),
        "frame_velocity" => Sensor::FrameVelocity {
            frame: frame()?,
            representation: representation()?,
        },
        "frame_acceleration" => Sensor::FrameAcceleration {
            frame: frame()?,
            representation: representation()?,
        },
        "wrench" => Sensor::Wrench(frame()?),
        "touch" => Sensor::Touch(frame()?),
        "contact_force" => Sensor::ContactForce(frame()?),
        "range_finder" => Sensor::RangeFinder {
            frame: frame()?,
            direction: value.getattr("direction")?.extract()?,
            range: value.getattr("range")?.extract()?,
        },
        "lidar" => Sensor::Lidar {
            frame: frame()?,
            horizontal: angles(name, value, "horizontal")?,
            vertical: angles(name, value, "vertical")?,
            range: value.getattr("range")?.extract()?,
        },
        "center_of_mass" => Sensor::CenterOfMass,
        "center_of_mass_velocity" => Sensor::CenterOfMassVelocity,
        "momentum" => Sensor::Momentum,
        _ => {
            return Err(value_error(format_args!(
                "sensors[\"{name}\"] is of the kind \"{kind}\", expected one of {}",
                KINDS.join(", ")
            )));
        }
    })
}

/// Angles of the rays of a lidar: their number, the first and the last.
fn angles(name: &str, value: &Bound<'_, PyAny>, field: &str) -> PyResult<ScanAngles> {
    let given: Result<(u32, f64, f64), _> = value.getattr(field)?.extract();
    let (count, first, last) = given.map_err(|_| {
        value_error(format_args!(
            "sensors[\"{name}\"]: {field} is not a number of rays, the first and the last angle, like (640, -1.5, 1.5)"
        ))
    })?;
    Ok(ScanAngles { count, first, last })
}

/// The imperfections of a sensor.
pub(super) fn noise(name: &str, value: &Bound<'_, PyAny>) -> PyResult<SensorNoise> {
    check_kind(
        format_args!("noise[\"{name}\"]"),
        value,
        "sim",
        &["SensorNoise"],
        "",
    )?;
    let number = |field: &str| value.getattr(field)?.extract();
    Ok(SensorNoise {
        offset: number("offset")?,
        white: number("white")?,
        bias: number("bias")?,
        bias_walk: number("bias_walk")?,
        resolution: number("resolution")?,
        limit: number("limit")?,
        period: number("period")?,
        delay: number("delay")?,
    })
}
