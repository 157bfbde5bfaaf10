//! Triangles from STL, OBJ and COLLADA files.

use std::collections::HashMap;
use std::fs;
use std::panic::catch_unwind;
use std::path::Path;

/// Larger files are not read: a mesh of a robot has some megabytes.
const MAX_BYTES: u64 = 64 << 20;

/// Triangles of one colour.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Corners of triangles, each once, finite, m before the scale of the description.
    pub(crate) vertices: Vec<[f32; 3]>,
    /// Vertices of the triangles, at least one.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The colour in the file, red, green, blue, opacity.
    pub(crate) color: Option<[f32; 4]>,
}

/// Reads the parts of a mesh, at least one, or says what is wrong with it.
pub(crate) fn read(path: &Path) -> Result<Vec<Part>, String> {
    let size = fs::metadata(path).map_err(|error| error.to_string())?.len();
    if size > MAX_BYTES {
        return Err(format!("has {size} bytes, more than {MAX_BYTES}"));
    }
    let bytes = fs::read(path).map_err(|error| error.to_string())?;
    let scene = understand(&bytes, path)?;
    let colors = scene
        .materials
        .iter()
        .map(|material| material.color.diffuse);
    let colors = colors.chain(std::iter::repeat(None));
    let parts = scene.meshes.iter().zip(colors);
    let parts: Result<Vec<_>, _> = parts
        .filter(|(mesh, _)| !mesh.faces.is_empty())
        .map(|(mesh, color)| weld(mesh, color))
        .collect();
    match parts {
        Ok(parts) if parts.is_empty() => Err("has no triangles".into()),
        parts => parts,
    }
}

/// Reads a file with its own reader, which panics over some damaged COLLADA files: they cost the mesh, not the robot.
fn understand(bytes: &[u8], path: &Path) -> Result<mesh_loader::Scene, String> {
    let load = || mesh_loader::Loader::default().load_from_slice(bytes, path);
    match catch_unwind(load) {
        Ok(scene) => scene.map_err(|error| error.to_string()),
        Err(_) => Err("is damaged".into()),
    }
}

/// Vertices without the repetitions that STL files have.
fn weld(mesh: &mesh_loader::Mesh, color: Option<[f32; 4]>) -> Result<Part, String> {
    let mut index_of = HashMap::new();
    let mut vertices = Vec::new();
    let mut index = |corner: u32| {
        let vertex = mesh.vertices.get(corner as usize);
        let vertex = *vertex.ok_or_else(|| format!("has no vertex {corner}"))?;
        if !vertex.iter().all(|x| x.is_finite()) {
            return Err(format!("has the vertex {vertex:?}"));
        }
        let index = index_of.entry(vertex.map(f32::to_bits));
        Ok(*index.or_insert_with(|| {
            vertices.push(vertex);
            vertices.len() as u32 - 1
        }))
    };
    let mut triangles = Vec::with_capacity(mesh.faces.len());
    for &[a, b, c] in &mesh.faces {
        triangles.push([index(a)?, index(b)?, index(c)?]);
    }
    Ok(Part {
        vertices,
        triangles,
        color,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::temporary::Folder;

    const OBJ: &str = "v 0 0 0\nv 2 0 0\nv 0 3 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

    /// A triangle in millimetres.
    const DAE: &str = r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 2000 0 0 0 3000 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##;

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
            let parts = read(&folder.write(name, text)).unwrap();
            let mut vertices = parts[0].vertices.clone();
            vertices.sort_by(|a, b| a.partial_cmp(b).unwrap());
            (vertices, parts[0].triangles.len())
        };
        let obj = sorted("t.obj", OBJ);
        assert_eq!(obj, sorted("t.stl", &stl()));
        assert_eq!((obj.0.len(), obj.1), (4, 4));
        assert_eq!(obj.0[3], [2.0, 0.0, 0.0]);
    }

    #[test]
    fn unit_of_a_collada_file_equals_its_scale_in_metres() {
        let folder = Folder::new();
        let part = &read(&folder.write("t.dae", DAE)).unwrap()[0];
        let [_, a, b] = part.vertices[..] else {
            panic!("three vertices")
        };
        let error = (a[0] - 2.0).abs() + (b[1] - 3.0).abs();
        assert!(error < 1e-5, "{:?}", part.vertices);
    }

    #[test]
    fn broken_meshes_say_what_is_wrong() {
        let folder = Folder::new();
        let reason = |name: &str, text: &str| read(&folder.write(name, text)).unwrap_err();
        assert_eq!(reason("a.obj", "v 0 0 0\n"), "has no triangles");
        assert!(reason("nan.obj", &OBJ.replace("v 2", "v nan")).contains("NaN"));
        assert!(!reason("a.stl", "solid x\nfacet").is_empty());
        assert!(!reason("a.dae", "<COLLADA").is_empty());
        assert!(!reason("a.png", "PNG").is_empty());
        assert!(!read(&folder.path("none.stl")).unwrap_err().is_empty());
    }

    /// Every prefix and many changed bytes of a mesh: triangles or a reason, never a panic.
    #[test]
    fn damaged_meshes_never_panic() {
        let folder = Folder::new();
        for (name, text) in [
            ("t.obj", OBJ.to_owned()),
            ("t.stl", stl()),
            ("t.dae", DAE.to_owned()),
        ] {
            let bytes = text.into_bytes();
            for k in 0..bytes.len() {
                let mut changed = bytes.clone();
                changed[k] = b"9-/ f\nx.e"[k % 9];
                for damaged in [&bytes[..k], &changed] {
                    let _ = read(&folder.write(name, damaged));
                }
            }
        }
    }
}
