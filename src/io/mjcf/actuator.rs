//! Actuators: on joints, sites and fixed tendons, and what is not modelled.

use crate::nested::IntoNested;
use std::collections::HashMap;

use super::actuator_law::Law;
use super::body::Bodies;
use super::entry::Entry;
use super::joint::{Kind, symmetric};
use super::scene::{MjcfActuator, MjcfTendon, MjcfTransmission};
use super::sections::Names;
use super::walk::Part;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::io::place::SourcePlace;
use crate::model::Model;
use crate::scalar::MapEach;
use crate::sim::{Activation, Interval, Servo};

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

/// Attributes that name what an actuator acts on.
const TARGETS: [&str; 6] = [
    "joint",
    "jointinparent",
    "tendon",
    "site",
    "cranksite",
    "body",
];

/// An actuator with its position in the description.
#[derive(Debug)]
pub(super) struct ActuatorEntry {
    pub(super) actuator: MjcfActuator,
    place: SourcePlace,
    /// Damping ratio from which its velocity gain follows.
    damping_ratio: Option<f64>,
    /// Whether it has a number among the activations of keyframes.
    pub(super) has_dynamics: bool,
    /// Whether its target is the integral of its control.
    integrates: bool,
    /// Part of the range of its joint that is the range of its target.
    inherited: f64,
    /// Armature and damping of the motor.
    of_motor: [f64; 2],
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
    let (transmission, lack) = transmission(&entry, part, kinds, gear)?;
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

/// The target of an actuator, and why that is not modelled, if it is not.
fn transmission(
    entry: &Entry<'_, '_>,
    part: &Part<'_, '_>,
    kinds: &HashMap<String, Kind>,
    gear: [f64; 6],
) -> Result<(MjcfTransmission, Option<&'static str>), LoadError> {
    let own = TARGETS.map_each(|name| entry.text(name));
    let named = own.iter().zip(TARGETS).find_map(|(own, kind)| {
        let name = part.naming.of((*own)?);
        Some((kind, name))
    });
    let Some((kind, name)) = named else {
        let lack = Some("acts on nothing that is modelled");
        return Ok((MjcfTransmission::Other(String::new()), lack));
    };
    let reference = entry.text("refsite");
    Ok(match kind {
        "joint" | "jointinparent" => {
            let joint = kinds.get(&name);
            let joint = joint.ok_or_else(|| entry.node.place().unknown(&name))?;
            let lack = (!joint.is_single()).then_some("acts on a joint of several axes");
            (MjcfTransmission::Joint(name), lack)
        }
        "site" => match reference {
            None => (MjcfTransmission::Site(name, gear), None),
            Some(reference) => {
                let reference = part.naming.of(reference);
                let site = name;
                (
                    MjcfTransmission::SiteFrom {
                        site,
                        reference,
                        gear,
                    },
                    None,
                )
            }
        },
        "tendon" => (MjcfTransmission::Tendon(name), None),
        _ => {
            let lack = Some("acts on something that is not modelled");
            (MjcfTransmission::Other(name), lack)
        }
    })
}

impl ActuatorEntry {
    /// The joint that it acts on and its gear, where that is modelled.
    fn on_joint(&self) -> Option<(&str, &Servo)> {
        match (&self.actuator.transmission, &self.actuator.servo) {
            (MjcfTransmission::Joint(joint), Some(servo)) => Some((joint, servo)),
            _ => None,
        }
    }
}

/// Gives joints what their actuators have: rotor inertia, damping, and where one actuator moves a joint alone the largest force that it can give; and actuators
/// the range of their joint where it is theirs.
pub(super) fn share(
    actuators: &mut [ActuatorEntry],
    bodies: &mut Bodies,
    context: &mut Context<'_>,
) {
    let mut of_joint: HashMap<String, Vec<&mut ActuatorEntry>> = HashMap::new();
    for entry in actuators {
        if let Some((joint, _)) = entry.on_joint() {
            of_joint.entry(joint.to_owned()).or_default().push(entry);
        }
    }
    let joints = bodies.entries.iter_mut().nested(|body| &mut body.joints);
    for joint in joints {
        let Some(own) = of_joint.get_mut(joint.name.as_str()) else {
            continue;
        };
        let limits = &mut joint.axis.limits;
        for entry in own.iter_mut() {
            entry.inherit(limits.lower.zip(limits.upper));
            let Some((_, servo)) = entry.on_joint() else {
                continue;
            };
            let [armature, damping] = entry.of_motor.map_each(|x| x * servo.gear * servo.gear);
            joint.axis.armature += armature;
            joint.axis.damping += damping;
        }
        let [only] = &own[..] else {
            continue;
        };
        let most = only.on_joint().and_then(|(_, servo)| largest_force(servo));
        let most = most.map(|range| symmetric(range, &only.place, context));
        limits.effort = match (limits.effort, most) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
    }
}

impl ActuatorEntry {
    /// Takes a part of the range of its joint about the middle of that for the range of its input, if it is to.
    fn inherit(&mut self, range: Option<(f64, f64)>) {
        let wanted = range.filter(|_| self.inherited > 0.0);
        let Some((lower, upper)) = wanted else { return };
        let (middle, half) = ((lower + upper) / 2.0, (upper - lower) / 2.0);
        let [lower, upper] = [-1.0, 1.0].map_each(|side| middle + side * half * self.inherited);
        let own = &mut self.actuator;
        match own.activation.take() {
            Some(activation) if self.integrates => {
                own.activation = Some(activation.with_range(lower, upper));
            }
            Some(activation) if self.has_dynamics => {
                own.activation = Some(activation.with_input_range(lower, upper));
            }
            activation => {
                own.activation = activation;
                if let Some(servo) = &mut own.servo {
                    servo.input_range = Some(Interval { lower, upper });
                }
            }
        }
    }

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

