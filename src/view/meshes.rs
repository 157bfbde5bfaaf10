//! The shapes of descriptions for the HTML viewer, each mesh file once.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::HashMap;

use nalgebra::Vector3;
use serde::Serialize;

use super::mesh::{self, Mesh};
use crate::io::mesh::{MeshFile, Remarks};
use crate::model::Geometry;
use crate::scalar::MapEach;
use crate::spatial::Transform;

/// Edge of the box that replaces a mesh that cannot be shown, m.
const PLACEHOLDER: f64 = 0.1;

/// Colour of a placeholder: that of a warning.
const PLACEHOLDER_COLOR: [f64; 4] = [0.85, 0.3, 0.55, 0.6];

/// A piece of the drawing, centred at its own origin.
#[derive(Debug, Serialize)]
pub(super) struct Piece {
    pub(super) shape: Solid,
    /// Sizes: of a box the edges, of a mesh half of them, of the others radius, radius, length along z
    /// (of the cylinder).
    pub(super) size: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mesh: Option<usize>,
}

/// Kind of solid that a piece is.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Solid {
    Box,
    Sphere,
    Cylinder,
    Capsule,
    Mesh,
}

/// All meshes of a viewer, with remarks.
#[derive(Debug, Default)]
pub(super) struct Meshes {
    pub(super) meshes: Vec<Mesh>,
    warnings: Vec<String>,
    remarks: Remarks,
    /// The parts of a file, as indices in `meshes`; `None` if it cannot be shown.
    of_file: HashMap<MeshFile, Option<std::ops::Range<usize>>>,
}

/// A piece at its pose in the frame of the shape, with its colour in the mesh file.
type Placed = (Transform<f64>, Piece, Option<[f64; 4]>);

impl Piece {
    /// A shape that is not a mesh.
    pub(super) fn of(geometry: &Geometry) -> Self {
        let (shape, size) = match *geometry {
            Geometry::Box { size } => (Solid::Box, size),
            Geometry::Sphere { radius } => (Solid::Sphere, [radius; 3]),
            Geometry::Ellipsoid { size } => (Solid::Sphere, size.map_each(|x| 0.5 * x)),
            Geometry::Cylinder { radius, length } => (Solid::Cylinder, [radius, radius, length]),
            Geometry::Capsule { radius, length } => (Solid::Capsule, [radius, radius, length]),
            Geometry::Mesh { .. } => (Solid::Box, [PLACEHOLDER; 3]),
        };
        Self {
            shape,
            size,
            mesh: None,
        }
    }
}

impl Meshes {
    /// Pieces to draw for a shape.
    ///
    /// * `owner` – whose it is, for warnings
    pub(super) fn pieces(&mut self, owner: &str, geometry: &Geometry) -> Vec<Placed> {
        let Geometry::Mesh { uri, scale, .. } = geometry else {
            return vec![(Transform::identity(), Piece::of(geometry), None)];
        };
        let parts = match MeshFile::of(geometry) {
            Some((uri, file)) => self.parts(owner, uri, file),
            None => {
                self.warn(owner, uri, "is not found");
                None
            }
        };
        let Some(parts) = parts else {
            let color = Some(PLACEHOLDER_COLOR);
            return vec![(Transform::identity(), Piece::of(geometry), color)];
        };
        parts.map(|i| self.piece(i, *scale)).collect()
    }

    /// A surface that is in no file, with the place of its middle.
    pub(super) fn surface(&mut self, mesh: Mesh) -> (Vector3<f64>, Piece) {
        self.meshes.push(mesh);
        let (X, piece, _) = self.piece(self.meshes.len() - 1, [1.0; 3]);
        (X.translation, piece)
    }

    fn piece(&self, i: usize, scale: [f64; 3]) -> Placed {
        let Mesh { bounds, color, .. } = &self.meshes[i];
        let corner = |k: usize| Vector3::from(bounds[k]).map(f64::from);
        let scale = Vector3::from(scale);
        let center = (corner(0) + corner(1)).component_mul(&scale) * 0.5;
        let piece = Piece {
            shape: Solid::Mesh,
            size: (corner(1) - corner(0))
                .component_mul(&scale)
                .scale(0.5)
                .into(),
            mesh: Some(i),
        };
        let color = color.map(|color| color.map(f64::from));
        (Transform::from_translation(center), piece, color)
    }

    /// Finds the parts of a file, which is read once. It is called as the description calls it: a page that is passed
    /// on does not reveal where its files were.
    fn parts(&mut self, owner: &str, uri: &str, file: MeshFile) -> Option<std::ops::Range<usize>> {
        if let Some(known) = self.of_file.get(&file) {
            return known.clone();
        }
        let parts = match mesh::load(uri, &file, &mut self.remarks) {
            Ok(parts) => {
                let first = self.meshes.len();
                self.meshes.extend(parts);
                Some(first..self.meshes.len())
            }
            Err(reason) => {
                self.warn(owner, uri, &reason);
                None
            }
        };
        self.of_file.insert(file, parts.clone());
        parts
    }

    /// Warnings and remarks about the meshes so far.
    pub(super) fn warnings(&self) -> Vec<String> {
        let remarks = self.remarks.sentences();
        self.warnings.iter().cloned().chain(remarks).collect()
    }

    fn warn(&mut self, owner: &str, mesh: &str, reason: &str) {
        let text = format!("{owner}: a box replaces the mesh \"{mesh}\", which {reason}");
        self.warnings.push(text);
    }
}
