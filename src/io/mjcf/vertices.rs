//! Meshes whose vertices are in the description.

use super::entry::Entry;
use crate::error::LoadError;
use crate::io::mesh;

/// The most numbers of an attribute: more than a file can contain.
const MOST: usize = crate::input::MAX_TEXT_BYTES as usize;

/// Reads vertices and faces, without faces those of the convex hull: a reference that contains them, or the reason why the mesh cannot be used.
pub(super) fn read(entry: &Entry<'_, '_>, name: &str) -> Result<Result<String, String>, LoadError> {
    let Some(numbers) = entry.list("vertex", MOST)? else {
        return Ok(Err("has no file and no vertices".into()));
    };
    let (vertices, rest) = numbers.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(entry.malformed("vertex", "expected three numbers for each vertex"));
    }
    // Single precision, as meshes have it there and here.
    let vertices: Vec<[f32; 3]> = vertices.iter().map(|p| p.map(|x| x as f32)).collect();
    if !vertices.iter().flatten().all(|x| x.is_finite()) {
        return Err(entry.malformed("vertex", "a number is beyond single precision"));
    }
    let faces = faces(entry, vertices.len())?;
    Ok(reference(name, vertices, faces))
}

/// A reference that contains a mesh, without triangles that of its convex hull; or the reason why it cannot be used.
pub(super) fn reference(
    name: &str,
    vertices: Vec<[f32; 3]>,
    triangles: Option<Vec<[u32; 3]>>,
) -> Result<String, String> {
    match triangles {
        Some(triangles) => Ok(mesh::reference(name, &vertices, &triangles)),
        None => mesh::hull(vertices).map(|hull| {
            let part = &hull.parts[0];
            mesh::reference(name, &part.vertices, &part.triangles)
        }),
    }
}

fn faces(entry: &Entry<'_, '_>, vertices: usize) -> Result<Option<Vec<[u32; 3]>>, LoadError> {
    let Some(numbers) = entry.list("face", MOST)? else {
        return Ok(None);
    };
    let (faces, rest) = numbers.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(entry.malformed("face", "expected three vertices for each face"));
    }
    let is_vertex = |x: &f64| x.fract() == 0.0 && (0.0..vertices as f64).contains(x);
    if let Some(x) = numbers.iter().find(|x| !is_vertex(x)) {
        return Err(entry.malformed("face", &format!("there is no vertex {x}")));
    }
    Ok(Some(faces.iter().map(|p| p.map(|x| x as u32)).collect()))
}
