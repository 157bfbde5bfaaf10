//! The actuators, sensors, keyframes, equalities and contact shapes of a file.

use std::fmt::Write;

use serde::Serialize;

use super::output::heading;
use super::robot::Loaded;
use crate::constraint::{Anchor, Constraint, ConstraintKind};
use crate::io::{MjcfActuator, MjcfContacts, MjcfScene, MjcfTransmission};
use crate::model::Model;

/// JSON content of a file beside the robot. Only MJCF files have more than sensors.
#[derive(Serialize)]
pub(super) struct Contents {
    sensors: Vec<SensorSummary>,
    #[serde(flatten)]
    scene: Option<SceneSummary>,
}

#[derive(Serialize)]
struct SensorSummary {
    name: String,
    kind: String,
    /// The object that carries it.
    object: String,
    is_modelled: bool,
}

#[derive(Serialize)]
struct SceneSummary {
    actuators: Vec<ActuatorSummary>,
    keyframes: Vec<KeyframeSummary>,
    equalities: Vec<EqualitySummary>,
    contact: ContactSummary,
    /// s
    time_step: f64,
}

#[derive(Serialize)]
struct ActuatorSummary {
    name: String,
    kind: String,
    /// The kind of what it acts on, and its name.
    acts_on: [String; 2],
    /// Range of the control.
    lower: Option<f64>,
    upper: Option<f64>,
    is_modelled: bool,
}

#[derive(Serialize)]
struct KeyframeSummary {
    name: String,
    /// s
    time: f64,
}

#[derive(Serialize)]
struct EqualitySummary {
    kind: &'static str,
    /// The frames or joints that it ties; a frame of the world is `world`.
    ties: Vec<String>,
}

#[derive(Serialize)]
struct ContactSummary {
    /// `plane`, `height field`, or nothing.
    ground: Option<&'static str>,
    geoms: Vec<GeomSummary>,
    /// Pairs of geoms that touch by their own parameters.
    pairs: Vec<[String; 2]>,
    /// Pairs of bodies without contact.
    excluded: Vec<[String; 2]>,
}

#[derive(Serialize)]
struct GeomSummary {
    name: Option<String>,
    link: String,
    /// Sliding, torsional (m) and rolling (m).
    friction: [f64; 3],
    condim: u8,
}

impl Contents {
    pub(super) fn of(loaded: &Loaded) -> Self {
        let sensors = loaded.report.sensors.iter().map(|own| SensorSummary {
            name: own.name.clone(),
            kind: own.kind.clone(),
            object: own.object.clone(),
            is_modelled: own.sensor.is_some(),
        });
        Self {
            sensors: sensors.collect(),
            scene: loaded.scene.as_ref().map(SceneSummary::of),
        }
    }

    /// A table for each kind of part that there is.
    pub(super) fn text(&self) -> String {
        let mut out = String::new();
        let modelled = |is: bool| if is { "" } else { " (not modelled)" };
        let sensors = self.sensors.iter().map(|own| {
            let kind = format!("{}{}", own.kind, modelled(own.is_modelled));
            [own.name.clone(), kind, own.object.clone()]
        });
        table(&mut out, ["sensor", "kind", "on"], sensors);
        let Some(scene) = &self.scene else {
            return out;
        };
        let actuators = scene.actuators.iter().map(|own| {
            let range = match (own.lower, own.upper) {
                (Some(lower), Some(upper)) => format!("{lower} to {upper}"),
                _ => "–".into(),
            };
            let kind = format!("{}{}", own.kind, modelled(own.is_modelled));
            [own.name.clone(), kind, own.acts_on.join(" "), range]
        });
        table(&mut out, ["actuator", "kind", "on", "control"], actuators);
        let keyframes = scene.keyframes.iter();
        let keyframes = keyframes.map(|own| [own.name.clone(), format!("{} s", own.time)]);
        table(&mut out, ["keyframe", "time"], keyframes);
        let equalities = scene.equalities.iter();
        let equalities = equalities.map(|own| [own.kind.to_string(), own.ties.join(", ")]);
        table(&mut out, ["equality", "of"], equalities);
        scene.contact.write(&mut out);
        out
    }
}

impl SceneSummary {
    fn of(scene: &MjcfScene) -> Self {
        let equalities = scene.constraints.iter();
        Self {
            actuators: scene.actuation.iter().map(ActuatorSummary::of).collect(),
            keyframes: (scene.keyframes.iter())
                .map(|own| KeyframeSummary {
                    name: own.name.clone(),
                    time: own.time,
                })
                .collect(),
            equalities: equalities
                .map(|own| EqualitySummary::of(own, &scene.model))
                .collect(),
            contact: ContactSummary::of(&scene.contacts),
            time_step: scene.options.time_step,
        }
    }
}

