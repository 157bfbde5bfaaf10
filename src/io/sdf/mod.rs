//! The reader of SDF files, versions 1.5 to 1.11.
//!
//! Three steps: the [reader] collects models, frames, links and joints of all files, reports what is not used and checks every
//! value; [frames] finds where everything is; [tree] and [assemble] make the parts of a model of it.
//!
//! | `<pose>` of a | is relative to, by default |
//! |---|---|
//! | model | the model around it, or the world |
//! | link | its model |
//! | joint | its child |
//! | frame | what it is attached to, or else its model |
//! | inertial, visual, collision | its link |
//!
//! Names of parts of nested models are `model::part`; those of merged ones have no prefix. A static model is fixed to the world,
//! link by link. Joints of a [world] hold the robot or join other models to it. Where all models are read, the world is the model
//! that has them as parts: each group of links that joints connect and nothing holds is on a floating joint.

mod assemble;
mod entry;
mod frames;
mod include;
mod joint;
mod link;
mod pose;
mod reader;
mod scene;
mod schema;
mod select;
mod sensor;
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
use super::massless::Remark;
use super::mesh_path::MeshFinder;
use super::place::{ImportNote, SourcePlace};
use super::report::ImportReport;
use super::sensors;
use crate::error::LoadError;
use crate::model::{DEFAULT_GRAVITY, Model};
pub(super) use pose::pose_value;
use reader::{Reader, Shared};
use scene::Scene;

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
    let version = version::read(&mut context, root)?;
    let mut shared = Shared {
        scene: Scene::new(context.keep(root)),
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
    let robot = if options.all_models {
        select::read_all(&mut reader, root)?;
        scene::WORLD
    } else {
        select::read(&mut reader, root, options.model_name.as_deref())?
    };
    let mut context = reader.context;
    let scene = &shared.scene;
    let gravity = options.gravity.or(scene.gravity).unwrap_or(DEFAULT_GRAVITY);
    let builder = assemble::assemble(scene, robot, options, &mut context)?.with_gravity(gravity);
    let finished = options.finish(builder, context, |_, remarks| notes(scene, robot, remarks));
    let (model, mut report) = finished?;
    let sensors = scene.sensors.iter();
    let found = sensors.flat_map(|(own, frame)| own.in_model(&model, &scene.frames[*frame].name));
    report.sensors = sensors::with_names(found.collect());
    Ok((model, report))
}

/// Places remarks on joints, or on the whole robot.
fn notes(scene: &Scene, robot: usize, remarks: Vec<Remark>) -> Vec<ImportNote> {
    let mut joints: HashMap<String, &SourcePlace> = HashMap::new();
    for (i, joint) in scene.joints.iter().enumerate() {
        let place = &scene.frames[joint.frame].place;
        joints.insert(scene.frames[joint.frame].name.clone(), place);
        for motion in 0..joint.motions.len() {
            joints.insert(assemble::motion_name(scene, i, motion), place);
        }
    }
    let whole = &scene.frames[scene.models[robot].frame].place;
    let note = |remark: Remark| {
        let joint = remark.joint.as_ref().and_then(|name| joints.get(name));
        joint.unwrap_or(&whole).note(remark.reason)
    };
    remarks.into_iter().map(note).collect()
}
