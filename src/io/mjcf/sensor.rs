//! Sensors: those that are modelled here, and the names of the others.

use super::entry::Entry;
use super::joint::Kind;
use super::sections::Names;
use super::walk::Part;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::io::sensors::ImportedSensor;
use crate::model::{FrameId, JointId, Model};
use crate::sim::{Sensor, SensorNoise};
use crate::spatial::Representation;

/// Attributes that name the object of a sensor.
const OBJECTS: [&str; 8] = [
    "joint", "site", "objname", "body", "geom", "actuator", "tendon", "camera",
];

/// Range of a range finder without a cutoff, m: it has none there.
const RANGE: f64 = 1e3;

/// Targets of sensors.
pub(super) struct Target<'a> {
    pub(super) model: &'a Model,
    /// Kinds of joints, and frames of sites.
    pub(super) names: &'a Names,
    /// The magnetic field in the world.
    pub(super) magnetic: [f64; 3],
}

/// Reads a sensor; one that is not modelled is named in the report.
pub(super) fn read(
    part: &Part<'_, '_>,
    at: &Target<'_>,
    context: &mut Context<'_>,
) -> Result<ImportedSensor, LoadError> {
    let entry = part.plain();
    let object = OBJECTS.iter().find_map(|name| entry.text(name));
    let object = object.map(|name| part.naming.of(name)).unwrap_or_default();
    let kind = entry.node.tag();
    let noise = noise(&entry)?;
    at.check(kind, &object, &entry)?;
    let sensor = at.sensor(kind, &object, &entry, noise.limit);
    entry.node.read_all();
    let remark = |reason: &str| format!("{reason}; kept in the scene");
    let sensor = match sensor {
        Ok(sensor) => Some(sensor),
        Err(reason) => {
            context.ignore(&entry.node.place(), remark(reason));
            None
        }
    };
    if kind == "rangefinder" && sensor.is_some() {
        let reason = "sees geoms with contact and the ground, not geoms that are only shown";
        context.warn(&entry.node.place(), reason);
    }
    if kind == "touch" && sensor.is_some() {
        let reason = "counts all contact of the body, not that within the site";
        context.warn(&entry.node.place(), reason);
    }
    Ok(ImportedSensor {
        name: part.name().unwrap_or_default(),
        kind: kind.into(),
        object,
        sensor,
        noise,
    })
}

/// Noise, limit, period and delay.
fn noise(entry: &Entry<'_, '_>) -> Result<SensorNoise, LoadError> {
    let positive = |name: &'static str, x: f64| match x >= 0.0 {
        true => Ok(x),
        false => Err(entry.malformed(name, "is negative")),
    };
    let number = |name: &'static str| positive(name, entry.number(name)?.unwrap_or(0.0));
    let cutoff = number("cutoff")?;
    let [period, _] = entry.some_numbers("interval", [0.0; 2])?;
    Ok(SensorNoise {
        white: number("noise")?,
        limit: if cutoff > 0.0 { cutoff } else { f64::INFINITY },
        period: positive("interval", period)?,
        delay: number("delay")?,
        ..SensorNoise::default()
    })
}

/// A sensor, or the reason why it is not supported.
type Found = Result<Sensor, &'static str>;

/// Reason of a sensor on something that there is not.
const UNKNOWN: &str = "measures at what the model does not have";
/// Reason of a kind that there is not.
const NOT_MODELLED: &str = "is not modelled";

/// The attributes of which a sensor of a kind needs one.
fn needed(kind: &str) -> &'static [&'static str] {
    match kind {
        "rangefinder" => &["site", "camera"],
        "gyro" | "accelerometer" | "magnetometer" | "velocimeter" | "force" | "torque"
        | "touch" | "camprojection" | "insidesite" => &["site"],
        _ if kind.starts_with("joint") || kind.starts_with("ball") => &["joint"],
        _ if kind.starts_with("frame") => &["objname"],
        _ if kind.starts_with("tendon") => &["tendon"],
        _ if kind.starts_with("actuator") => &["actuator"],
        _ if kind.starts_with("subtree") => &["body"],
        _ => &[],
    }
}

