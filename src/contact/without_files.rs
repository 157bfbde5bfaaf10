//! Contacts where no files are read: without the feature `formats`.

use super::{ContactLaw, ContactOptions, Contacts, NoMeshes, Terrain};
use crate::error::OutOfMemory;
use crate::model::Model;

impl Contacts<f64> {
    /// Makes contacts as [`new`](Self::new), with options for converting shapes to points. Meshes get no points;
    /// [`shapes_without_points`](Self::shapes_without_points) lists them. Allocates.
    ///
    /// # Errors
    /// If the points would need more memory than the [limit](crate::memory).
    ///
    /// # Panics
    /// If a parameter of the contact model or of the terrain is out of range.
    pub fn with_options(
        model: &Model,
        terrain: Terrain,
        law: ContactLaw,
        options: &ContactOptions,
    ) -> Result<Self, OutOfMemory> {
        Self::with_meshes(model, terrain, law, options, &mut NoMeshes)
    }
}
