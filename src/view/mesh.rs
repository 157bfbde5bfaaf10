//! Meshes for the HTML viewer.
//!
//! A mesh that cannot be shown is replaced by a box, with a warning.

use serde::{Serialize, Serializer};

use super::blob::Blob;
use crate::io::mesh::{MeshFile, Part, Remarks};
use crate::scalar::MapEach;

/// Maximum number of triangles of a mesh: more would make the viewer slow and large, 30 bytes each.
const MAX_TRIANGLES: usize = 200_000;

/// Triangles of one colour.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Mesh {
    /// Corners of the box around the vertices: least, largest, m before the scale of the description.
    pub(super) bounds: [[f32; 3]; 2],
    /// Coordinates, from −1 at the least corner to 1 at the largest.
    #[serde(serialize_with = "as_units")]
    pub(super) positions: Vec<[f64; 3]>,
    /// Vertices of the triangles.
    #[serde(serialize_with = "as_triples")]
    pub(super) triangles: Vec<[u32; 3]>,
    /// The colour in the file, red, green, blue, opacity.
    pub(super) color: Option<[f32; 4]>,
}

/// Reads the parts of a mesh, or returns the reason why it cannot be shown.
///
/// * `uri` – the reference in the description, for remarks
pub(super) fn load(uri: &str, file: &MeshFile, remarks: &mut Remarks) -> Result<Vec<Mesh>, String> {
    let mesh = file.read()?;
    remarks.add(uri, &mesh.remarks);
    let parts = mesh.parts;
    let triangles: usize = parts.iter().map(|part| part.triangles.len()).sum();
    if triangles > MAX_TRIANGLES {
        return Err(format!(
            "has {triangles} triangles, more than {MAX_TRIANGLES}"
        ));
    }
    let mesh = |part: Part| Mesh::new(part.vertices, part.triangles, part.color);
    Ok(parts.into_iter().map(mesh).collect())
}

impl Mesh {
    /// Triangles between vertices (m).
    pub(super) fn new(
        vertices: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        color: Option<[f32; 4]>,
    ) -> Self {
        let of = |axis: usize| vertices.iter().map(move |vertex| vertex[axis]);
        let least = [0, 1, 2].map_each(|axis| of(axis).fold(f32::INFINITY, f32::min));
        let largest = [0, 1, 2].map_each(|axis| of(axis).fold(f32::NEG_INFINITY, f32::max));
        let unit = |axis: usize, x: f32| {
            let (least, largest) = (f64::from(least[axis]), f64::from(largest[axis]));
            let width = largest - least;
            if width > 0.0 {
                2.0 * (f64::from(x) - least) / width - 1.0
            } else {
                0.0
            }
        };
        let units = vertices
            .iter()
            .map(|v| [0, 1, 2].map(|axis| unit(axis, v[axis])));
        Self {
            bounds: [least, largest],
            positions: units.collect(),
            triangles,
            color,
        }
    }
}

fn as_units<S: Serializer>(numbers: &[[f64; 3]], out: S) -> Result<S::Ok, S::Error> {
    Blob::unit(numbers.iter().flatten().copied()).serialize(out)
}

fn as_triples<S: Serializer>(numbers: &[[u32; 3]], out: S) -> Result<S::Ok, S::Error> {
    Blob::u32(numbers.iter().flatten().copied()).serialize(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::temporary::Folder;
    use crate::model::UpAxis;
    use std::path::PathBuf;

    const OBJ: &str = "v 0 0 0\nv 2 0 0\nv 0 3 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

    fn load(path: PathBuf) -> Result<Vec<Mesh>, String> {
        let up_axis = UpAxis::Auto;
        super::load("", &MeshFile::at(path, up_axis), &mut Remarks::default())
    }

    #[test]
    fn positions_are_units_of_the_box_around_the_vertices() {
        let folder = Folder::new();
        let mesh = &load(folder.write("t.obj", OBJ)).unwrap()[0];
        assert_eq!(mesh.bounds, [[0.0; 3], [2.0, 3.0, 4.0]]);
        assert_eq!(mesh.positions.len(), 4);
        assert!(mesh.positions.contains(&[1.0, -1.0, -1.0]));
    }

    #[test]
    fn huge_meshes_are_not_shown() {
        let many = "f 1 2 3\n".repeat(MAX_TRIANGLES + 1);
        let folder = Folder::new();
        let reason = load(folder.write("many.obj", format!("{OBJ}{many}"))).unwrap_err();
        assert_eq!(reason, "has 200005 triangles, more than 200000");
    }
}
