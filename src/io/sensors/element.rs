//! `<sensor>` of an SDF.

use super::ImportedSensor;
use super::noise::{self, gaussian, magnitude, of_axes};
use crate::error::LoadError;
use crate::io::context::{Context, Node, child, tag};
use crate::io::schema::{Known, check, known};
use crate::io::values::{Elements, Values, any};
use crate::model::{FrameId, Model};
use crate::scalar::MapEach;
use crate::sim::{ScanAngles, Sensor, SensorNoise};
use crate::spatial::Representation;

/// Most rays of a lidar.
const MOST_RAYS: u32 = 1 << 20;

/// Longest range of a ray that has none or an infinite one, m.
const RANGE: f64 = 1e3;

/// The magnetic field of a world that gives none, T, as the SDF says.
const MAGNETIC_FIELD: [f64; 3] = [5.5645e-6, 22.8758e-6, -42.3884e-6];

/// Kinds of sensors with the child that describes them.
const KINDS: [(&str, &str, Known); 9] = [
    ("imu", "imu", content("imu")),
    ("force_torque", "force_torque", content("force_torque")),
    ("contact", "contact", content("contact")),
    ("ray", "ray", content("ray")),
    ("gpu_ray", "ray", content("ray")),
    ("lidar", "lidar", content("lidar")),
    ("gpu_lidar", "lidar", content("lidar")),
    ("magnetometer", "magnetometer", content("magnetometer")),
    ("altimeter", "altimeter", content("altimeter")),
];

const fn content(own: &'static str) -> Known {
    known("name type", "pose update_rate", own)
}

const AXES: Known = known("", "x y z", "");

/// Carrier of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::io) enum Carrier {
    Link,
    Joint,
}

/// A sensor as it is in a file.
#[derive(Clone, Debug)]
pub(in crate::io) struct SensorElement {
    name: String,
    kind: String,
    /// The link or joint.
    pub(in crate::io) object: String,
    /// Empty for a kind that is not modelled.
    parts: Vec<Part>,
}

/// One of the sensors that it becomes.
#[derive(Clone, Copy, Debug)]
struct Part {
    /// End of its name.
    suffix: &'static str,
    quantity: Quantity,
    noise: SensorNoise,
}

#[derive(Clone, Copy, Debug)]
enum Quantity {
    Gyro,
    Accelerometer,
    Wrench,
    ContactForce,
    Range { direction: [f64; 3], range: f64 },
    Scan { angles: [ScanAngles; 2], range: f64 },
    Magnetometer([f64; 3]),
    Pose,
    Velocity,
}

/// Reads a sensor; one that is not modelled is reported.
pub(in crate::io) fn read(
    context: &mut Context<'_>,
    node: Node<'_>,
    carrier: Carrier,
    object: &str,
) -> Result<SensorElement, LoadError> {
    let kind = node.attribute("type").unwrap_or_default();
    let mut out = SensorElement {
        name: node.attribute("name").unwrap_or_default().into(),
        kind: kind.into(),
        object: object.into(),
        parts: Vec::new(),
    };
    let own = KINDS.iter().find(|(name, ..)| *name == kind);
    let Some((_, description, content)) = own else {
        let reason = format!("sensors of the type \"{kind}\" are not modelled");
        context.ignore(node, reason);
        return Ok(out);
    };
    if carrier == Carrier::Joint && kind != "force_torque" {
        context.ignore(
            node,
            format!("a sensor of the type \"{kind}\" is on a link, not on a joint"),
        );
        return Ok(out);
    }
    check(context, node, content)?;
    let rate = magnitude(context, node, "update_rate")?;
    let described = child(node, description);
    out.parts = match *description {
        "imu" => imu(context, described)?,
        "force_torque" => force_torque(context, described)?,
        "contact" => contact(context, described)?,
        "magnetometer" => magnetometer(context, node, described)?,
        "altimeter" => altimeter(context, described)?,
        _ => ray(context, node, described)?,
    };
    let period = if rate > 0.0 { 1.0 / rate } else { 0.0 };
    if period.is_infinite() {
        let reason = "expected a rate whose period is finite";
        return Err(context.malformed_value(node, "update_rate", &rate.to_string(), reason));
    }
    for part in &mut out.parts {
        part.noise.period = period;
    }
    Ok(out)
}

fn one(quantity: Quantity, noise: SensorNoise) -> Vec<Part> {
    vec![part("", quantity, noise)]
}

fn part(suffix: &'static str, quantity: Quantity, noise: SensorNoise) -> Part {
    Part {
        suffix,
        quantity,
        noise,
    }
}

/// The noise of the axes of a child, if there is one.
fn axes_of(
    context: &mut Context<'_>,
    node: Node<'_>,
    name: &str,
) -> Result<SensorNoise, LoadError> {
    match child(node, name) {
        Some(own) => of_axes(context, own, &AXES),
        None => Ok(SensorNoise::default()),
    }
}

