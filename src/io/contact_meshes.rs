//! Contact of robots with meshes: reads the mesh files of collision shapes.

use std::collections::HashMap;

use super::mesh::{MeshFile, Remarks};
use crate::contact::{
    CollisionOptions, ContactLaw, ContactOptions, Contacts, LinkShapes, MeshHulls, Terrain,
};
use crate::error::{OutOfMemory, UnknownName};
use crate::model::{Geometry, Model};
use crate::nested::IntoNested;
use crate::spatial::geometry::hull;

impl Contacts<f64> {
    /// Makes contacts as [`new`](Self::new), with options for converting shapes to points. Reads each mesh file of collision shapes once; meshes that
    /// cannot be read have no points, and [`shapes_without_points`](Self::shapes_without_points) lists them. Allocates.
    ///
    /// # Errors
    /// If the points would need more memory than the [limit](crate::memory).
    ///
    /// # Panics
    /// If a parameter of the contact model or of the terrain is out of range, as in [`new`](Self::new).
    pub fn with_options(
        model: &Model,
        terrain: Terrain,
        law: ContactLaw,
        options: &ContactOptions,
    ) -> Result<Self, OutOfMemory> {
        Self::with_meshes(model, terrain, law, options, &mut Hulls::default())
    }

    /// Enables contact between bodies, by their collision shapes and one contact model. Meshes are replaced by their convex hulls, from their files. Allocates.
    ///
    /// Robots and objects collide with each other. (Floating joints, and joints on the root link `world`, separate robots.) Links of one robot
    /// collide with [`CollisionOptions::with_self_collision`]; links connected by a joint never do.
    ///
    /// Each step finds the near features of shapes, up to eight points for two shapes; distance, points and normal are exact, with all derivatives.
    /// [`shapes_without_points`](Self::shapes_without_points) lists collision shapes without a convex shape.
    ///
    /// * `law` – contact model of all pairs, of the same kind as that of the ground
    ///
    /// # Errors
    /// If the model has no link with this name in the options, or a link with a material has no shape.
    ///
    /// # Panics
    /// If the contact model differs in kind from that of the ground, a parameter of it or of a material is out of range, a link with a surface moves,
    /// or the contacts belong to another robot.
    ///
    /// # Examples
    /// ```
    /// use dualbody::contact::{CollisionOptions, ContactLaw, Contacts, Rigid, Terrain};
    /// use dualbody::{Simulator, model::samples};
    ///
    /// let (model, law) = (samples::arm(), ContactLaw::Rigid(Rigid::default()));
    /// let options = CollisionOptions::default().with_self_collision();
    /// let contacts = Contacts::new(&model, Terrain::flat(-1.0), law).with_collisions(&model, law, &options)?;
    /// let simulator = Simulator::new(model).with_contacts(contacts);
    /// assert_eq!(simulator.step(&simulator.neutral_state(), &[0.0; 7]).v.len(), 7);
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn with_collisions(
        self,
        model: &Model,
        law: ContactLaw,
        options: &CollisionOptions,
    ) -> Result<Self, UnknownName> {
        self.with_link_shapes(model, law, LinkShapes::new(model), options)
    }
}

impl LinkShapes {
    /// The collision shapes of a robot, with the hulls of their mesh files. Each file is read once; shapes whose file cannot be read are
    /// [`missing`](Self::missing). Allocates.
    pub fn new(model: &Model) -> Self {
        Self::with_meshes(model, &mut Hulls::default())
    }
}

/// The vertices of the hulls of mesh files, each file once, or a reason why it cannot be used.
#[derive(Debug, Default)]
struct Hulls {
    found: HashMap<MeshFile, Result<Vec<[f32; 3]>, String>>,
    remarks: Remarks,
}

impl MeshHulls for Hulls {
    fn vertices(&mut self, mesh: &Geometry) -> Result<&[[f32; 3]], String> {
        let (uri, file) = MeshFile::of(mesh).ok_or("is not found")?;
        if !self.found.contains_key(&file) {
            let hull = self.read(uri, &file);
            self.found.insert(file.clone(), hull);
        }
        self.found[&file].as_deref().map_err(Clone::clone)
    }

    fn remarks(&self) -> Vec<String> {
        self.remarks.sentences().collect()
    }
}

impl Hulls {
    /// * `uri` – the reference in the description, for remarks
    fn read(&mut self, uri: &str, file: &MeshFile) -> Result<Vec<[f32; 3]>, String> {
        let mesh = file.read()?;
        self.remarks.add(uri, &mesh.remarks);
        let vertices = mesh.parts.into_iter().nested(|part| part.vertices);
        let hull = hull(&Vec::from_iter(vertices))?;
        self.remarks.add(uri, hull.remark.as_slice());
        Ok(hull.vertices)
    }
}
