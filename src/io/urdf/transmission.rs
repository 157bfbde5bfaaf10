//! Reads `<transmission>`, of ROS 1 beside the joints or of ROS 2 in a `<ros2_control>`.
//!
//! A simple transmission connects one actuator with one joint by a reduction. Of ROS 1 it also states the interface of the joint, which is an effort if the file alone
//! counts, since the gains of the others are elsewhere.

use super::control::{Command, Commands, NO_GAINS, number};
use crate::io::context::{Context, Node, child, children};
use crate::nested::IntoNested;

/// Names of interfaces of ROS 1, and whether they are efforts.
const INTERFACES: [(&str, bool); 3] = [
    ("EffortJointInterface", true),
    ("PositionJointInterface", false),
    ("VelocityJointInterface", false),
];

/// Reads a transmission: the reduction of a joint that has a command interface, or an interface with its reduction.
pub(super) fn read<'a>(context: &mut Context<'_>, node: Node<'a>, commands: &mut Commands<'a>) {
    let kind = kind(node);
    if !kind.ends_with("SimpleTransmission") {
        return context.ignore(
            node,
            match kind {
                "" => "a transmission without a type".to_owned(),
                _ => format!("transmissions of the type \"{kind}\" are not modelled"),
            },
        );
    }
    let joints: Vec<_> = children(node, "joint").collect();
    let actuators: Vec<_> = children(node, "actuator").collect();
    let [joint] = joints[..] else {
        let reason = "a simple transmission has one joint: not used";
        return context.ignore(node, reason);
    };
    let ends: Vec<Node<'_>> = joints.iter().chain(&actuators).copied().collect();
    let gear = gear(context, node, &ends);
    let name = joint.attribute("name").unwrap_or_default();
    if let Some(own) = commands.find(name) {
        for interface in ends
            .iter()
            .nested(|end| children(*end, "hardwareInterface"))
        {
            context.ignore(interface, "the joint has another input");
        }
        return match own.gear {
            Some(_) => context.ignore(node, "the joint has another transmission"),
            None => own.gear = gear,
        };
    }
    match interface(context, &ends) {
        Some(place) => commands.push(Command {
            joint: name,
            place,
            servo: None,
            gear,
        }),
        None => context.ignore(
            node,
            format!("\"{name}\" has no command interface that is modelled"),
        ),
    }
}

/// The type, which has been an attribute, an element and the name of a plugin.
fn kind<'a>(node: Node<'a>) -> &'a str {
    let element = child(node, "type").or_else(|| child(node, "plugin"));
    let text = element.and_then(|element| element.text());
    text.or(node.attribute("type")).unwrap_or_default().trim()
}

/// Turns of the motor for one of the joint, if they are stated and not none.
fn gear(context: &mut Context<'_>, node: Node<'_>, ends: &[Node<'_>]) -> Option<f64> {
    let mut out = None;
    for own in ends.iter().chain([&node]).nested(|own| own.children()) {
        match own.tag_name().name() {
            "mechanicalReduction" | "mechanical_reduction" => {
                let Some(n) = number(context, own) else {
                    continue;
                };
                match out {
                    None if n != 0.0 => out = Some(n),
                    None => context.warn(own, "a reduction of 0: not used"),
                    Some(_) => context.ignore(own, "only the first reduction is used"),
                }
            }
            "offset" => context.ignore(own, "not used: positions are those of the joint"),
            "type" | "plugin" | "joint" | "actuator" | "hardwareInterface" | "role" | "" => {}
            other => context.ignore(own, format!("<{other}> of a transmission is not used")),
        }
    }
    out
}

/// The first interface that is modelled, that of the joint before that of the actuator; reports the others of the joint.
fn interface<'a>(context: &mut Context<'_>, ends: &[Node<'a>]) -> Option<Node<'a>> {
    let mut found = None;
    for own in ends
        .iter()
        .nested(|end| children(*end, "hardwareInterface"))
    {
        let text = own.text().unwrap_or_default().trim();
        let name = text.rsplit('/').next().unwrap_or_default();
        let known = INTERFACES.iter().find(|(known, _)| *known == name);
        match (known, found) {
            (Some((_, true)), None) => found = Some(own),
            (Some((_, false)), None) => {
                context.warn(own, NO_GAINS);
                found = Some(own);
            }
            (Some(_), Some(_)) => {}
            (None, _) => context.ignore(own, format!("an interface \"{text}\" is not modelled")),
        }
    }
    found
}
