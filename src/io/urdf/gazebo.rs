//! Settings of the simulator Gazebo that are read: links that gravity does not act on, sensors.

use super::parts::{LinkPart, Parts, SensorPart};
use crate::error::LoadError;
use crate::io::context::{Context, Node, child, children, tag};
use crate::io::sdf::pose_value;
use crate::io::sensors::{self, Carrier};
use crate::spatial::Transform;

/// Reads a `<gazebo reference="LINK or JOINT">` with `<gravity>`, `<turnGravityOff>` or `<sensor>`.
pub(super) fn read(
    context: &mut Context<'_>,
    gazebo: Node<'_>,
    parts: &mut Parts<'_>,
) -> Result<(), LoadError> {
    let Some(reference) = gazebo.attribute("reference") else {
        return Ok(());
    };
    read_gravity(context, gazebo, reference, &mut parts.links);
    let is_link = parts.links.iter().any(|link| link.name() == reference);
    let carrier = if is_link {
        Carrier::Link
    } else {
        Carrier::Joint
    };
    for node in children(gazebo, "sensor") {
        let element = sensors::read(context, node, carrier, reference)?;
        let placement = match child(node, "pose") {
            Some(pose) if element.is_modelled() => pose_value(context, pose)?,
            _ => Transform::identity(),
        };
        parts.sensors.push(SensorPart {
            place: context.keep(node),
            element,
            placement,
        });
    }
    Ok(())
}

fn read_gravity(
    context: &mut Context<'_>,
    gazebo: Node<'_>,
    link: &str,
    links: &mut [LinkPart<'_>],
) {
    for setting in gazebo.children().filter(Node::is_element) {
        let off = match tag(setting) {
            "gravity" => "false",
            "turnGravityOff" => "true",
            _ => continue,
        };
        let text = setting.text().unwrap_or_default().trim();
        let is_off = match text.to_ascii_lowercase().as_str() {
            "true" | "1" => off == "true",
            "false" | "0" => off == "false",
            _ => {
                let reason = format!("\"{text}\" is neither true nor false: gravity acts");
                context.warn(setting, reason);
                continue;
            }
        };
        if !is_off {
            continue;
        }
        match links.iter_mut().find(|part| part.name() == link) {
            Some(part) => part.take_gravity(),
            None => context.warn(setting, format!("there is no link \"{link}\"")),
        }
    }
}
