//! Mesh files.
//!
//! A page shows them, contact stands on their hulls, of which it gets the vertices only. One file per format reads STL,
//! OBJ with its materials, and COLLADA into a [`soup`] of triangles. They are readers of the project's own: what is
//! wanted of a file is a fraction of what it can hold, and it may come from anyone. So every reader
//!
//! * takes time and memory in proportion to the bytes of the file, whatever they are: no count in it is believed, no
//!   table is walked twice, nothing is recursive;
//! * ends in triangles or in a reason, never in a panic;
//! * opens no other file but the materials of an OBJ, below the folder of that.
//!
//! | bound | where |
//! |---|---|
//! | [64 MiB](crate::input::MAX_TEXT_BYTES) a mesh | `input` |
//! | attributes, name spaces, document types of XML | `input` |
//! | 32 files of materials, 1 MiB each | [`obj`] |
//! | 100,000 nodes and 200,000 triangles that a COLLADA file draws once more than it writes them | [`collada`] |

mod collada;
mod file;
mod material_library;
mod obj;
mod remarks;
mod soup;
mod stl;

pub(crate) use file::MeshFile;
pub(crate) use remarks::Remarks;
pub(crate) use soup::{Mesh, Part};
