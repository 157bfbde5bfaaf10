//! The reader of URDF files.
//!
//! Three steps: the [guard](super::guard) parses the XML, with positions; [`document`] checks every element, reports what is not used and writes
//! a text of what is; `urdf-rs` reads that text and [`convert`] makes the parts of a model of it. What `urdf-rs` would drop
//! (a word among numbers), confuse (no limit and a limit of zero) or refuse (an empty texture) never reaches it.

mod convert;
mod document;
mod joint;
mod link;
mod schema;
#[cfg(test)]
mod tests;

use std::collections::HashMap;

use super::ModelOptions;
use super::context::{Context, Node};
use super::guard;
use super::massless;
use super::mesh_path::MeshFinder;
use super::report::{ImportReport, report};
use crate::error::LoadError;
use crate::model::{DEFAULT_GRAVITY, Model};
use document::Document;

/// Loads a robot from text; `file` is what errors and the report call its source.
pub(super) fn load(
    file: &str,
    text: &str,
    options: &ModelOptions,
    meshes: &mut MeshFinder,
) -> Result<(Model, ImportReport), LoadError> {
    let xml = guard::parse(file, text, "robot")?;
    let mut context = Context::new(file, text);
    let document = document::read(&mut context, xml.root_element())?;
    let robot = convert::parse(file, &document.text)?;
    let builder = convert::convert(&mut context, &document, &robot, meshes, options.mimicry)
        .with_gravity(options.gravity.unwrap_or(DEFAULT_GRAVITY));
    let model = options.build(builder)?;
    warn_of_massless_links(&mut context, &document, xml.root_element(), &model);
    let report = report(context, options.base, &model);
    Ok((model, report))
}

fn warn_of_massless_links(
    context: &mut Context<'_>,
    document: &Document<'_>,
    robot: Node<'_>,
    model: &Model,
) {
    let remarks = massless::remarks(model);
    if remarks.is_empty() {
        return;
    }
    let joints = document.joints.iter();
    let joints: HashMap<&str, Node<'_>> = joints
        .filter_map(|joint| Some((joint.node.attribute("name")?, joint.node)))
        .collect();
    for remark in remarks {
        let joint = remark.joint.as_deref().and_then(|name| joints.get(name));
        context.warn(joint.copied().unwrap_or(robot), remark.reason);
    }
}
