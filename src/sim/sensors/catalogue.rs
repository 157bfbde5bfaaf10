//! The list of sensors of a robot, with the layout of their reading vector.

use std::ops::Range;

use super::held_links::{HeldLinks, carrying_link};
use super::ray::Shape;
use super::sensor::{Channel, Sensor};
use crate::dynamics::to_world;
use crate::error::UnknownName;
use crate::model::{FrameId, Model, Structure};
use crate::numbers::Domain;
use crate::scalar::Scalar;
use crate::sim::simulator::Simulator;

/// The sensors of a robot; all readings form one vector.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, State, model::samples, sim::{Sensor, Sensors}};
///
/// // A pendulum that hangs at rest: its accelerometer, at the pivot, reads 9.81 m/s² upward.
/// let simulator = Simulator::new(samples::pendulum());
/// let model = simulator.model();
/// let sensors = Sensors::new(model, [
///     ("encoder", Sensor::JointPosition(model.find_joint("pivot")?)),
///     ("imu", Sensor::Accelerometer(model.find_frame("rod")?)),
/// ]);
/// assert_eq!(sensors.names(), ["encoder", "imu.x", "imu.y", "imu.z"]);
/// let y = sensors.read(&simulator, &State::new(&[0.0], &[0.0]), &[0.0]);
/// assert!((y[sensors.range("imu").unwrap().end - 1] - 9.81).abs() < 1e-12);
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sensors {
    /// Name of the robot.
    model: String,
    structure: Structure,
    pub(super) all: Vec<Placed>,
    channels: Vec<Channel>,
    /// Bodies whose motion is needed, ascending, each with all of its ancestors.
    pub(super) bodies: Vec<usize>,
    /// Shapes that range finders see.
    pub(super) shapes: Vec<Shape>,
    /// Whether forces are needed that joints transmit, or those of contact.
    pub(super) takes_transmitted_forces: bool,
}

/// A sensor with its place in the vector.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub(super) name: String,
    pub(super) sensor: Sensor,
    pub(super) range: Range<usize>,
    /// The links that a force–torque sensor holds; `None` for others.
    pub(super) held: Option<HeldLinks>,
    /// The link that carries the frame of a sensor of forces; `None` for others.
    pub(super) link: Option<FrameId>,
}

impl Sensors {
    /// Makes the sensors of a model, each with a name, in the order of their readings. They fit the robot and its variants of equal structure.
    ///
    /// # Panics
    /// If two have the same name; if the model does not have a joint or frame; if a direction is zero, or a range or a field is not finite.
    pub fn new<N: Into<String>>(
        model: &Model,
        sensors: impl IntoIterator<Item = (N, Sensor)>,
    ) -> Self {
        let mut out = Self {
            model: model.name().to_owned(),
            structure: model.structure(),
            all: Vec::new(),
            channels: Vec::new(),
            bodies: Vec::new(),
            shapes: Vec::new(),
            takes_transmitted_forces: false,
        };
        for (name, sensor) in sensors {
            out.add(model, name.into(), sensor);
        }
        out.find_bodies(model);
        if out.has(|sensor| matches!(sensor, Sensor::RangeFinder { .. })) {
            out.shapes = Shape::of_model(model);
        }
        out
    }

    fn add(&mut self, model: &Model, name: String, sensor: Sensor) {
        assert!(
            self.all.iter().all(|other| other.name != name),
            "two sensors of \"{}\" have the name \"{name}\": give each its own",
            model.name()
        );
        check(model, &sensor);
        let channels = sensor.channels(&name, model);
        let first = self.channels.len();
        let link = match sensor {
            Sensor::Wrench(frame) | Sensor::Touch(frame) | Sensor::ContactForce(frame) => {
                Some(carrying_link(model, frame))
            }
            _ => None,
        };
        let is_wrench = matches!(sensor, Sensor::Wrench(_));
        let held = link.filter(|_| is_wrench);
        let held = held.map(|link| HeldLinks::new(model, link));
        self.all.push(Placed {
            name,
            sensor,
            range: first..first + channels.len(),
            held,
            link,
        });
        self.channels.extend(channels);
        self.takes_transmitted_forces |= sensor.takes_transmitted_forces();
    }

    fn has(&self, kind: impl Fn(&Sensor) -> bool) -> bool {
        self.all.iter().any(|placed| kind(&placed.sensor))
    }

    /// Marks the bodies whose motion is needed. Shapes may be on any body.
    fn find_bodies(&mut self, model: &Model) {
        let all = self.has(|sensor| {
            sensor.takes_all_bodies() || matches!(sensor, Sensor::RangeFinder { .. })
        });
        let mut needed = vec![all; model.n_bodies()];
        for frame in self.all.iter().filter_map(|placed| placed.sensor.frame()) {
            let carriers = to_world(model, model.frames()[frame.0].body);
            carriers.for_each(|(id, _)| needed[id.0] = true);
        }
        self.bodies = (0..model.n_bodies()).filter(|&i| needed[i]).collect();
    }

    /// Number of values read.
    pub fn len(&self) -> usize {
        self.channels.len()
    }

    /// Whether there are no readings.
    pub fn is_empty(&self) -> bool {
        self.channels.is_empty()
    }

    /// Name of each reading: that of its sensor, with `.x`, `.qw`, `.fx` and so on if the sensor has several readings.
    pub fn names(&self) -> Vec<&str> {
        let names = self.channels.iter();
        names.map(|channel| channel.name.as_str()).collect()
    }

    /// Unit of each reading; empty for dimensionless readings.
    pub fn units(&self) -> Vec<&'static str> {
        self.channels.iter().map(|channel| channel.unit).collect()
    }

    /// Range of a sensor's readings in the vector; `None` if there is no sensor of this name.
    pub fn range(&self, name: &str) -> Option<Range<usize>> {
        let found = self.all.iter().find(|placed| placed.name == name);
        found.map(|placed| placed.range.clone())
    }

    /// [`range`](Self::range), with an error that lists the names that there are.
    pub(super) fn find(&self, name: &str) -> Result<Range<usize>, UnknownName> {
        self.range(name).ok_or_else(|| UnknownName {
            model: self.model.clone(),
            element: "sensor".into(),
            name: name.into(),
            known: self.all.iter().map(|placed| placed.name.clone()).collect(),
        })
    }

    /// Refuses another robot, and memory of another size.
    pub(super) fn check<P: Scalar, T>(&self, simulator: &Simulator<P>, out: &[T]) {
        let model = simulator.model();
        assert!(
            model.structure() == self.structure,
            "the sensors belong to another robot than \"{}\"",
            model.name()
        );
        assert_eq!(out.len(), self.len(), "the sensors read so many numbers");
    }
}

/// Refuses what is not of the model, and numbers out of their domain.
fn check(model: &Model, sensor: &Sensor) {
    if let Sensor::JointPosition(joint) | Sensor::JointVelocity(joint) | Sensor::JointForce(joint) =
        sensor
    {
        model.joint_body(*joint);
    }
    if let Some(frame) = sensor.frame() {
        model.frame_of(frame);
    }
    match sensor {
        Sensor::Magnetometer { field, .. } => {
            (field.iter()).for_each(|&x| Domain::Finite.check("field of a magnetometer", x));
        }
        Sensor::RangeFinder {
            direction, range, ..
        } => {
            Domain::Positive.check("range of a range finder", *range);
            let length = direction.iter().map(|x| x * x).sum::<f64>();
            Domain::Positive.check("square of the direction of a range finder", length);
        }
        _ => {}
    }
}
