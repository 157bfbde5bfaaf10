//! Range finders that see meshes: reads the mesh files of collision shapes.

use std::sync::Arc;

use nalgebra::Vector3;

use super::mesh::MeshFile;
use crate::model::Geometry;
use crate::sim::MeshTree;

impl MeshTree {
    /// Reads the triangles of a mesh, without its scale.
    ///
    /// # Errors
    /// If there are none, with the reason as an end of the sentence "the mesh …".
    pub(crate) fn of_file(mesh: &Geometry) -> Result<Arc<Self>, String> {
        let (_, file) = MeshFile::of(mesh).ok_or("is not found")?;
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for part in file.read()?.parts {
            let first = vertices.len() as u32;
            let corners = part.vertices.iter();
            vertices.extend(corners.map(|v| Vector3::from(*v).map(f64::from)));
            let own = part.triangles.iter();
            triangles.extend(own.map(|corners| corners.map(|k| first + k)));
        }
        Self::new(vertices, triangles)
    }
}
