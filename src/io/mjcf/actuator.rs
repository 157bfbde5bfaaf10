//! Actuators: on joints, sites and fixed tendons, and what is not modelled.

use std::collections::HashMap;

use super::actuator_law::Law;
use super::entry::Entry;
use super::joint::Kind;
use super::scene::{MjcfActuator, MjcfTransmission};
use super::transmission;
use super::walk::Part;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::io::place::SourcePlace;
use crate::sim::{Activation, Servo};

/// Elements of actuators, which share their defaults.
pub(super) const KINDS: [&str; 12] = [
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "pid",
    "plugin",
];

/// An actuator with its position in the description.
#[derive(Debug)]
pub(super) struct ActuatorEntry {
    pub(super) actuator: MjcfActuator,
    pub(super) place: SourcePlace,
    /// Damping ratio from which its velocity gain follows.
    pub(super) damping_ratio: Option<f64>,
    /// Whether it has a number among the activations of keyframes.
    pub(super) has_dynamics: bool,
    /// Whether its target is the integral of its control.
    pub(super) integrates: bool,
    /// Part of the range of its joint that is the range of its target.
    pub(super) inherited: f64,
    /// Armature and damping of the motor.
    pub(super) of_motor: [f64; 2],
}

/// Reads an actuator.
///
/// * `time_step` – s, in which delays are counted
pub(super) fn read(
    part: &Part<'_, '_>,
    kinds: &HashMap<String, Kind>,
    time_step: f64,
    context: &mut Context<'_>,
) -> Result<ActuatorEntry, LoadError> {
    let entry = part.entry(&KINDS)?;
    let classes = entry.classes;
    let defaults = classes.defaults(entry.class, &KINDS).into_iter();
    let elements = defaults.chain([entry.node]);
    let law = Law::read(elements.map(|node| Entry::plain(node, classes)))?;
    if let Some(time) = law.negative_time() {
        let reason = format!("the time constant {time} of its filter is negative: taken as none");
        context.warn(&entry.node.place(), reason);
    }
    let gear = entry.some_numbers("gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?;
    let (transmission, lack) = transmission::read(&entry, part, kinds, gear)?;
    let lack = lack.or_else(|| law.lack(time_step));
    let autolimits = part.source.compiler.autolimits;
    let ranges = ["ctrl", "force", "act"].map(|of| entry.range_of(of, autolimits));
    let [input_range, force_range, range] = ranges;
    let of_motor = ["armature", "damping"].map(|name| entry.some_numbers_of_many(name, [0.0]));
    let [[armature], [damping]] = {
        let [armature, damping] = of_motor;
        [armature?, damping?]
    };
    let (servo, damping_ratio) = law.servo(gear[0]);
    let on_site = matches!(
        transmission,
        MjcfTransmission::Site(..) | MjcfTransmission::SiteFrom { .. }
    );
    let has_ratio = on_site && damping_ratio.is_some();
    let lack = lack.or(has_ratio.then_some("has a damping ratio on a site: give it a kv"));
    let mut servo = Servo {
        input_range: input_range?,
        force_range: force_range?,
        ..servo
    };
    let mut activation = (lack.is_none())
        .then(|| law.activation(time_step))
        .flatten();
    if let Some(own) = activation.take_if(|_| law.has_dynamics()) {
        // The range is that of the control, not of what its dynamics make of it.
        let input_range = servo.input_range.take();
        activation = Some(own.with_ranges(input_range, range?));
    }
    if let Some(lack) = lack {
        let reason = format!("{lack}; kept in the scene");
        context.ignore(&entry.node.place(), reason);
        entry.node.read_all();
    }
    Ok(ActuatorEntry {
        actuator: MjcfActuator {
            name: part.name().unwrap_or_default(),
            kind: entry.node.tag().into(),
            transmission,
            servo: lack.is_none().then_some(servo),
            activation,
        },
        has_dynamics: law.has_dynamics(),
        integrates: law.integrates(),
        place: entry.node.place(),
        damping_ratio,
        inherited: law.common.inherited,
        of_motor: [armature, damping],
    })
}

impl ActuatorEntry {
    /// Numbers of state of its activation.
    pub(super) fn states(&self) -> usize {
        self.actuator
            .activation
            .as_ref()
            .map_or(0, Activation::states)
    }

    /// Whether its velocity gain follows from a damping ratio.
    pub(super) fn has_ratio(&self) -> bool {
        self.damping_ratio.is_some() && self.actuator.servo.is_some()
    }

    /// Error for more damping ratios than there is time for.
    pub(super) fn too_many(&self) -> LoadError {
        let reason = "too many actuators state a dampratio: give them a kv";
        self.place.unsupported(reason)
    }
}
