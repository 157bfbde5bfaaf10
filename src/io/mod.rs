//! Robots from description files.
//!
//! [`Model::from_urdf_file`](crate::Model::from_urdf_file), [`Model::from_sdf_file`](crate::Model::from_sdf_file),
//! [`Model::from_mjcf_file`](crate::Model::from_mjcf_file) and their `_str` counterparts load a robot in one call. [`ModelOptions`] sets the base and
//! other options and returns, with the model, an [`ImportReport`] of all content that the model does not use. Loading starts no program, reads no
//! meshes (except those that determine masses of MJCF bodies) and never panics on a bad file.
//!
//! | question | function | cost |
//! |---|---|---|
//! | load a URDF robot? | [`Model::from_urdf_file`](crate::Model::from_urdf_file), [`from_urdf_str`](crate::Model::from_urdf_str) | linear in the text |
//! | convert a [`urdf_rs`] robot? | [`ModelOptions::load_urdf`] | linear in links and joints |
//! | load an SDF robot, with included files? | [`Model::from_sdf_file`](crate::Model::from_sdf_file), [`from_sdf_str`](crate::Model::from_sdf_str) | linear in the texts |
//! | load an MJCF robot, with included and attached files? | [`Model::from_mjcf_file`](crate::Model::from_mjcf_file), [`from_mjcf_str`](crate::Model::from_mjcf_str) | linear in the texts and in the content of replicas |
//! | load motors, keyframes, equalities, ground? | [`MjcfScene`], [`Simulator::from_mjcf_file`](crate::Simulator::from_mjcf_file) | the same |
//! | inputs of joints from `<ros2_control>` or `<transmission>` of a URDF? | [`Simulator::from_urdf_file`](crate::Simulator::from_urdf_file), [`ImportReport::simulator`] | the same |
//! | set base, kept joints, package paths? | [`ModelOptions`] | |
//! | list content that the model does not use? | [`ImportReport`] | |
//! | load an untrusted description? | [`ModelOptions::with_root`] | |
//! | treat moving links without inertia? | [`MasslessLinks`] | |
//! | write a robot? | [`Model::to_urdf`](crate::Model::to_urdf), [`Model::to_mjcf`](crate::Model::to_mjcf) | linear in the robot; the latter reads its meshes |
//! | exclude link pairs by an SRDF file? | [`CollisionOptions::with_srdf_file`](crate::contact::CollisionOptions::with_srdf_file) | linear in the text |
//! | contact points of meshes? | [`Contacts::new`](crate::contact::Contacts::new) | linear in the files, each read once |
//!
//! # What a description can do
//!
//! A description and its files may be untrusted: they cannot make the program panic, overflow the stack, wait, or take time or memory out of
//! proportion to their size. But a description *references files*, and a program that loads, shows or simulates the robot reads them:
//!
//! | file | referenced in | read by | visible content |
//! |---|---|---|---|
//! | models of SDF, their `model.config` | `<include>` | loading | the robot, if it is SDF; for other files, only that they are not SDF |
//! | models of MJCF | `<include>`, `<model>` | loading | the robot, if it is MJCF; for other files, only that they are not MJCF |
//! | meshes (STL, OBJ, COLLADA, MSH) | `<mesh>`, by any path | HTML viewer, recordings, contacts, `to_mjcf`; loading of MJCF, if they determine the mass of a body | triangles and colours; for other files, the error and its line |
//! | height fields | `<hfield>` of MJCF | loading | heights; for other files, the reason |
//! | materials | `mtllib` in an OBJ | with the mesh | colours; only files below the folder of the mesh are opened |
//! | any file | each of these | – | whether it exists |
//!
//! A mesh reference that begins with `data:model/obj` contains the mesh and opens no file.
//!
//! References may be absolute, relative to parent folders, through symbolic links, or by `package://` and `model://` to the folders of
//! [`with_search_path`](ModelOptions::with_search_path) and of the environment. **So load untrusted descriptions with
//! [`with_root`](ModelOptions::with_root).** It restricts access to the given folders; other files are reported as not found. The model then contains
//! only paths of allowed files with resolved links, so viewer and contacts open no other files, unless a user with write access to the folders
//! changes them in between.
//!
//! All files must be regular files of at most 64 MiB, in total for all included files. Pipes and devices are refused without opening, and nothing is
//! downloaded. The HTML viewer shows the mesh names of the description, not the paths where they were found. A [recording](crate::view::Recording)
//! saved as JSON contains the paths, relative to its folder, of meshes of its [scene objects](crate::view::SceneObject), and an untrusted recording
//! may contain any path: inspect [`Recording::scene_objects`](crate::view::Recording::scene_objects) before showing one.
//! [`to_mjcf`](crate::Model::to_mjcf) reads only the meshes of the model, and writes their absolute paths.

// A format is a folder: it reads a tree of elements ([`guard`]), reports what it does not use ([`context`], [`schema`]),
// passes links and joints to a `ModelBuilder` and ends in [`ModelOptions::finish`]. Shared code is beside the
// folders: values as attributes or as elements ([`values`]), axes of joints ([`motion`]), shapes ([`shapes`]), rotations
// ([`rotation`]), versions ([`version`]), places for errors and remarks ([`place`]), massless links ([`massless`]), and
// mesh paths ([`mesh_path`]).
mod commands;
mod contact_meshes;
mod context;
#[cfg(test)]
mod damage;
mod guard;
mod hardware_meshes;
mod load;
mod massless;
pub(crate) mod mesh;
mod mesh_path;
mod mjcf;
mod motion;
mod names;
mod options;
mod place;
mod range_meshes;
mod report;
mod roots;
mod rotation;
mod schema;
mod sdf;
mod sensors;
mod shapes;
mod srdf;
#[cfg(test)]
pub(crate) mod temporary;
mod urdf;
mod values;
mod version;
mod world_meshes;
mod write;
mod xml;

pub use massless::MasslessLinks;
pub use mjcf::{
    MjcfActuator, MjcfContacts, MjcfGeom, MjcfKeyframe, MjcfOptions, MjcfPair, MjcfScene,
    MjcfTendon, MjcfTransmission,
};
pub use options::ModelOptions;
pub use place::ImportNote;
pub use report::ImportReport;
pub use sensors::ImportedSensor;
