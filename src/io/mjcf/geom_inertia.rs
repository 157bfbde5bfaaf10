//! Inertias of geoms.

use nalgebra::Vector3;

use super::assets::MeshAsset;
use super::geom::{Geom, Shape};
use super::geom_mass::Material;
use super::solids::{self, Distribution};
use crate::model::{Geometry, short_reference};
use crate::spatial::{Inertia, Symmetric3};

impl Geom {
    /// The inertia of a geom in its parent; reads the file of a mesh.
    ///
    /// # Errors
    /// The reason why it is not known.
    pub(super) fn inertia(&self) -> Result<Inertia<f64>, String> {
        let Material {
            mass,
            density,
            is_shell,
        } = self.material;
        let distribution = match &self.shape {
            _ if self.material.is_nothing() => None,
            Shape::Simple(geometry) if is_shell => solids::shell(geometry),
            Shape::Simple(geometry) => solids::solid(geometry),
            Shape::Mesh(mesh) => return self.mesh_inertia(mesh),
            Shape::Plane | Shape::Heights(_) | Shape::None(_) => None,
        };
        let own = distribution.map(|Distribution { measure, moments }| {
            let mass = mass.unwrap_or(density * measure);
            let moments = Symmetric3::diagonal(&(Vector3::from(moments) * mass));
            Inertia::from_com(mass, &Vector3::zeros(), &moments)
        });
        Ok(own.map_or_else(Inertia::zero, |own| self.X.inertia(&own)))
    }

    fn mesh_inertia(&self, mesh: &MeshAsset) -> Result<Inertia<f64>, String> {
        let Geometry::Mesh { uri, .. } = &mesh.geometry else {
            return Ok(Inertia::zero());
        };
        let uri = short_reference(uri);
        let without = |reason: String| {
            format!(
                "the mesh \"{uri}\" {reason}, so that it has no mass here: give the body an <inertial>"
            )
        };
        if self.material.is_shell {
            return Err(without("is a shell".into()));
        }
        let solid = mesh.solid().map_err(without)?;
        let mass = self.material.mass.map(|mass| mass / solid.mass);
        let own = solid.scaled(mass.unwrap_or(self.material.density));
        Ok(self.X.inertia(&own))
    }
}
