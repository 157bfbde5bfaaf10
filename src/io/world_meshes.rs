//! Meshes from files as objects of worlds.

use std::path::Path;

use super::hardware_meshes::Solids;
use crate::error::EditError;
use crate::model::{Geometry, Object, UpAxis, World};

impl World {
    /// Adds an object with the shape of a mesh file, STL, OBJ or COLLADA, in the frame of the file. The file is read if the object has mass; its
    /// surface must then be closed.
    ///
    /// * `scale` – factors along the axes
    ///
    /// # Errors
    /// As for [`add_box`](Self::add_box), and if the mesh of an object with mass cannot be read or is not closed.
    pub fn add_mesh(
        &mut self,
        name: &str,
        path: impl AsRef<Path>,
        scale: [f64; 3],
        object: &Object,
    ) -> Result<&mut Self, EditError> {
        let path = path.as_ref();
        let mesh = Geometry::Mesh {
            uri: path.display().to_string(),
            path: Some(path.to_owned()),
            scale,
            up_axis: UpAxis::default(),
        };
        self.add_shape(name, mesh, object, &mut Solids::default())
    }
}