fn imu(context: &mut Context<'_>, imu: Option<Node<'_>>) -> Result<Vec<Part>, LoadError> {
    const IMU: Known = known("", "angular_velocity linear_acceleration noise", "");
    /// That before version 1.5.
    const OLD_NOISE: Known = known("", "type rate accel", "");
    let [mut rate, mut acceleration] = [SensorNoise::default(); 2];
    if let Some(imu) = imu {
        check(context, imu, &IMU)?;
        if let Some(old) = child(imu, "noise") {
            check(context, old, &OLD_NOISE)?;
            for (name, noise) in [("rate", &mut rate), ("accel", &mut acceleration)] {
                if let Some(own) = child(old, name) {
                    *noise = gaussian(context, own)?;
                }
            }
        }
        if child(imu, "angular_velocity").is_some() {
            rate = axes_of(context, imu, "angular_velocity")?;
        }
        if child(imu, "linear_acceleration").is_some() {
            acceleration = axes_of(context, imu, "linear_acceleration")?;
        }
    }
    Ok(vec![
        part("/gyro", Quantity::Gyro, rate),
        part("/accelerometer", Quantity::Accelerometer, acceleration),
    ])
}

fn force_torque(context: &mut Context<'_>, own: Option<Node<'_>>) -> Result<Vec<Part>, LoadError> {
    const FORCE_TORQUE: Known = known("", "frame measure_direction force torque", "");
    let Some(own) = own else {
        return Ok(one(Quantity::Wrench, SensorNoise::default()));
    };
    check(context, own, &FORCE_TORQUE)?;
    let text = Elements::value(context, own, "frame")?;
    if let Some(frame) = text.as_deref().filter(|frame| *frame != "sensor") {
        let reason =
            format!("<frame> {frame}: read along the axes of the sensor, about its origin");
        context.warn(own, reason);
    }
    let direction = Elements::value(context, own, "measure_direction")?;
    if direction.as_deref().unwrap_or("child_to_parent") != "parent_to_child" {
        let reason = "read as parent_to_child, the force on the child: of the other sign than child_to_parent";
        context.warn(own, reason);
    }
    let force = axes_of(context, own, "force")?;
    let torque = axes_of(context, own, "torque")?;
    if force != torque {
        let reason = "force and torque have one noise here: that of the force is taken for both";
        context.warn(own, reason);
    }
    Ok(one(Quantity::Wrench, force))
}

fn contact(context: &mut Context<'_>, own: Option<Node<'_>>) -> Result<Vec<Part>, LoadError> {
    const CONTACT: Known = known("", "", "collision topic");
    if let Some(own) = own {
        check(context, own, &CONTACT)?;
        if let Some(collision) = child(own, "collision") {
            context.warn(
                collision,
                "counts the contact of all collisions of the link",
            );
        }
    }
    Ok(one(Quantity::ContactForce, SensorNoise::default()))
}

fn magnetometer(
    context: &mut Context<'_>,
    node: Node<'_>,
    own: Option<Node<'_>>,
) -> Result<Vec<Part>, LoadError> {
    let noise = match own {
        Some(own) => of_axes(context, own, &AXES)?,
        None => SensorNoise::default(),
    };
    let mut around = node.ancestors().filter(|node| tag(*node) == "world");
    let field = match around.find(|world| child(*world, "magnetic_field").is_some()) {
        Some(world) => Elements::numbers(context, world, "magnetic_field")?,
        None => None,
    };
    let field = field.unwrap_or(MAGNETIC_FIELD);
    Ok(one(Quantity::Magnetometer(field), noise))
}

fn altimeter(context: &mut Context<'_>, own: Option<Node<'_>>) -> Result<Vec<Part>, LoadError> {
    const ALTIMETER: Known = known("", "vertical_position vertical_velocity", "");
    const NOISY: Known = known("", "noise", "");
    let mut noises = [SensorNoise::default(); 2];
    if let Some(own) = own {
        check(context, own, &ALTIMETER)?;
        for (name, noise) in ["vertical_position", "vertical_velocity"]
            .iter()
            .zip(&mut noises)
        {
            if let Some(own) = child(own, name) {
                check(context, own, &NOISY)?;
                *noise = noise::of(context, own)?;
            }
        }
        let reason = "read with all numbers of pose and velocity: z of these is that of the world, not above the start";
        context.warn(own, reason);
    }
    let [position, velocity] = noises;
    Ok(vec![
        part("/position", Quantity::Pose, position),
        part("/velocity", Quantity::Velocity, velocity),
    ])
}

