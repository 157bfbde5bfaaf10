//! The reader of MJCF files, the XML of `MuJoCo`.
//!
//! Steps: [include] reads all files into one [tree], [documents] adds attached models, [defaults] and [compiler] define the values; [walk] finds the
//! elements of bodies with their poses and names, [body] reads them, [assemble] makes links and joints. The other [sections] become a [scene]. At the
//! end, [unused] lists content that was not read.
//!
//! | in MJCF | here |
//! |---|---|
//! | several joints of a body | joints, separated by links without inertia, `JOINT::link` |
//! | `ref` of a hinge or slide | in the placement of the joint: coordinates are those of `qpos` |
//! | single free body on the world | floating base, as for a URDF robot |
//! | several bodies on the world | a link `world`; free joints are joints of kind floating |
//! | site | frame |
//! | geom of group 0 to 2 | visual |
//! | geom with `contype` or `conaffinity` | collision |
//! | first plane or level height field of the world | the ground of [`MjcfContacts`] |
//! | other planes and height fields of the world | collision shapes of the link `world` |
//! | `gravcomp` between 0 and 1 | a second link, `BODY::balanced`, without weight |
//!
//! # References
//! The XML reference of `MuJoCo` 3 and 4; unspecified details were measured with its library 4.0.0.

mod actuator;
mod actuator_force;
mod actuator_joint;
mod actuator_law;
mod actuator_mount;
mod assemble;
mod assets;
mod body;
mod body_names;
mod body_shapes;
mod builtin;
mod builtin_spheres;
mod builtin_surface;
mod compiler;
mod contact;
mod content;
mod defaults;
mod documents;
mod entry;
mod equality;
mod equality_ends;
mod equality_inertia;
mod geom;
mod geom_inertia;
mod geom_mass;
mod ground;
mod height_field;
mod height_file;
mod include;
mod inertial;
mod inputs;
mod joint;
mod keyframe;
mod mesh_inertia;
mod naming;
mod option;
mod orientation;
mod pairs;
mod reference;
mod reference_kinds;
mod references;
mod scene;
mod scenery;
mod sections;
mod sensor;
mod simulator;
mod site;
mod softness;
mod solids;
mod solver_parameters;
mod springs;
mod superquadrics;
mod surfaces;
mod tendon;
#[cfg(test)]
mod tests;
mod touching;
mod transmission;
mod tree;
mod unused;
mod vertices;
mod walk;

use std::path::Path;

use super::ModelOptions;
use super::context::Context;
use super::report::ImportReport;
use crate::error::LoadError;
use documents::Source;
use include::Files;

pub use scene::{
    MjcfActuator, MjcfContacts, MjcfGeom, MjcfKeyframe, MjcfOptions, MjcfPair, MjcfScene,
    MjcfTendon, MjcfTransmission,
};

/// Loads a description from text; `file` is what errors and the report call its source, `path` where it is, if it is in a file.
pub(super) fn load(
    file: &str,
    text: &str,
    path: Option<&Path>,
    options: &ModelOptions,
) -> Result<(MjcfScene, ImportReport), LoadError> {
    let path = path.and_then(|path| std::path::absolute(path).ok());
    let mut files = Files::new(options);
    let documents = documents::read(&mut files, file, text, path.as_deref())?;
    let mut context = Context::new(file, text);
    context.ignored = files.ignored;
    let sources = documents
        .iter()
        .map(|document| Source::of(document, options));
    let sources = sources.collect::<Result<Vec<_>, _>>()?;
    let loaded = content::read(&sources, options, &mut context)?;
    for document in &documents {
        unused::note(&document.tree, &mut context);
    }
    Ok(loaded.finish(context))
}
