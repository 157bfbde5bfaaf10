//! The reader of URDF files and of `urdf-rs` robots.
//!
//! [`read`] makes the [parts] of a model from the tree of a text: it checks all elements and reports unused ones. For users of `urdf-rs`, [`typed`]
//! converts a [`urdf_rs::Robot`], reports unused content and interprets zeros.
//!
//! The text reader of `urdf-rs` is not used. It is recursive, so a text of some hundred kilobytes overflows the stack. It drops words among numbers,
//! does not distinguish a missing limit from a limit of zero, and refuses robots that load here: with a missing limit or product of inertia, with a
//! duplicate element, or with an empty texture.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

mod control;
mod gazebo;
mod joint;
mod link;
mod parts;
mod reader;
mod schema;
#[cfg(test)]
mod tests;
mod transmission;
mod typed;

use nalgebra::Vector3;

use super::context::{Context, Node, children};
use super::mesh_path::MeshFinder;
use super::rotation::rotation_from_rpy;
use super::schema::check;
use super::{ImportReport, ModelOptions, guard};
use crate::error::LoadError;
use crate::model::Model;
use crate::spatial::{Inertia, Symmetric3, Transform};
use parts::Parts;
use reader::{Reader, version};

/// Name of the source in errors and reports for a robot that is not a text.
const ROBOT_SOURCE: &str = "urdf_rs::Robot";

/// Loads a robot from text; `file` is what errors and the report call its source.
pub(super) fn load(
    file: &str,
    text: &str,
    options: &ModelOptions,
    meshes: &mut MeshFinder,
) -> Result<(Model, ImportReport), LoadError> {
    let xml = guard::parse(file, text, "robot")?;
    let mut context = Context::new(file, text);
    let parts = read(&mut context, xml.root_element(), meshes)?;
    parts.finish(context, options)
}

/// Makes a robot of what `urdf-rs` has read.
pub(super) fn load_robot(
    robot: &urdf_rs::Robot,
    options: &ModelOptions,
    meshes: &mut MeshFinder,
) -> Result<(Model, ImportReport), LoadError> {
    let mut context = Context::new(ROBOT_SOURCE, "");
    let parts = typed::read(&mut context, robot, meshes);
    parts.finish(context, options)
}

/// Reads the parts of a robot from the tree of a text.
fn read<'a>(
    context: &mut Context<'_>,
    node: Node<'a>,
    meshes: &mut MeshFinder,
) -> Result<Parts<'a>, LoadError> {
    check(context, node, &schema::ROBOT)?;
    let mut parts = Parts::new(context, node.into(), node.attribute("name"));
    let mut reader = Reader {
        version: version(context, node),
        context,
        meshes,
    };
    for node in children(node, "link") {
        parts.links.push(link::read(&mut reader, node)?);
    }
    for node in children(node, "gazebo") {
        gazebo::read(reader.context, node, &mut parts)?;
    }
    for node in children(node, "joint") {
        parts.joints.push(joint::read(&mut reader, node)?);
    }
    for node in children(node, "material") {
        let material = link::read_material(&mut reader, node)?;
        parts.materials.push(material);
    }
    read_commands(reader.context, node, &mut parts)?;
    Ok(parts)
}

/// Reads the inputs of joints: those of ROS 2 first, whose joints may have transmissions beside them.
fn read_commands<'a>(
    context: &mut Context<'_>,
    robot: Node<'a>,
    parts: &mut Parts<'a>,
) -> Result<(), LoadError> {
    let controls = || children(robot, "ros2_control");
    let transmissions = || {
        controls()
            .chain([robot])
            .flat_map(|own| children(own, "transmission"))
    };
    if controls().chain(transmissions()).next().is_none() {
        return Ok(());
    }
    let mut commands = control::Commands::default();
    for own in controls() {
        control::read(context, own, &mut commands)?;
    }
    for own in transmissions() {
        transmission::read(context, own, &mut commands);
    }
    parts.commands = Some(commands);
    Ok(())
}

/// The inertia in the frame of the link; a URDF gives it in a frame C at the centre of mass.
fn inertia_of(mass: f64, entries: [f64; 6], X_LC: &Transform<f64>) -> Inertia<f64> {
    let [xx, xy, xz, yy, yz, zz] = entries;
    let J_C = Symmetric3::new(xx, xy, xz, yy, yz, zz);
    Inertia::from_com(mass, &X_LC.translation, &J_C.rotated(&X_LC.rotation))
}

fn pose(xyz: [f64; 3], rpy: [f64; 3]) -> Transform<f64> {
    if [xyz, rpy] == [[0.0; 3]; 2] {
        // Zeros of either sign.
        return Transform::new(rotation_from_rpy([0.0; 3]), Vector3::zeros());
    }
    Transform::new(rotation_from_rpy(rpy), Vector3::from(xyz))
}
