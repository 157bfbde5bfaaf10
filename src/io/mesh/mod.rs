//! Mesh files.
//!
//! The HTML viewer shows meshes, and contact uses the vertices of their hulls. One file per format reads STL, OBJ with its materials, COLLADA and
//! MSH into a [`soup`] of triangles. The readers are part of this crate, because they need only a fraction of each format, and files may be untrusted. So
//! each reader
//!
//! * takes time and memory in proportion to the file size for any content: it trusts no count, traverses no table twice, and does not recurse;
//! * returns triangles or a reason, and never panics;
//! * opens no other file except the materials of an OBJ, below its folder.
//!
//! | bound | where |
//! |---|---|
//! | [64 MiB](crate::input::MAX_TEXT_BYTES) per mesh | `input` |
//! | attributes, name spaces, document types of XML | `input` |
//! | 32 files of materials, 1 MiB each | [`obj`] |
//! | 100,000 nodes and 200,000 triangles that a COLLADA file repeats | [`collada`] |

mod collada;
mod file;
mod inline;
mod material_library;
mod msh;
mod obj;
mod remarks;
mod soup;
mod stl;

pub(crate) use file::MeshFile;
pub(crate) use inline::{is_inline, percent_decoded, reference};
pub(crate) use remarks::Remarks;
pub(crate) use soup::{Mesh, Part};

/// The convex hull of some vertices, or the reason why there is none.
pub(crate) fn hull(vertices: Vec<[f32; 3]>) -> Result<Mesh, String> {
    soup::Soup::hull(vertices)?.finish()
}
