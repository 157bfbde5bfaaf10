//! Sensors of a file as the small classes of Python.

use dualbody::Model;
use dualbody::model::{FrameId, JointId};
use dualbody::sim::{Sensor, SensorNoise};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::value_error;
use crate::model::PyModel;
use crate::python::of_package;
use crate::words::snake;

#[pymethods]
impl PyModel {
    /// Sensors of the file: {name: (sim.Sensor, sim.SensorNoise)}, those that are modelled; empty for a robot that was built in code.
    #[getter]
    fn sensors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        let report = self.report.as_ref().map(|report| &report.get().report);
        for own in report.map_or(&[][..], |report| &report.sensors) {
            if let Some(sensor) = &own.sensor {
                let sensor = written(py, &self.model, sensor)?;
                out.set_item(&own.name, (sensor, written_noise(py, &own.noise)?))?;
            }
        }
        Ok(out)
    }
}

/// A sensor as the class of Python.
fn written<'py>(py: Python<'py>, model: &Model, sensor: &Sensor) -> PyResult<Bound<'py, PyAny>> {
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
        Sensor::Lidar {
            frame,
            horizontal,
            vertical,
            range,
        } => {
            for (field, angles) in [("horizontal", horizontal), ("vertical", vertical)] {
                fields.set_item(field, (angles.count, angles.first, angles.last))?;
            }
            fields.set_item("range", range)?;
            ("lidar", on_frame(frame))
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
    let class = of_package!(py, "sim", "Sensor");
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
    let class = of_package!(py, "sim", "SensorNoise");
    class.call((), Some(&fields))
}
