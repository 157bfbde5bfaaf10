//! The reader of SDF files, versions 1.5 to 1.11.
//!
//! Three steps: the [reader] collects models, frames, links and joints of all files, reports what is not used and checks every
//! value; [frames] finds where everything is; [tree] and [assemble] make the parts of a model of it.
//!
//! | `<pose>` of a | is relative to, if nothing else is said |
//! |---|---|
//! | model | the model around it, or the world |
//! | link | its model |
//! | joint | its child |
//! | frame | what it is attached to, or else its model |
//! | inertial, visual, collision | its link |
//!
//! Names of parts of nested models are `model::part`; those of merged ones have no prefix. A static model is fixed to the world,
//! link by link. Joints of a [world] hold the robot or join other models to it.

mod assemble;
mod frames;
mod include;
mod joint;
mod link;
mod pose;
mod reader;
mod scene;
mod schema;
mod select;
#[cfg(test)]
mod tests;
mod tree;
mod values;
mod version;
mod world;

use std::collections::HashMap;
use std::path::Path;

use super::ModelOptions;
use super::context::Context;
use super::guard;
use super::massless;
use super::mesh_path::MeshFinder;
use super::report::{ImportReport, report};
use crate::error::LoadError;
use crate::model::{DEFAULT_GRAVITY, Model};
use reader::{Reader, Shared};
use scene::{Place, Scene};
use version::Version;

/// Loads a robot from text; `file` is what errors and the report call its source, `path` where it is, if it is in a file.
pub(super) fn load(
    file: &str,
    text: &str,
    path: Option<&Path>,
    options: &ModelOptions,
) -> Result<(Model, ImportReport), LoadError> {
    let xml = guard::parse(file, text, "sdf")?;
    let root = xml.root_element();
    let mut context = Context::new(file, text);
    super::schema::check(&mut context, root, &schema::ROOT)?;
    let version = Version::read(&mut context, root)?;
    let mut shared = Shared {
        scene: Scene::new(Place::new(&context, root)),
        options,
        open: path
            .and_then(|path| std::path::absolute(path).ok())
            .into_iter()
            .collect(),
        included: 0,
        included_bytes: 0,
        depth: 0,
    };
    let finder = MeshFinder::new(path.and_then(Path::parent), options);
    let mut reader = Reader {
        shared: &mut shared,
        context,
        version,
        finder,
    };
    let robot = select::read(&mut reader, root, options.model_name.as_deref())?;
    let mut context = reader.context;
    let scene = &shared.scene;
    let gravity = options.gravity.or(scene.gravity).unwrap_or(DEFAULT_GRAVITY);
    let builder = assemble::assemble(scene, robot, options, &mut context)?.with_gravity(gravity);
    let model = options.build(builder)?;
    warn_of_massless_links(&mut context, scene, robot, &model);
    let report = report(context, options.base, &model);
    Ok((model, report))
}

fn warn_of_massless_links(context: &mut Context<'_>, scene: &Scene, robot: usize, model: &Model) {
    let remarks = massless::remarks(model);
    if remarks.is_empty() {
        return;
    }
    let mut joints: HashMap<String, &Place> = HashMap::new();
    for (i, joint) in scene.joints.iter().enumerate() {
        for motion in 0..joint.motions.len() {
            let place = &scene.frames[joint.frame].place;
            joints.insert(assemble::motion_name(scene, i, motion), place);
        }
    }
    let whole = &scene.frames[scene.models[robot].frame].place;
    for remark in remarks {
        let joint = remark.joint.as_ref().and_then(|name| joints.get(name));
        context
            .warnings
            .push(joint.unwrap_or(&whole).note(remark.reason));
    }
}