    /// Finds its target: the frame of a site, a fixed tendon; the remaining things of motors act on joints only.
    pub(super) fn mount(
        &mut self,
        names: &Names,
        tendons: &[MjcfTendon],
        model: &Model,
        context: &mut Context<'_>,
    ) {
        let lack = match &mut self.actuator.transmission {
            MjcfTransmission::Site(site, _) => names.locate(site),
            MjcfTransmission::SiteFrom {
                site, reference, ..
            } => {
                let lack = names.locate(site).or_else(|| names.locate(reference));
                lack.or_else(|| moving(reference, model))
            }
            MjcfTransmission::Tendon(tendon) => {
                let is_fixed = tendons.iter().any(|own| own.name == *tendon);
                (!is_fixed).then(|| format!("\"{tendon}\" is not a fixed tendon"))
            }
            _ => return,
        };
        let has_servo = self.actuator.servo.is_some();
        if let Some(lack) = lack.filter(|_| has_servo) {
            self.actuator.servo = None;
            self.actuator.activation = None;
            let reason = format!("{lack}; kept in the scene");
            context.ignore(&self.place, reason);
        } else if has_servo && self.of_motor != [0.0; 2] {
            let reason = "armature and damping of the motor count on joints only";
            context.ignore(&self.place, reason);
        }
    }

    /// Makes the velocity gain of a damping ratio ζ: 2 ζ √(`k_p` I / n²), with the inertia I that joint or tendon feel where the file has the bodies.
    ///
    /// # References
    /// The attribute `dampratio` in the XML reference of `MuJoCo`; that the other joints are free was measured.
    pub(super) fn damp(
        &mut self,
        model: &Model,
        tendons: &[MjcfTendon],
        inertia: &impl Fn(&[(usize, f64)]) -> f64,
    ) {
        let Some(along) = self.actuator.along(model, tendons) else {
            return;
        };
        let (ratio, inertia) = (self.damping_ratio.unwrap_or_default(), inertia(&along));
        if let Some(servo) = &mut self.actuator.servo {
            let seen = inertia / (servo.gear * servo.gear);
            servo.velocity_gain = 2.0 * ratio * (servo.position_gain * seen).sqrt();
        }
    }
}

impl Names {
    /// Replaces the name of a site by that of its frame, or says that there is none.
    fn locate(&self, site: &mut String) -> Option<String> {
        let Some(frame) = self.sites.get(site.as_str()) else {
            return Some(format!("there is no frame of the site \"{site}\""));
        };
        site.clone_from(frame);
        None
    }
}

/// Why a site cannot be a reference, if it cannot.
fn moving(reference: &str, model: &Model) -> Option<String> {
    let frame = model.frame(reference)?;
    model.frames()[frame.0].body?;
    Some(format!(
        "its refsite \"{reference}\" moves: only one that is fixed to the world is modelled"
    ))
}

impl MjcfActuator {
    /// Coordinates along which it acts with their coefficients, on a joint or a fixed tendon of the model.
    fn along(&self, model: &Model, tendons: &[MjcfTendon]) -> Option<Vec<(usize, f64)>> {
        let coordinate = |joint: &str| Some(model.joint_v(model.joint(joint)?).start);
        match &self.transmission {
            MjcfTransmission::Joint(joint) => Some(vec![(coordinate(joint)?, 1.0)]),
            MjcfTransmission::Tendon(name) => {
                let tendon = tendons.iter().find(|own| own.name == *name)?;
                let joints = tendon.joints.iter();
                joints
                    .map(|(joint, c)| Some((coordinate(joint)?, *c)))
                    .collect()
            }
            _ => None,
        }
    }
}

/// Least and largest force along the joint, of a servo whose force is limited.
fn largest_force(servo: &Servo) -> Option<[f64; 2]> {
    let is_motor = servo.position_gain == 0.0 && servo.velocity_gain == 0.0;
    let own = servo.force_range;
    let by_input = servo.input_range.filter(|_| is_motor).map(|range| {
        let [a, b] = [range.lower, range.upper].map_each(|u| servo.gain * u + servo.bias);
        Interval {
            lower: a.min(b),
            upper: a.max(b),
        }
    });
    let range = match (own, by_input) {
        (Some(own), Some(range)) => Interval {
            lower: range.lower.clamp(own.lower, own.upper),
            upper: range.upper.clamp(own.lower, own.upper),
        },
        (own, range) => own.or(range)?,
    };
    let [a, b] = [range.lower, range.upper].map_each(|force| servo.gear * force);
    Some([a.min(b), a.max(b)])
}
