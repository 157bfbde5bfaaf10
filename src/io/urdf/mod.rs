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

use std::collections::HashSet;

use super::ModelOptions;
use super::context::Context;
use super::guard;
use super::mesh_path::MeshFinder;
use super::report::{ImportReport, report};
use crate::error::LoadError;
use crate::model::{DEFAULT_GRAVITY, Joint, Model};
use crate::spatial::Inertia;
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
    warn_of_massless_bodies(&mut context, &document, &model);
    let report = report(context, &model);
    Ok((model, report))
}

/// A body without inertia moves by what it carries, which may line up so that nothing resists.
fn warn_of_massless_bodies(context: &mut Context<'_>, document: &Document<'_>, model: &Model) {
    let is_massless = |joint: &&Joint| model.body(joint.body).inertia == Inertia::zero();
    let massless = model.joints().iter().filter(is_massless);
    let massless: HashSet<&str> = massless.map(|joint| joint.name.as_str()).collect();
    for joint in &document.joints {
        let name = joint.node.attribute("name").unwrap_or_default();
        if massless.contains(name) {
            let reason =
                "the link that it moves has no inertia: only what that one carries resists";
            context.warn(joint.node, reason);
        }
    }
}
