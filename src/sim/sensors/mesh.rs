//! Triangle meshes that range finders see.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::Vector3;

use crate::collision::{Bounds, BroadPhase, Surface};
use crate::memory;
use crate::model::{Geometry, UpAxis};
use crate::scalar::MapEach;

/// Bytes of a triangle with its boxes and those above it.
const TRIANGLE_BYTES: usize = 3 * size_of::<u32>() + 6 * size_of::<Bounds>();

/// The triangles of a mesh in a tree of boxes, in the frame of the file.
#[derive(Debug)]
pub(crate) struct MeshTree {
    surface: Surface,
    tree: BroadPhase,
}

impl MeshTree {
    /// Makes the tree of a mesh. Allocates; O(n log n).
    ///
    /// # Errors
    /// If the mesh has no triangle with an area, or the tree needs more memory than the limit: the end of a sentence "the mesh …".
    pub(crate) fn new(
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Arc<Self>, String> {
        let n = triangles.len();
        let what = format_args!("boxes of the {n} triangles of a mesh");
        let checked = memory::check(what, n.saturating_mul(TRIANGLE_BYTES));
        checked.map_err(|error| format!("is too large: {error}"))?;
        let surface = Surface::new(vertices, triangles);
        let surface = surface.map_err(|error| format!("cannot be seen: {error}"))?;
        let bounds = (0..surface.triangles().len()).map(|k| around(&corners(&surface, k)));
        let tree = BroadPhase::of_fixed(&bounds.collect::<Vec<_>>());
        Ok(Arc::new(Self { surface, tree }))
    }

    /// The boxes of the triangles.
    pub(super) fn boxes(&self) -> &BroadPhase {
        &self.tree
    }

    /// The corners of a triangle, by the index of its box.
    pub(super) fn corners(&self, triangle: usize) -> [Vector3<f64>; 3] {
        corners(&self.surface, triangle)
    }
}

#[cfg(not(feature = "formats"))]
impl MeshTree {
    /// Reads no files.
    fn of_file(_: &Geometry) -> Result<Arc<Self>, String> {
        Err("is not read".into())
    }
}

/// Result of reading a mesh, or the reason why it is not seen, as an end of the sentence "the mesh …".
type FoundMesh = Result<Arc<MeshTree>, String>;

/// Trees of mesh files, by their path, or else by their reference; each file is read once.
#[derive(Debug, Default)]
pub(super) struct MeshFiles {
    found: HashMap<(PathBuf, UpAxis), FoundMesh>,
}

impl MeshFiles {
    /// The tree of a mesh, without its scale.
    pub(super) fn tree(&mut self, mesh: &Geometry) -> FoundMesh {
        let Geometry::Mesh {
            uri, path, up_axis, ..
        } = mesh
        else {
            return Err("is not found".into());
        };
        let name = path.clone().unwrap_or_else(|| uri.into());
        let found = self.found.entry((name, *up_axis));
        found.or_insert_with(|| MeshTree::of_file(mesh)).clone()
    }
}

fn corners(surface: &Surface, triangle: usize) -> [Vector3<f64>; 3] {
    surface.triangles()[triangle].map_each(|k| surface.vertices()[k as usize])
}

fn around([a, b, c]: &[Vector3<f64>; 3]) -> Bounds {
    Bounds {
        low: a.inf(b).inf(c),
        high: a.sup(b).sup(c),
    }
}
