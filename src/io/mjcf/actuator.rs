//! Actuators: motors on joints, and what is not modelled.

use std::collections::HashMap;

use super::body::Bodies;
use super::entry::Entry;
use super::joint::{Kind, symmetric};
use super::scene::MjcfActuator;
use super::walk::Part;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::io::place::SourcePlace;

/// Actuators share their defaults: those of their own element count first.
const OF_MOTORS: [&str; 9] = [
    "motor",
    "general",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
];
/// Actuators that are not modelled, but for some of kind `general`.
pub(super) const OF_OTHERS: [&str; 8] = [
    "general",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
];

/// Attributes that name what an actuator acts on, where that is no joint.
const OTHER_ENDS: [&str; 5] = ["jointinparent", "tendon", "site", "cranksite", "body"];

/// An actuator with its place.
#[derive(Debug)]
pub(super) struct ActuatorEntry {
    pub(super) actuator: MjcfActuator,
    pub(super) place: SourcePlace,
}

/// Reads an actuator.
pub(super) fn read(
    part: &Part<'_, '_>,
    kinds: &HashMap<String, Kind>,
    context: &mut Context<'_>,
) -> Result<ActuatorEntry, LoadError> {
    let kind = part.node.tag();
    let entry = match kind {
        "motor" => part.entry(&OF_MOTORS)?,
        _ => part.entry(&OF_OTHERS)?,
    };
    let autolimits = part.source.compiler.autolimits;
    let gear = entry.some_numbers("gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?;
    let joint = entry.text("joint").map(|name| part.naming.of(name));
    let actuator = MjcfActuator {
        name: part.name().unwrap_or_default(),
        kind: kind.into(),
        gain: gain(&entry)?,
        gear: gear[0],
        control_range: entry.range("ctrlrange", "ctrllimited", autolimits)?,
        force_range: entry.range("forcerange", "forcelimited", autolimits)?,
        joint,
    };
    let place = entry.node.place();
    let is_on_single = match &actuator.joint {
        None => false,
        Some(name) => kinds
            .get(name)
            .ok_or_else(|| place.unknown(name))?
            .is_single(),
    };
    if !is_on_single || actuator.gain.is_none() {
        OTHER_ENDS.iter().for_each(|name| {
            entry.value(name);
        });
        let what = match is_on_single {
            true => "only motors are modelled",
            false => "only motors on hinges and slides are modelled",
        };
        let reason = format!("{what}; kept in MjcfScene::actuation");
        context.ignore(&place, reason);
        entry.node.read_all();
    }
    Ok(ActuatorEntry { actuator, place })
}

/// Force before the gear per unit of the control, of motors and of what is one.
fn gain(entry: &Entry<'_, '_>) -> Result<Option<f64>, LoadError> {
    match entry.node.tag() {
        "motor" => Ok(Some(1.0)),
        "general" => {
            let word = |name, plain: &str| entry.text(name).is_none_or(|text| text == plain);
            let is_motor =
                word("dyntype", "none") & word("gaintype", "fixed") & word("biastype", "none");
            let [gain] = entry.some_numbers_of_many("gainprm", [1.0])?;
            Ok(is_motor.then_some(gain))
        }
        _ => Ok(None),
    }
}

/// Limits the effort of joints that one motor moves to what it can give.
pub(super) fn limit_efforts(
    actuators: &[ActuatorEntry],
    bodies: &mut Bodies,
    context: &mut Context<'_>,
) {
    let mut of_joint: HashMap<&str, Vec<&ActuatorEntry>> = HashMap::new();
    for entry in actuators {
        if let Some(joint) = &entry.actuator.joint {
            of_joint.entry(joint).or_default().push(entry);
        }
    }
    let joints = bodies.entries.iter_mut().flat_map(|body| &mut body.joints);
    for joint in joints {
        let [only] = of_joint.get(joint.name.as_str()).map_or(&[][..], |all| all) else {
            continue;
        };
        let most = only.actuator.largest_force();
        let most = most.map(|range| symmetric(range, &only.place, context));
        let limits = &mut joint.axis.limits;
        limits.effort = match (limits.effort, most) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
    }
}