impl Target<'_> {
    /// Checks that a sensor states an object, and one of its kind.
    fn check(&self, kind: &str, object: &str, entry: &Entry<'_, '_>) -> Result<(), LoadError> {
        let needed = needed(kind);
        if let [name, ..] = needed
            && needed.iter().all(|name| entry.text(name).is_none())
        {
            return Err(entry.missing(name));
        }
        let of_joint = self.names.kinds.get(object).filter(|_| needed == ["joint"]);
        match of_joint {
            Some(joint) if kind.starts_with("joint") && !joint.is_single() => {
                Err(entry.malformed("joint", "is neither a hinge nor a slide"))
            }
            Some(joint) if kind.starts_with("ball") && *joint != Kind::Ball => {
                Err(entry.malformed("joint", "is not a ball joint"))
            }
            _ => Ok(()),
        }
    }

    fn sensor(&self, kind: &str, object: &str, entry: &Entry<'_, '_>, limit: f64) -> Found {
        let site = || self.site(object);
        let of_frame = || self.frame(object, entry);
        let mixed = Representation::Mixed;
        Ok(match kind {
            "jointpos" | "ballquat" => Sensor::JointPosition(self.joint(object)?),
            "jointvel" | "ballangvel" => Sensor::JointVelocity(self.joint(object)?),
            "gyro" => Sensor::Gyro(site()?),
            "accelerometer" => Sensor::Accelerometer(site()?),
            "magnetometer" => Sensor::Magnetometer {
                frame: site()?,
                field: self.magnetic,
            },
            "velocimeter" => Sensor::FrameVelocity {
                frame: site()?,
                representation: Representation::Body,
            },
            "force" | "torque" => Sensor::Wrench(site()?),
            "touch" => Sensor::Touch(site()?),
            "rangefinder" => Sensor::RangeFinder {
                frame: site()?,
                direction: [0.0, 0.0, 1.0],
                range: limit.min(RANGE),
            },
            "framepos" | "framequat" => Sensor::FramePose(of_frame()?),
            "framelinvel" | "frameangvel" => Sensor::FrameVelocity {
                frame: of_frame()?,
                representation: mixed,
            },
            "frameangacc" => Sensor::FrameAcceleration {
                frame: of_frame()?,
                representation: mixed,
            },
            "framelinacc" => return Err("has gravity in it, which is not modelled"),
            "subtreecom" => self.of_all(object, Sensor::CenterOfMass)?,
            "subtreelinvel" => self.of_all(object, Sensor::CenterOfMassVelocity)?,
            "subtreeangmom" => self.of_all(object, Sensor::Momentum)?,
            _ => return Err(NOT_MODELLED),
        })
    }

    fn joint(&self, name: &str) -> Result<JointId, &'static str> {
        self.model.joint(name).ok_or(UNKNOWN)
    }

    fn site(&self, name: &str) -> Result<FrameId, &'static str> {
        let frame = self.names.sites.get(name).map_or(name, String::as_str);
        self.model.frame(frame).ok_or(UNKNOWN)
    }

    /// The frame of a site or a body, seen from the world.
    fn frame(&self, object: &str, entry: &Entry<'_, '_>) -> Result<FrameId, &'static str> {
        if entry.text("refname").is_some() {
            return Err("is seen from another frame, which is not modelled");
        }
        match entry.text("objtype") {
            Some("site") => self.site(object),
            Some("xbody") => self.model.frame(object).ok_or(UNKNOWN),
            Some("body") => Err("is on the inertial frame of a body, which is not modelled"),
            _ => Err(NOT_MODELLED),
        }
    }

    /// A sensor of a body with all that it carries, if that is all that moves.
    fn of_all(&self, body: &str, sensor: Sensor) -> Found {
        let model = self.model;
        let frame = model.frame(body).ok_or(UNKNOWN)?;
        let is_all = match model.frames()[frame.0].body {
            None => false,
            Some(body) => body.0 == 0 && model.body(body).subtree_end == model.n_bodies(),
        };
        match is_all {
            true => Ok(sensor),
            false => Err("is of a part of the robot, which is not modelled"),
        }
    }
}
