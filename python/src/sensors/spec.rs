//! Sensors and their noise as the small classes of Python: read, and written for sensors of a file.

use dualbody::sim::{ScanAngles, Sensor, SensorNoise};
use dualbody::spatial::Representation;

use crate::dynamics::named;
use crate::prelude::*;

/// A `sim.Sensor` of a robot, by its name.
struct Given<'a, 'py> {
    model: &'a Model,
    name: &'a str,
    value: &'a Bound<'py, PyAny>,
}

/// A field of a sensor, under one name in Rust and in Python.
trait Field: Sized {
    fn read(given: &Given<'_, '_>, field: &str) -> PyResult<Self>;
    fn write(self, field: &str, out: &Bound<'_, PyDict>) -> PyResult<()>;
}

macro_rules! numbers {
    ($($kind:ty),*) => { $(impl Field for $kind {
        fn read(given: &Given<'_, '_>, field: &str) -> PyResult<Self> {
            attribute(given.value, field)
        }

        fn write(self, field: &str, out: &Bound<'_, PyDict>) -> PyResult<()> {
            out.set_item(field, self)
        }
    })* };
}
numbers!(f64, [f64; 3]);

impl Field for Representation {
    fn read(given: &Given<'_, '_>, field: &str) -> PyResult<Self> {
        named(given.model, &attribute::<String>(given.value, field)?)
    }

    fn write(self, field: &str, out: &Bound<'_, PyDict>) -> PyResult<()> {
        out.set_item(field, snake(self))
    }
}

impl Field for ScanAngles {
    fn read(given: &Given<'_, '_>, field: &str) -> PyResult<Self> {
        let wrong = |_| {
            invalid!(
                "sensors[\"{}\"]: {field} is not a number of rays, the first and the last angle, like (640, -1.5, 1.5)",
                given.name
            )
        };
        let (count, first, last) = attribute(given.value, field).map_err(wrong)?;
        Ok(Self { count, first, last })
    }

    fn write(self, field: &str, out: &Bound<'_, PyDict>) -> PyResult<()> {
        out.set_item(field, (self.count, self.first, self.last))
    }
}

impl Given<'_, '_> {
    /// Name of the joint, link or frame that the sensor is on.
    fn on(&self) -> PyResult<String> {
        let missing = || {
            invalid!(
                "sensors[\"{}\"] is on nothing: on= names its joint, link or frame",
                self.name
            )
        };
        attribute::<Option<String>>(self.value, "on")?.ok_or_else(missing)
    }
}

/// All kinds, by name: those on a joint, those on a link or frame, those with fields besides, those on nothing.
macro_rules! kinds {
    (
        joint { $($joint:literal: $of_joint:ident),* }
        frame { $($frame:literal: $of_frame:ident),* }
        with { $($with:literal: $of:ident { $($field:ident),* }),* }
        alone { $($alone:literal: $whole:ident),* }
    ) => {
        const KINDS: &[&str] = &[$($joint,)* $($frame,)* $($with,)* $($alone),*];

        /// The sensor of a kind; `None` if there is no such kind.
        fn of_kind(kind: &str, given: &Given<'_, '_>) -> PyResult<Option<Sensor>> {
            Ok(Some(match kind {
                $($joint => Sensor::$of_joint(given.model.find_joint(&given.on()?).or_raise()?),)*
                $($frame => Sensor::$of_frame(named(given.model, &given.on()?)?),)*
                $($with => Sensor::$of { frame: named(given.model, &given.on()?)?, $($field: Field::read(given, stringify!($field))?),* },)*
                $($alone => Sensor::$whole,)*
                _ => return Ok(None),
            }))
        }

        /// Kind and place of a sensor, and its fields; `None` for one that Python does not have.
        fn parts<'m>(sensor: &Sensor, model: &'m Model, out: &Bound<'_, PyDict>) -> PyResult<Option<(&'static str, Option<&'m str>)>> {
            Ok(Some(match *sensor {
                $(Sensor::$of_joint(joint) => ($joint, Some(&model.joints()[joint.0].name)),)*
                $(Sensor::$of_frame(frame) => ($frame, Some(&model.frames()[frame.0].name)),)*
                $(Sensor::$of { frame, $($field),* } => {
                    $($field.write(stringify!($field), out)?;)*
                    ($with, Some(&model.frames()[frame.0].name))
                })*
                $(Sensor::$whole => ($alone, None),)*
                _ => return Ok(None),
            }))
        }
    };
}
kinds! {
    joint { "joint_position": JointPosition, "joint_velocity": JointVelocity, "joint_force": JointForce }
    frame { "gyro": Gyro, "accelerometer": Accelerometer, "frame_pose": FramePose, "wrench": Wrench, "touch": Touch, "contact_force": ContactForce }
    with {
        "magnetometer": Magnetometer { field },
        "frame_velocity": FrameVelocity { representation },
        "frame_acceleration": FrameAcceleration { representation },
        "range_finder": RangeFinder { direction, range },
        "lidar": Lidar { horizontal, vertical, range }
    }
    alone { "center_of_mass": CenterOfMass, "center_of_mass_velocity": CenterOfMassVelocity, "momentum": Momentum }
}

/// A sensor of a model.
pub(super) fn read(model: &Model, name: &str, value: &Bound<'_, PyAny>) -> PyResult<Sensor> {
    let place = format_args!("sensors[\"{name}\"]");
    check_kind(place, value, "sim", &["Sensor"], "")?;
    let kind: String = attribute(value, "kind")?;
    let given = Given { model, name, value };
    of_kind(&kind, &given)?.ok_or_else(|| {
        invalid!(
            "sensors[\"{name}\"] is of the kind \"{kind}\", expected one of {}",
            KINDS.join(", ")
        )
    })
}

/// Imperfections, whose fields have one name in Rust and in Python.
macro_rules! noise {
    ($($field:ident),*) => {
        /// The imperfections of a sensor.
        pub(super) fn noise(name: &str, value: &Bound<'_, PyAny>) -> PyResult<SensorNoise> {
            check_kind(format_args!("noise[\"{name}\"]"), value, "sim", &["SensorNoise"], "")?;
            Ok(crate::kinds::fields!(value => SensorNoise { $($field),* }))
        }

        /// Imperfections as the class of Python.
        fn written_noise<'py>(py: Python<'py>, noise: &SensorNoise) -> PyResult<Bound<'py, PyAny>> {
            let fields = PyDict::new(py);
            $(fields.set_item(stringify!($field), noise.$field)?;)*
            of_package!(py, "sim", "SensorNoise").call((), Some(&fields))
        }
    };
}
noise!(
    offset, white, bias, bias_walk, resolution, limit, period, delay
);

#[pymethods]
impl PyModel {
    /// Sensors of the file: {name: (sim.Sensor, sim.SensorNoise)}, those that are modelled; empty for a robot that was built in code.
    #[getter]
    fn sensors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        let report = self.report.as_ref().map(|report| &report.get().report);
        for own in report.map_or(&[][..], |report| &report.sensors) {
            let Some(sensor) = &own.sensor else {
                continue;
            };
            let fields = PyDict::new(py);
            let missing = || {
                invalid!("a sensor of the file is of a kind that Python does not have: {sensor:?}")
            };
            let place = parts(sensor, &self.model, &fields)?.ok_or_else(missing)?;
            let sensor = of_package!(py, "sim", "Sensor").call(place, Some(&fields))?;
            out.set_item(&own.name, (sensor, written_noise(py, &own.noise)?))?;
        }
        Ok(out)
    }
}
