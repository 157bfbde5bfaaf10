//! Contacts where no files are read: without the feature `formats`.

use super::{ContactLaw, ContactOptions, Contacts, NoMeshes, Terrain};
use crate::error::OutOfMemory;
use crate::model::Model;

impl Contacts<f64> {
    /// Makes contacts as [`new`](Self::new) does, with options for how shapes become points. Meshes have none, and are among
    /// [`shapes_without_points`](Self::shapes_without_points). Allocates.
    ///
    /// # Errors
    /// If the points would need more memory than the [limit](crate::memory).
    ///
    /// # Panics
    /// If a number of the law or of the terrain is outside of its domain.
    pub fn with_options(
        model: &Model,
        terrain: Terrain,
        law: ContactLaw,
        options: &ContactOptions,
    ) -> Result<Self, OutOfMemory> {
        Self::with_meshes(model, terrain, law, options, &mut NoMeshes)
    }
}
