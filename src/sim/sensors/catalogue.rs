//! The list of sensors of a robot, with the layout of their reading vector.

use std::ops::Range;

use super::held_links::{HeldLinks, carrying_link};
use super::needs::Needs;
use super::ray::Shape;
use super::scan::{self, ScanAngles};
use super::sensor::{Channel, Sensor};
use crate::contact::ShapeWithoutPoints;
use crate::error::UnknownName;
use crate::memory;
use crate::model::manifold::{q_range, v_range};
use crate::model::{FrameId, Model, Structure};
use crate::nested::IntoNested;
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
    /// Encoders of joints that follow no other, as coordinates q and v with their places among the readings.
    pub(super) encoders: [Vec<Encoder>; 2],
    /// The other sensors, as indices.
    pub(super) others: Vec<usize>,
    channels: Vec<Channel>,
    /// The bodies whose motion is taken.
    pub(super) needs: Needs,
    /// The same for simulators with forces on frames or constraints: forces of joints take the poses of all bodies there.
    pub(super) needs_with_forces: Needs,
    /// Shapes that range finders see.
    pub(super) shapes: Vec<Shape>,
    missing: Vec<ShapeWithoutPoints>,
}

/// Memory of a reading with its name, bytes.
const CHANNEL_BYTES: usize = 64;

/// A coordinate that is a reading as it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encoder {
    pub(super) coordinate: usize,
    pub(super) reading: usize,
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
    /// For range finders, reads each mesh file of collision shapes once (with the feature `formats`); [`missing_shapes`](Self::missing_shapes) lists the shapes that
    /// they do not see.
    ///
    /// # Panics
    /// If two have the same name; if the model does not have a joint or frame; if a direction is zero, or a range, an angle or a field is not finite; if a scan
    /// has no rays, or more than memory.
    pub fn new<N: Into<String>>(
        model: &Model,
        sensors: impl IntoIterator<Item = (N, Sensor)>,
    ) -> Self {
        let mut out = Self {
            model: model.name().to_owned(),
            structure: model.structure(),
            all: Vec::new(),
            encoders: [Vec::new(), Vec::new()],
            others: Vec::new(),
            channels: Vec::new(),
            needs: Needs::default(),
            needs_with_forces: Needs::default(),
            shapes: Vec::new(),
            missing: Vec::new(),
        };
        for (name, sensor) in sensors {
            out.add(model, name.into(), sensor);
        }
        let all = out.all.iter().map(|own| (&own.sensor, own.held.as_ref()));
        out.needs = Needs::new(model, all);
        out.needs_with_forces = match out.needs.loaded.is_empty() {
            true => out.needs.clone(),
            false => out.needs.with_all_placed(model.n_bodies()),
        };
        if out.has(|own| matches!(own, Sensor::RangeFinder { .. } | Sensor::Lidar { .. })) {
            out.shapes = Shape::of_model(model, &mut out.missing);
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
        if !self.add_encoder(model, &sensor, first) {
            self.others.push(self.all.len());
        }
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
    }

    /// Adds the coordinates of an encoder, and returns whether the sensor is one that shows them as they are.
    ///
    /// * `first` – place of its first reading
    fn add_encoder(&mut self, model: &Model, sensor: &Sensor, first: usize) -> bool {
        let (joint, kind) = match *sensor {
            Sensor::JointPosition(joint) => (joint, 0),
            Sensor::JointVelocity(joint) => (joint, 1),
            _ => return false,
        };
        let bodies = || model.joint_bodies(joint).map(|id| model.body(id));
        if bodies().any(|body| body.coupling.is_some()) {
            return false;
        }
        let coordinates = bodies().nested(|body| [q_range(body), v_range(body)][kind].clone());
        let encoders = coordinates
            .zip(first..)
            .map(|(coordinate, reading)| Encoder {
                coordinate,
                reading,
            });
        self.encoders[kind].extend(encoders);
        true
    }

    /// Whether any reads a force.
    pub(crate) fn read_forces(&self) -> bool {
        self.has(|own| {
            matches!(
                own,
                Sensor::JointForce(_)
                    | Sensor::Wrench(_)
                    | Sensor::Touch(_)
                    | Sensor::ContactForce(_)
            )
        })
    }

    fn has(&self, kind: impl Fn(&Sensor) -> bool) -> bool {
        self.all.iter().any(|placed| kind(&placed.sensor))
    }

    /// Number of values read.
    pub fn len(&self) -> usize {
        self.channels.len()
    }

    /// Whether there are no readings.
    pub fn is_empty(&self) -> bool {
        self.channels.is_empty()
    }

    /// The collision shapes that range finders do not see, with the reason; empty without range finders.
    pub fn missing_shapes(&self) -> &[ShapeWithoutPoints] {
        &self.missing
    }

    /// Name of each reading: that of its sensor, with `.x`, `.qw`, `.fx` and so on if the sensor has several readings, `.0`, `.1` for those of a lidar.
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
        assert_eq!(
            out.len(),
            self.len(),
            "length of the readings, given and of the sensors"
        );
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
        Sensor::Lidar {
            horizontal,
            vertical,
            range,
            ..
        } => {
            Domain::Positive.check("range of a lidar", *range);
            [horizontal, vertical]
                .into_iter()
                .for_each(ScanAngles::check);
            let bytes = scan::count(*horizontal, *vertical).saturating_mul(CHANNEL_BYTES);
            memory::granted(memory::check("readings of a lidar", bytes));
        }
        _ => {}
    }
}