impl ActuatorSummary {
    fn of(own: &MjcfActuator) -> Self {
        let on = match &own.transmission {
            MjcfTransmission::Joint(name) => ["joint", name],
            MjcfTransmission::Site(name, _) | MjcfTransmission::SiteFrom { site: name, .. } => {
                ["site", name]
            }
            MjcfTransmission::Tendon(name) => ["tendon", name],
            MjcfTransmission::Other(name) => ["other", name],
        };
        let range = own.servo.as_ref().and_then(|servo| servo.input_range);
        Self {
            name: own.name.clone(),
            kind: own.kind.clone(),
            acts_on: on.map(Into::into),
            lower: range.map(|own| own.lower),
            upper: range.map(|own| own.upper),
            is_modelled: own.servo.is_some(),
        }
    }
}

impl EqualitySummary {
    fn of(own: &Constraint, model: &Model) -> Self {
        let kind = match own.kind() {
            ConstraintKind::Weld(_) => "weld",
            ConstraintKind::Ball(_) => "connect",
            ConstraintKind::Distance { .. } => "distance",
            ConstraintKind::Coupler { .. } => "joints",
            ConstraintKind::Tendon { .. } if own.spring().is_some() => "spring of a tendon",
            ConstraintKind::Tendon { .. } => "tendon",
        };
        let frame = |anchor: &Anchor| match anchor.frame {
            Some(frame) => model.frames()[frame.0].name.clone(),
            None => "world".into(),
        };
        let joint = |body| {
            let names = model.joint_names().into_iter();
            let mut moved = names.filter(|name| {
                let id = model.joint(name);
                id.is_some_and(|id| model.joint_body(id) == body)
            });
            moved.next().unwrap_or_default().to_owned()
        };
        let frames = own.kind().anchors().iter().map(frame);
        let joints = own.kind().joints().map(|tied| joint(tied.body));
        Self {
            kind,
            ties: frames.chain(joints).collect(),
        }
    }
}

impl ContactSummary {
    fn of(contacts: &MjcfContacts) -> Self {
        let ground = contacts.ground.as_ref().map(|_| match contacts.heights {
            Some(_) => "height field",
            None => "plane",
        });
        let geoms = contacts.geoms.iter().map(|own| GeomSummary {
            name: own.name.clone(),
            link: own.link.clone(),
            friction: own.friction,
            condim: own.condim,
        });
        Self {
            ground,
            geoms: geoms.collect(),
            pairs: contacts.pairs.iter().map(|own| own.geoms.clone()).collect(),
            excluded: contacts.excluded.clone(),
        }
    }

    fn write(&self, out: &mut String) {
        let geoms = self.geoms.iter().map(|own| {
            let [sliding, torsional, rolling] = own.friction;
            let friction = format!("{sliding} {torsional} {rolling}");
            let name = own.name.clone().unwrap_or_else(|| "–".into());
            [name, own.link.clone(), own.condim.to_string(), friction]
        });
        table(out, ["contact shape", "link", "condim", "friction"], geoms);
        let pairs = self.pairs.iter().cloned();
        table(out, ["contact pair", "and"], pairs);
        let excluded = self.excluded.iter().cloned();
        table(out, ["no contact", "and"], excluded);
        // Writing to a string does not fail.
        let _ = writeln!(out, "\nground: {}", self.ground.unwrap_or("none"));
    }
}

/// Adds a table with a title, unless it has no rows; empty entries are dashes.
fn table<const N: usize>(
    out: &mut String,
    title: [&str; N],
    rows: impl Iterator<Item = [String; N]>,
) {
    let rows: Vec<[String; N]> = rows.collect();
    if rows.is_empty() {
        return;
    }
    let shown = |row: &[String; N]| {
        row.each_ref().map(|own| match own.as_str() {
            "" => "–".to_owned(),
            text => text.to_owned(),
        })
    };
    let mut all = vec![title.map(ToOwned::to_owned)];
    all.extend(rows.iter().map(shown));
    let width = |k: usize| all.iter().map(|row| row[k].chars().count()).max();
    let widths: Vec<usize> = (0..N).map(|k| width(k).unwrap_or(0)).collect();
    for (k, row) in all.iter().enumerate() {
        let cells = row.iter().zip(&widths);
        let cells: Vec<String> = cells
            .map(|(cell, width)| format!("{cell:width$}"))
            .collect();
        let line = cells.join("  ").trim_end().to_owned();
        // Writing to a string does not fail.
        let _ = match k {
            0 => writeln!(out, "\n{}", heading(line)),
            _ => writeln!(out, "{line}"),
        };
    }
}
