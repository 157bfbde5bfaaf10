//! The reader of URDF files, and of what `urdf-rs` has read.
//!
//! The typed reading of a URDF is [`urdf_rs::Robot`]. [`read`] fills it from the tree of a text: it checks every
//! element, reports what is not used, and keeps where each part is written. Users of that crate bring one along;
//! [`typed`] reports what of it is not used and says what its zeros mean. From there on both are one: [`convert`] makes
//! the parts of a model of it and remarks on what may not mean what its author wanted.
//!
//! `urdf-rs`'s own reader of texts is not asked. It recurses into elements, so that a text of some hundred kilobytes
//! overflows the stack; it drops words among numbers; it does not tell no limit from a limit of zero; and it refuses
//! robots that load here: with a limit or a product of inertia that is left out, with an element that stands there
//! twice, with an empty texture.

mod convert;
mod joint;
mod link;
mod part;
mod read;
mod reader;
mod schema;
#[cfg(test)]
mod tests;
mod typed;

use std::collections::HashMap;

use super::ModelOptions;
use super::context::Context;
use super::guard;
use super::massless::Remark;
use super::mesh_path::MeshFinder;
use super::report::{ImportNote, ImportReport};
use crate::error::LoadError;
use crate::model::{DEFAULT_GRAVITY, Model};
use part::{Part, Source};

/// Name of the source in errors and reports for a robot that is no text.
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
    let (robot, elements) = read::read(&mut context, xml.root_element())?;
    finish(context, &robot, &Source::Text(elements), options, meshes)
}

/// Makes a robot of what `urdf-rs` has read.
pub(super) fn load_robot(
    robot: &urdf_rs::Robot,
    options: &ModelOptions,
    meshes: &mut MeshFinder,
) -> Result<(Model, ImportReport), LoadError> {
    let mut context = Context::new(ROBOT_SOURCE, "");
    let robot = typed::completed(&mut context, robot);
    finish(context, &robot, &Source::Typed, options, meshes)
}

fn finish(
    mut context: Context<'_>,
    robot: &urdf_rs::Robot,
    source: &Source<'_>,
    options: &ModelOptions,
    meshes: &mut MeshFinder,
) -> Result<(Model, ImportReport), LoadError> {
    let builder = convert::convert(&mut context, robot, source, meshes, options.mimicry)
        .with_gravity(options.gravity.unwrap_or(DEFAULT_GRAVITY));
    options.finish(builder, context, |context, remarks| {
        notes(context, robot, source, remarks)
    })
}

/// Places remarks on joints, or on the whole robot.
fn notes(
    context: &Context<'_>,
    robot: &urdf_rs::Robot,
    source: &Source<'_>,
    remarks: Vec<Remark>,
) -> Vec<ImportNote> {
    let joints = robot.joints.iter().enumerate();
    let joints: HashMap<&str, usize> = joints.map(|(j, joint)| (joint.name.as_str(), j)).collect();
    let note = |remark: Remark| {
        let joint = remark.joint.as_deref().and_then(|name| joints.get(name));
        let part = joint.map_or(Part::Robot, |&j| Part::Joint(j));
        source.note(context, robot, part, remark.reason)
    };
    remarks.into_iter().map(note).collect()
}
