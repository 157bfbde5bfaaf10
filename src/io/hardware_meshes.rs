//! Design parameters of robots with meshes: reads the files whose volume is needed.

use crate::nested::IntoNested;
use std::collections::HashMap;

use nalgebra::Vector3;

use super::mesh::{Mesh, MeshFile};
use crate::error::EditError;
use crate::model::{Geometry, Hardware, MeshSolids, Model, ScaledLink};
use crate::scalar::MapEach;
use crate::spatial::Inertia;

impl Hardware {
    /// Selects links of a robot and their design parameters. Mesh files are read if their volume is needed: for a density, and for a homogeneous
    /// link. The surface must then be closed.
    ///
    /// # Errors
    /// If a link is unknown or chosen twice, has no such shape or its shape no such size, if a size is zero, if the density is selected for a link
    /// without mass, or for a mesh that cannot be read or is not closed.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Model, model::{Dimension, Hardware, ScaledLink}};
    ///
    /// let file = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/hopper.urdf");
    /// let lengths = ["thigh", "shank"].map(|link| ScaledLink::new(link, &[Dimension::Length]));
    /// let hardware = Hardware::new(&Model::from_urdf_file(file)?, &lengths)?;
    /// let taller = hardware.model(&[0.25_f64, 0.3])?;
    /// assert!((taller.body(taller.joint_body(taller.find_joint("knee")?)).placement.translation.norm() - 0.25).abs() < 1e-15);
    /// assert!(taller.to_urdf()?.contains(r#"length="0.3""#));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(model: &Model, links: &[ScaledLink]) -> Result<Self, EditError> {
        Self::with_meshes(model, links, &mut Solids::default())
    }
}

/// The solids of mesh files, each file once, or a reason why it cannot be used.
#[derive(Debug, Default)]
pub(super) struct Solids {
    found: HashMap<MeshFile, Result<Inertia<f64>, String>>,
}

impl MeshSolids for Solids {
    fn solid(&mut self, mesh: &Geometry) -> Result<Inertia<f64>, String> {
        let (_, file) = MeshFile::of(mesh).ok_or("is not found")?;
        let found = self.found.entry(file.clone());
        found.or_insert_with(|| solid_of(&file.read()?)).clone()
    }
}

/// The solid inside of a closed surface, at density 1.
fn solid_of(mesh: &Mesh) -> Result<Inertia<f64>, String> {
    let triangles: Vec<[[f32; 3]; 3]> = (mesh.parts.iter())
        .nested(|part| {
            let corner = |i: u32| part.vertices[i as usize];
            part.triangles.iter().map(move |t| t.map(corner))
        })
        .collect();
    let open = open_edges(&triangles);
    if open > 0 {
        return Err(format!(
            "is not closed, so that it has no volume: {open} edges have a triangle on one side only"
        ));
    }
    let wide = |p: [f32; 3]| Vector3::from(p.map_each(f64::from));
    let solid = Inertia::solid_polyhedron(1.0, triangles.iter().map(|t| t.map(wide)));
    // Triangles that all face inwards.
    Ok(solid.scaled(solid.mass.signum()))
}

/// Number of edges that are not run through as often one way as the other.
fn open_edges(triangles: &[[[f32; 3]; 3]]) -> usize {
    // Zero has two signs.
    let key = |p: [f32; 3]| p.map_each(|x| (x + 0.0).to_bits());
    let mut balance: HashMap<[[u32; 3]; 2], i64> = HashMap::new();
    for triangle in triangles {
        let corners = triangle.map_each(key);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let (edge, way) = if a < b { ([a, b], 1) } else { ([b, a], -1) };
            *balance.entry(edge).or_default() += way;
        }
    }
    balance.values().filter(|&&balance| balance != 0).count()
}