/// A range finder, or a lidar of several rays.
fn ray(
    context: &mut Context<'_>,
    node: Node<'_>,
    own: Option<Node<'_>>,
) -> Result<Vec<Part>, LoadError> {
    const RAY: Known = known("", "scan range noise", "");
    const SCAN: Known = known("", "horizontal vertical", "");
    const SPREAD: Known = known("", "samples resolution min_angle max_angle", "");
    let mut angles = [ScanAngles::ONE; 2];
    let (mut range, mut noise) = (RANGE, SensorNoise::default());
    if let Some(own) = own {
        check(context, own, &RAY)?;
        if let Some(scan) = child(own, "scan") {
            check(context, scan, &SCAN)?;
            for (name, angle) in ["horizontal", "vertical"].iter().zip(&mut angles) {
                if let Some(spread) = child(scan, name) {
                    check(context, spread, &SPREAD)?;
                    *angle = spread_of(context, spread)?;
                }
            }
        }
        noise = noise::of(context, own)?;
        if let Some(limits) = child(own, "range") {
            range = range_of(context, limits, &mut noise)?;
        }
    }
    let rays = u64::from(angles[0].count) * u64::from(angles[1].count);
    if rays > u64::from(MOST_RAYS) {
        let reason = format!("has {rays} rays, more than {MOST_RAYS}: not used");
        context.ignore(node, reason);
        return Ok(Vec::new());
    }
    if rays > 1 {
        return Ok(one(Quantity::Scan { angles, range }, noise));
    }
    let [(sin_h, cos_h), (sin_v, cos_v)] = angles.map_each(|own| own.first.sin_cos());
    let direction = [cos_v * cos_h, cos_v * sin_h, sin_v];
    Ok(one(Quantity::Range { direction, range }, noise))
}

/// Angles of rays side by side.
fn spread_of(context: &mut Context<'_>, node: Node<'_>) -> Result<ScanAngles, LoadError> {
    let samples = magnitude(context, node, "samples")?;
    let resolution = Elements::number(context, node, "resolution")?.unwrap_or(1.0);
    let first = Elements::number(context, node, "min_angle")?.unwrap_or(0.0);
    let last = Elements::number(context, node, "max_angle")?.unwrap_or(0.0);
    // Too many are those of the largest number; without samples there is one.
    let count = (samples * resolution).round().max(1.0) as u32;
    Ok(ScanAngles { count, first, last })
}

/// The largest distance; the resolution goes to the noise.
fn range_of(
    context: &mut Context<'_>,
    limits: Node<'_>,
    noise: &mut SensorNoise,
) -> Result<f64, LoadError> {
    const LIMITS: Known = known("", "min max resolution", "");
    check(context, limits, &LIMITS)?;
    if magnitude(context, limits, "min")? > 0.0 {
        context.ignore(limits, "<min>: shorter distances are read as they are");
    }
    if noise.resolution == 0.0 {
        noise.resolution = magnitude(context, limits, "resolution")?;
    }
    let Some(text) = Elements::value(context, limits, "max")? else {
        return Ok(RANGE);
    };
    let [range] = any(context, limits, "max", &text)?;
    match range > 0.0 {
        true if range.is_finite() => Ok(range),
        true => Ok(RANGE),
        false => Err(context.malformed_value(limits, "max", &text, "expected a positive number")),
    }
}

impl SensorElement {
    /// A name for the frame of the sensor.
    pub(in crate::io) fn frame_name(&self) -> String {
        format!("{}/{}", self.object, self.name)
    }

    /// Whether it is modelled.
    pub(in crate::io) fn is_modelled(&self) -> bool {
        !self.parts.is_empty()
    }

    /// The sensors of a model that it becomes, and itself if it is not modelled.
    ///
    /// * `frame` – name of its frame
    pub(in crate::io) fn in_model(&self, model: &Model, frame: &str) -> Vec<ImportedSensor> {
        let made = |name: String, sensor, noise| ImportedSensor {
            name,
            kind: self.kind.clone(),
            object: self.object.clone(),
            sensor,
            noise,
        };
        let frame = model.frame(frame).filter(|_| self.is_modelled());
        let Some(frame) = frame else {
            return vec![made(self.name.clone(), None, SensorNoise::default())];
        };
        let parts = self.parts.iter();
        let part = |part: &Part| {
            let name = match self.name.is_empty() {
                true => String::new(),
                false => format!("{}{}", self.name, part.suffix),
            };
            made(name, Some(part.quantity.on(frame)), part.noise)
        };
        parts.map(part).collect()
    }
}

impl Quantity {
    fn on(self, frame: FrameId) -> Sensor {
        match self {
            Self::Gyro => Sensor::Gyro(frame),
            Self::Accelerometer => Sensor::Accelerometer(frame),
            Self::Wrench => Sensor::Wrench(frame),
            Self::ContactForce => Sensor::ContactForce(frame),
            Self::Range { direction, range } => Sensor::RangeFinder {
                frame,
                direction,
                range,
            },
            Self::Scan { angles, range } => Sensor::Lidar {
                frame,
                horizontal: angles[0],
                vertical: angles[1],
                range,
            },
            Self::Magnetometer(field) => Sensor::Magnetometer { frame, field },
            Self::Pose => Sensor::FramePose(frame),
            Self::Velocity => Sensor::FrameVelocity {
                frame,
                representation: Representation::Mixed,
            },
        }
    }
}
