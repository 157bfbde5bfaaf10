//! A mesh file as a whole: which format it is in.

use std::path::{Path, PathBuf};

use super::soup::Mesh;
use super::{collada, inline, msh, obj, stl};
use crate::input::{self, MAX_TEXT_BYTES};
use crate::model::{Geometry, UpAxis, short_reference};

/// A mesh file, and how it is to be read.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct MeshFile {
    source: Source,
    /// Treatment of the up axis that a COLLADA file states.
    up_axis: UpAxis,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Source {
    File(PathBuf),
    /// A reference that [contains](inline) the mesh.
    Reference(String),
}

impl MeshFile {
    /// The file of a mesh, with the reference in the description; `None` if it was not found, and for other shapes.
    pub(crate) fn of(shape: &Geometry) -> Option<(&str, Self)> {
        let Geometry::Mesh {
            uri, path, up_axis, ..
        } = shape
        else {
            return None;
        };
        let source = match path {
            Some(path) => Source::File(path.clone()),
            None if inline::is_inline(uri) => Source::Reference(uri.clone()),
            None => return None,
        };
        let up_axis = *up_axis;
        Some((short_reference(uri), Self { source, up_axis }))
    }

    /// The file at a path.
    #[cfg(test)]
    pub(crate) fn at(path: PathBuf, up_axis: UpAxis) -> Self {
        let source = Source::File(path);
        Self { source, up_axis }
    }

    /// Its path, unless the description itself contains the mesh.
    pub(crate) fn path(&self) -> Option<&Path> {
        match &self.source {
            Source::File(path) => Some(path),
            Source::Reference(_) => None,
        }
    }

    /// Reads the file. An error completes the sentence "the mesh …".
    pub(crate) fn read(&self) -> Result<Mesh, String> {
        let path = match &self.source {
            Source::File(path) => path,
            Source::Reference(uri) => {
                let text = inline::text(uri).ok_or("has no text in its reference")?;
                return obj::read_alone(&text)?.finish();
            }
        };
        let bytes = input::read(path, MAX_TEXT_BYTES).map_err(|error| input::reason(&error))?;
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        let soup = match extension.to_ascii_lowercase().as_str() {
            "stl" => stl::read(&bytes),
            "obj" => obj::read(&bytes, path.parent().unwrap_or(Path::new(""))),
            "dae" => collada::read(&bytes, self.up_axis),
            "msh" => msh::read(&bytes),
            _ => Err(
                "is of no kind that is read: STL (.stl), OBJ (.obj), COLLADA (.dae) or MSH (.msh)"
                    .into(),
            ),
        };
        soup?.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::mesh::collada::tests::TRIANGLE;
    use crate::io::temporary::Folder;

    const OBJ: &str = "v 0 0 0\nv 2 0 0\nv 0 3 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

    fn load(path: &Path) -> Result<Mesh, String> {
        MeshFile::at(path.to_path_buf(), UpAxis::Auto).read()
    }

    /// A tetrahedron, as the STL of its triangles.
    fn stl() -> String {
        let corners = ["0 0 0", "2 0 0", "0 3 0", "0 0 4"];
        let mut out = "solid tetrahedron\n".to_owned();
        for triangle in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
            out += "facet normal 0 0 0\nouter loop\n";
            for corner in triangle {
                out += &format!("vertex {}\n", corners[corner]);
            }
            out += "endloop\nendfacet\n";
        }
        out + "endsolid\n"
    }

    #[test]
    fn stl_of_a_tetrahedron_equals_its_obj() {
        let folder = Folder::new();
        let sorted = |name: &str, text: &str| {
            let parts = load(&folder.write(name, text)).unwrap().parts;
            let mut vertices = parts[0].vertices.clone();
            vertices.sort_by(|a, b| a.partial_cmp(b).unwrap());
            (vertices, parts[0].triangles.len())
        };
        let obj = sorted("t.obj", OBJ);
        assert_eq!(obj, sorted("t.STL", &stl()));
        assert_eq!((obj.0.len(), obj.1), (4, 4));
        assert_eq!(obj.0[3], [2.0, 0.0, 0.0]);
    }

    #[test]
    fn broken_meshes_say_what_is_wrong() {
        let folder = Folder::new();
        let reason = |name: &str, text: &str| load(&folder.write(name, text)).unwrap_err();
        assert_eq!(reason("a.obj", "v 0 0 0\n"), "has no triangles");
        assert!(reason("nan.obj", &OBJ.replace("v 2", "v nan")).contains("NaN"));
        assert!(reason("a.stl", "solid x\nfacet\nvertex 1 2 3").contains("cut off"));
        assert!(reason("a.dae", "<COLLADA").contains("XML"));
        assert!(reason("a.png", "PNG").contains("no kind that is read"));
        assert!(reason("none", "").contains("no kind that is read"));
        let none = load(&folder.path("none.stl")).unwrap_err();
        assert!(none.starts_with("cannot be read: "), "{none}");
        let is_folder = load(&folder.path("")).unwrap_err();
        assert_eq!(is_folder, "is not a regular file");
    }

    /// Asserts what a mesh promises: parts with triangles, whose corners are there and finite.
    fn assert_is_mesh(mesh: &Mesh) {
        assert!(!mesh.parts.is_empty());
        for part in &mesh.parts {
            assert!(!part.triangles.is_empty());
            let last = part.triangles.iter().flatten().max().unwrap();
            assert!((*last as usize) < part.vertices.len());
            assert!(part.vertices.iter().flatten().all(|x| x.is_finite()));
        }
    }

    /// Every prefix and many changed bytes of a mesh.
    #[test]
    fn damaged_meshes_are_refused_with_a_reason_or_have_triangles() {
        for (name, text) in [
            ("t.obj", OBJ.to_owned()),
            ("t.stl", stl()),
            ("t.dae", TRIANGLE.to_owned()),
        ] {
            let bytes = text.into_bytes();
            let read = |bytes: &[u8]| match name {
                "t.obj" => obj::read(bytes, Path::new("")),
                "t.stl" => stl::read(bytes),
                _ => collada::read(bytes, UpAxis::Auto),
            };
            let (mut refused, mut meshes) = (0, 0);
            for k in 0..bytes.len() {
                let mut changed = bytes.clone();
                changed[k] = b"9-/ f\nx.e"[k % 9];
                for damaged in [&bytes[..k], &changed] {
                    match read(damaged).and_then(super::super::soup::Soup::finish) {
                        Ok(mesh) => {
                            assert_is_mesh(&mesh);
                            meshes += 1;
                        }
                        Err(reason) => {
                            assert!(!reason.is_empty(), "{name}, byte {k}");
                            refused += 1;
                        }
                    }
                }
            }
            assert!(refused > 20 && meshes > 20, "{name}: {refused}, {meshes}");
        }
    }
}
