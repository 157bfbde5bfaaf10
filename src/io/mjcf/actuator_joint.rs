//! What actuators give the joints that they act on, and take from them.

use std::collections::HashMap;

use super::actuator::ActuatorEntry;
use super::body::Bodies;
use super::joint::symmetric;
use super::scene::MjcfTransmission;
use crate::io::context::Context;
use crate::nested::IntoNested;
use crate::scalar::MapEach;
use crate::sim::{Interval, Servo};

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
    /// The joint that it acts on and its gear, where that is modelled.
    fn on_joint(&self) -> Option<(&str, &Servo)> {
        match (&self.actuator.transmission, &self.actuator.servo) {
            (MjcfTransmission::Joint(joint), Some(servo)) => Some((joint, servo)),
            _ => None,
        }
    }

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
