//! Reads the tree of a text: every element that matters is checked, every one that does not is reported.

use super::parts::Parts;
use super::reader::Reader;
use super::{joint, link, schema};
use crate::error::LoadError;
use crate::io::context::{Context, Node, children};
use crate::io::mesh_path::MeshFinder;
use crate::io::schema::check;
use crate::io::version::Version;

/// Version of a file that states none.
const FIRST: Version = Version(1, 0);

/// Reads the parts of a robot.
pub(super) fn read<'a>(
    context: &mut Context<'_>,
    node: Node<'a>,
    meshes: &mut MeshFinder,
) -> Result<Parts<'a>, LoadError> {
    check(context, node, &schema::ROBOT)?;
    let version = version(context, node);
    let mut parts = Parts::new(context, node.into(), node.attribute("name"));
    let mut reader = Reader {
        context,
        version,
        meshes,
    };
    for node in children(node, "link") {
        parts.links.push(link::read(&mut reader, node)?);
    }
    for node in children(node, "joint") {
        parts.joints.push(joint::read(&mut reader, node)?);
    }
    for node in children(node, "material") {
        let material = link::read_material(&mut reader, node)?;
        parts.materials.push(material);
    }
    Ok(parts)
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
