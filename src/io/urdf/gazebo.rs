//! Settings of the simulator Gazebo that are read: links that gravity does not act on.

use super::parts::LinkPart;
use crate::io::context::{Context, Node, tag};

/// Reads a `<gazebo reference="LINK">` with `<gravity>` or `<turnGravityOff>`.
pub(super) fn read(context: &mut Context<'_>, gazebo: Node<'_>, links: &mut [LinkPart<'_>]) {
    let Some(link) = gazebo.attribute("reference") else {
        return;
    };
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
