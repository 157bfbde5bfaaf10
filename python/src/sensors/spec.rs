//! Reads sensors and their noise from small classes of Python.

use dualbody::Model;
use dualbody::model::{FrameId, JointId};
use dualbody::sim::{Sensor, SensorNoise};
use dualbody::spatial::Representation;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::dynamics::named;
use crate::errors::{OrRaise, value_error};
use crate::kinds::check_kind;
use crate::model::PyImportReport;
use crate::words::snake;

/// The kinds, of the field of the same name.
const KINDS: [&str; 16] = [
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

/// The sensors of a file, by name, with their imperfections.
pub(crate) fn sensors_of_file<'py>(
    py: Python<'py>,
    model: &Model,
    report: Option<&Py<PyImportReport>>,
) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let imported = report.map_or(&[][..], |report| &report.get().report.sensors);
    for own in imported {
        if let Some(sensor) = &own.sensor {
            let pair = (written(py, model, sensor)?, written_noise(py, &own.noise)?);
            out.set_item(&own.name, pair)?;
        }
    }
    Ok(out)
}

/// A sensor as the class of Python.
fn written<'py>(
    py: Python<'py>,
    model: &Model,
    sensor: &Sensor,
) -> PyResult<Bound<'py, PyAny>> {
    let fields = PyDict::new(py);
    let on_joint = |id: JointId| Some(model.joints()[id.0].name.as_str());
    let on_frame = |id: FrameId| Some(model.frames()[id.0].name.as_str());
    let (kind, on) = match *sensor {
        Sensor::JointPosition(joint) => ("joint_position", on_joint(joint)),
        Sensor::JointVelocity(joint) => ("joint_velocity", on_joint(joint)),
        Sensor::JointForce(joint) => ("joint_force", on_joint(joint)),
        Sensor::Gyro(frame) => ("gyro", on_frame(frame)),
        Sensor::Accelerometer(frame) => ("accelerometer", on_frame(frame)),
        Sensor::Magnetometer { frame, field } => {
            fields.set_item("field", field)?;
            ("magnetometer", on_frame(frame))
        }
        Sensor::FramePose(frame) => ("frame_pose", on_frame(frame)),
        Sensor::FrameVelocity {
            frame,
            representation,
        } => {
            fields.set_item("representation", snake(representation))?;
            ("frame_velocity", on_frame(frame))
        }
        Sensor::FrameAcceleration {
            frame,
            representation,
        } => {
            fields.set_item("representation", snake(representation))?;
            ("frame_acceleration", on_frame(frame))
        }
        Sensor::Wrench(frame) => ("wrench", on_frame(frame)),
        Sensor::Touch(frame) => ("touch", on_frame(frame)),
        Sensor::ContactForce(frame) => ("contact_force", on_frame(frame)),
        Sensor::RangeFinder {
            frame,
            direction,
            range,
        } => {
            fields.set_item("direction", direction)?;
            fields.set_item("range", range)?;
            ("range_finder", on_frame(frame))
        }
        Sensor::CenterOfMass => ("center_of_mass", None),
        Sensor::CenterOfMassVelocity => ("center_of_mass_velocity", None),
        Sensor::Momentum => ("momentum", None),
        _ => {
            return Err(value_error(format_args!(
                "a sensor of the file is of a kind that Python does not have: {sensor:?}"
            )));
        }
    };
    let class = py.import("dualbody.sim")?.getattr("Sensor")?;
    class.call((kind, on), Some(&fields))
}

/// Imperfections as the class of Python.
fn written_noise<'py>(py: Python<'py>, noise: &SensorNoise) -> PyResult<Bound<'py, PyAny>> {
    let fields = PyDict::new(py);
    for (name, value) in [
        ("offset", noise.offset),
        ("white", noise.white),
        ("bias", noise.bias),
        ("bias_walk", noise.bias_walk),
        ("resolution", noise.resolution),
        ("limit", noise.limit),
        ("period", noise.period),
        ("delay", noise.delay),
    ] {
        fields.set_item(name, value)?;
    }
    let class = py.import("dualbody.sim")?.getattr("SensorNoise")?;
    class.call((), Some(&fields))
}
