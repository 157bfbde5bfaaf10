//! Contact of robots with meshes: reads the files that their collision shapes name, when a simulation asks for contact.

use std::collections::HashMap;

use super::mesh::{MeshFile, Remarks};
use crate::contact::{
    CollisionOptions, ContactLaw, ContactOptions, Contacts, LinkShapes, MeshHulls, Terrain,
};
use crate::error::{OutOfMemory, UnknownName};
use crate::model::{Geometry, Model};
use crate::spatial::geometry::hull;

impl Contacts<f64> {
    /// Makes contacts as [`new`](Self::new) does, with options for how shapes become points. Reads the mesh files of
    /// collision shapes, each once; those that cannot be read have no points and are among
    /// [`shapes_without_points`](Self::shapes_without_points). Allocates.
    ///
    /// # Errors
    /// If the points would need more memory than the [limit](crate::memory).
    ///
    /// # Panics
    /// If a number of the law or of the terrain makes no sense, as in [`new`](Self::new).
    pub fn with_options(
        model: &Model,
        terrain: Terrain,
        law: ContactLaw,
        options: &ContactOptions,
    ) -> Result<Self, OutOfMemory> {
        Self::with_meshes(model, terrain, law, options, &mut Hulls::default())
    }

    /// Lets bodies touch each other, by their collision shapes and one law. Meshes are their convex hulls, from their files. Allocates.
    ///
    /// Robots and objects collide with one another: links between which there is no joint but floating ones and those on the root link `world`. Links of one
    /// robot collide with [`CollisionOptions::with_self_collision`]; those that a joint connects never do.
    ///
    /// Which features of shapes are near is found anew in each step, up to eight points for two shapes; distance, points and normal are exact, with all derivatives.
    /// Collision shapes of which there is no convex shape are among [`shapes_without_points`](Self::shapes_without_points).
    ///
    /// * `law` – of all pairs, of the kind of the law of the ground
    ///
    /// # Errors
    /// If the model has no link of a name in the options, or a link with a material has no shape.
    ///
    /// # Panics
    /// If the law is of another kind than those of points with the ground, if a number of it or of a material makes no sense, if a link with a surface moves, or if
    /// the contacts are those of another robot.
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
    /// The collision shapes of a robot, with the hulls of the mesh files that they name. Each file is read once; those that cannot be read are
    /// [`missing`](Self::missing). Allocates.
    pub fn new(model: &Model) -> Self {
        Self::with_meshes(model, &mut Hulls::default())
    }
}

/// The vertices of the hulls of mesh files, each file once, or what is wrong with it.
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
        let vertices = mesh.parts.into_iter().flat_map(|part| part.vertices);
        let hull = hull(&Vec::from_iter(vertices))?;
        self.remarks.add(uri, hull.remark.as_slice());
        Ok(hull.vertices)
    }
}
