//! Reads the tree of a text into the typed description: every element that matters is checked, every one that does not
//! is reported.

use super::part::Elements;
use super::reader::Reader;
use super::{joint, link, schema};
use crate::error::LoadError;
use crate::io::context::{Context, Node, children};
use crate::io::schema::check;
use crate::io::version::Version;

/// Version of a file that states none.
const FIRST: Version = Version(1, 0);

/// Reads a robot; returns it with the elements of its parts.
pub(super) fn read<'a>(
    context: &mut Context<'_>,
    node: Node<'a>,
) -> Result<(urdf_rs::Robot, Elements<'a>), LoadError> {
    check(context, node, &schema::ROBOT)?;
    let version = version(context, node);
    let mut reader = Reader { context, version };
    let name = reader.robot_name(node);
    let links = children(node, "link").map(|node| link::read(&mut reader, node));
    let (links, link_elements) = links.collect::<Result<_, _>>()?;
    let joints = children(node, "joint").map(|node| Ok((joint::read(&mut reader, node)?, node)));
    let (joints, joint_elements) = joints.collect::<Result<_, _>>()?;
    let materials = children(node, "material").map(|node| link::read_material(&mut reader, node));
    let robot = urdf_rs::Robot {
        name,
        version: node.attribute("version").map(Into::into),
        links,
        joints,
        materials: materials.collect::<Result<_, _>>()?,
    };
    let elements = Elements {
        robot: node,
        links: link_elements,
        joints: joint_elements,
    };
    Ok((robot, elements))
}

fn version(context: &mut Context<'_>, robot: Node<'_>) -> Version {
    let Some(text) = robot.attribute("version") else {
        return FIRST;
    };
    Version::parse(text).unwrap_or_else(|| {
        let reason = format!("\"{text}\" is not a version of the URDF: taken as 1.0");
        context.warn(robot, reason);
        FIRST
    })
}
