//! Robots from description files.
//!
//! [`Model::from_urdf_file`](crate::Model::from_urdf_file), [`Model::from_sdf_file`](crate::Model::from_sdf_file),
//! [`Model::from_mjcf_file`](crate::Model::from_mjcf_file) and their `_str` twins load a robot in one call; [`ModelOptions`] says how it stands in the world and returns, beside
//! the model, an [`ImportReport`] of everything that the file holds and the model does not use. Loading starts no
//! program, reads no meshes (but those that give bodies of an MJCF their mass) and never panics on a bad file.
//!
//! | question | function | cost |
//! |---|---|---|
//! | load a robot from a URDF? | [`Model::from_urdf_file`](crate::Model::from_urdf_file), [`from_urdf_str`](crate::Model::from_urdf_str) | linear in the text |
//! | from what [`urdf_rs`] has read, or a program made of its types? | [`Model::from_urdf`](crate::Model::from_urdf) | linear in links and joints |
//! | from an SDF, with what it includes? | [`Model::from_sdf_file`](crate::Model::from_sdf_file), [`from_sdf_str`](crate::Model::from_sdf_str) | linear in the texts |
//! | from an MJCF, with what it includes and attaches? | [`Model::from_mjcf_file`](crate::Model::from_mjcf_file), [`from_mjcf_str`](crate::Model::from_mjcf_str) | linear in the texts and in what replicas add |
//! | with its motors, keyframes, equalities, ground? | [`MjcfScene`], [`Simulator::from_mjcf_file`](crate::Simulator::from_mjcf_file) | the same |
//! | how does it stand, what is it to leave out, where are its packages? | [`ModelOptions`] | |
//! | what does the file hold that the model does not use? | [`ImportReport`] | |
//! | one that somebody else wrote? | [`ModelOptions::with_root`] | |
//! | links that move and have no inertia? | [`MasslessLinks`] | |
//! | write it? | [`Model::to_urdf`](crate::Model::to_urdf), [`Model::to_mjcf`](crate::Model::to_mjcf) | linear in the robot; the latter reads its meshes |
//! | which links do not collide, by an SRDF? | [`CollisionOptions::with_srdf_file`](crate::contact::CollisionOptions::with_srdf_file) | linear in the text |
//! | meshes in contact with the ground? | [`Contacts::new`](crate::contact::Contacts::new), which is written here | linear in the files, each read once |
//!
//! # What a description can do
//!
//! A description, and all that belongs to it, may come from anyone: none of it makes the program panic, overflow the
//! stack, wait, or take time or memory out of proportion to its size. But it *names files*, and whoever loads, shows or
//! simulates the robot reads them:
//!
//! | what | named in | read by | what of it can be seen |
//! |---|---|---|---|
//! | models of SDF, their `model.config` | `<include>` | loading | the robot, if it is SDF; of anything else, that it is not |
//! | models of MJCF | `<include>`, `<model>` | loading | the robot, if it is MJCF; of anything else, that it is not |
//! | meshes (STL, OBJ, COLLADA) | `<mesh>`, by any path | pages, recordings, contacts, `to_mjcf`; loading of MJCF, where a body has its mass from them | triangles and colours; of anything else, what is wrong and on which line |
//! | materials | `mtllib` in an OBJ | with the mesh | colours; only files below the folder of the mesh are opened |
//! | any file | each of these | – | whether it is there |
//!
//! References may be absolute, lead upwards, through symbolic links, or by `package://` and `model://` to the folders
//! of [`with_search_path`](ModelOptions::with_search_path) and of the environment. **Descriptions from others are
//! therefore to be loaded with [`with_root`](ModelOptions::with_root)**, which restricts all of it to the folders that
//! are given, and says of what is elsewhere only that it is not found. What the model then holds are the paths of
//! allowed files with all links followed, so that pages and contacts open no others, unless someone who may write to
//! those folders changes them in between.
//!
//! Everywhere, files must be regular and of at most 64 MiB, together for all that is included; pipes and devices are
//! refused without being opened, and nothing is fetched from anywhere. Pages call meshes as the description calls them,
//! not by where they were found. A [recording](crate::view::Recording) saved as JSON holds the paths, from its own
//! folder, of meshes that were added to it as [scene objects](crate::view::SceneObject), and one that is read may name
//! any; look through [`Recording::scene_objects`](crate::view::Recording::scene_objects) before showing one from
//! others. [`to_mjcf`](crate::Model::to_mjcf) reads the meshes of the model, no others, and names them by their whole
//! paths.

// A format is a folder: it reads a tree of elements ([`guard`]), reports what it does not use ([`context`], [`schema`]),
// hands links and joints to a `ModelBuilder` and ends in [`ModelOptions::finish`]. What formats share is beside the
// folders: values as attributes or as elements ([`values`]), axes of joints ([`motion`]), shapes ([`shapes`]), rotations
// ([`rotation`]), versions ([`version`]), places for errors and remarks ([`place`]), massless links ([`massless`]), and
// where meshes are ([`mesh_path`]).
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
mod report;
mod roots;
mod rotation;
mod schema;
mod sdf;
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
    MjcfActuator, MjcfContacts, MjcfGeom, MjcfKeyframe, MjcfOptions, MjcfScene, MjcfSensor,
    MjcfTendon, MjcfTransmission,
};
pub use options::ModelOptions;
pub use place::ImportNote;
pub use report::ImportReport;
