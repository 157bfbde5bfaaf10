//! Mesh files, and the convex hull of what is in them.
//!
//! Below everything that needs meshes, and importing nothing: a page shows them, contact stands on their hulls.

mod file;
mod hull;

pub(crate) use file::{Part, read};
pub(crate) use hull::{hull, thinned};
