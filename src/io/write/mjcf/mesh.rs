//! Meshes in a form that `MuJoCo` takes.
//!
//! | file | becomes |
//! |---|---|
//! | binary STL, OBJ, MSH | an asset that names the file |
//! | STL as text, which `MuJoCo` does not read, and meshes that a reference contains | their triangles in the asset itself |
//! | other formats, missing files, more triangles than `MuJoCo` takes | a comment |
//!
//! Their volume is of no use, as bodies have inertias of their own; all count as shells, which may be flat. Flat ones
//! have no hull there and do not collide.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::Vector3;

use super::numbers;
use crate::input;
use crate::io::mesh::{MeshFile, Part};
use crate::io::xml::Xml;
use crate::model::{Geometry, ModelBuilder};
use crate::nested::IntoNested;

/// Triangles that `MuJoCo` takes from an STL file.
const MAX_TRIANGLES: u64 = 200_000;

/// Triangles that are written into the description itself: some megabytes.
const MAX_WRITTEN_TRIANGLES: usize = 50_000;

/// Minimum number of corners for `MuJoCo`.
const LEAST_CORNERS: usize = 4;

/// Bytes before the triangles of a binary STL file, with their number in the last four, and of each triangle.
const STL_HEADER: usize = 84;
const STL_TRIANGLE: u64 = 50;

/// Width of what is flat, by the largest distance between two corners.
const FLAT: f64 = 1e-5;

/// Whether a shape touches others.
pub(super) enum Collides {
    Yes,
    /// The mesh cannot collide, for this reason.
    No(String),
}

/// Source of the triangles of a mesh.
enum Source {
    File(String),
    Written { vertex: String, face: String },
}

/// A mesh that can be shown.
struct Asset {
    source: Source,
    scale: String,
}

/// The meshes of a robot, by file and scale.
pub(super) struct Meshes {
    assets: Vec<Asset>,
    found: HashMap<(MeshFile, String), Result<usize, String>>,
    /// Flaw of each file that keeps it from colliding, if it has one.
    flaws: HashMap<MeshFile, Option<String>>,
}

impl Meshes {
    pub(super) fn of(builder: &ModelBuilder) -> Self {
        let mut meshes = Self {
            assets: Vec::new(),
            found: HashMap::new(),
            flaws: HashMap::new(),
        };
        for link in &builder.links {
            link.visuals
                .iter()
                .for_each(|shape| meshes.add(&shape.geometry));
            for collision in &link.collisions {
                meshes.add(&collision.geometry);
                meshes.examine(&collision.geometry);
            }
        }
        meshes
    }

    fn add(&mut self, geometry: &Geometry) {
        let Some(key) = key(geometry) else { return };
        if self.found.contains_key(&key) {
            return;
        }
        let found = source(&key.0).map(|source| {
            let scale = key.1.clone();
            self.assets.push(Asset { source, scale });
            self.assets.len() - 1
        });
        self.found.insert(key, found);
    }

    /// Finds whether a mesh has a hull.
    fn examine(&mut self, geometry: &Geometry) {
        if let Some((file, _)) = key(geometry) {
            let flaw = |file: &MeshFile| match file.read() {
                Ok(mesh) => is_flat(&mesh.parts).then(|| "its mesh is flat".to_owned()),
                Err(reason) => Some(format!("its mesh {reason}")),
            };
            self.flaws.entry(file).or_insert_with_key(flaw);
        }
    }

    pub(super) fn write(&self, xml: &mut Xml) {
        if self.assets.is_empty() {
            return;
        }
        xml.open("asset");
        for (i, asset) in self.assets.iter().enumerate() {
            let name = name(i);
            let mut attributes = vec![
                ("name", name.as_str()),
                ("inertia", "shell"),
                ("scale", &asset.scale),
            ];
            match &asset.source {
                Source::File(file) => attributes.push(("file", file)),
                Source::Written { vertex, face } => {
                    attributes.extend([("vertex", vertex.as_str()), ("face", face)]);
                }
            }
            xml.leaf("mesh", &attributes);
        }
        xml.end();
    }

    /// The name of a mesh, or why there is none.
    pub(super) fn find(&self, geometry: &Geometry) -> Result<String, String> {
        let key = key(geometry).ok_or("the file is not found")?;
        let found = self.found.get(&key).ok_or("the file is not found")?;
        found.clone().map(name)
    }

    /// Whether a shape touches others.
    pub(super) fn collides(&self, geometry: &Geometry) -> Collides {
        let Some((file, _)) = key(geometry) else {
            return Collides::Yes;
        };
        match self.flaws.get(&file) {
            Some(Some(flaw)) => Collides::No(flaw.clone()),
            _ => Collides::Yes,
        }
    }
}

fn name(i: usize) -> String {
    format!("mesh_{i}")
}

/// File and scale of a mesh that was found.
fn key(geometry: &Geometry) -> Option<(MeshFile, String)> {
    match geometry {
        Geometry::Mesh { scale, .. } => Some((MeshFile::of(geometry)?.1, numbers(scale))),
        _ => None,
    }
}

/// Source of a file's triangles for `MuJoCo`: the file itself, or the triangles written out; an error where it takes
/// neither.
fn source(mesh: &MeshFile) -> Result<Source, String> {
    let Some(path) = mesh.path() else {
        return written(mesh);
    };
    let extension = path.extension().and_then(|extension| extension.to_str());
    match extension.unwrap_or_default().to_lowercase().as_str() {
        "stl" if is_binary_stl(path)? => file(path),
        "stl" => written(mesh),
        "obj" | "msh" if path.is_file() => file(path),
        "obj" | "msh" => Err("the file is not found".into()),
        other => Err(format!("MuJoCo does not read {other} files")),
    }
}

fn file(path: &Path) -> Result<Source, String> {
    let absolute = std::path::absolute(path).map_err(|error| error.to_string())?;
    let text = absolute.to_str().ok_or("the path is not UTF-8")?;
    Ok(Source::File(text.to_owned()))
}

/// Whether an STL file is as long as the number of triangles in its header says; an error if these are more than are
/// taken.
fn is_binary_stl(path: &Path) -> Result<bool, String> {
    if !path.is_file() {
        return Err("the file is not found".into());
    }
    let start = input::read_start(path, STL_HEADER);
    let (header, length) = start.map_err(|error| error.to_string())?;
    let Some(&[a, b, c, d]) = header.get(STL_HEADER - 4..) else {
        return Ok(false);
    };
    let triangles = u64::from(u32::from_le_bytes([a, b, c, d]));
    if length != STL_HEADER as u64 + STL_TRIANGLE * triangles {
        return Ok(false);
    }
    // One triangle has three corners.
    if (2..=MAX_TRIANGLES).contains(&triangles) {
        return Ok(true);
    }
    Err(format!(
        "MuJoCo takes 2 to {MAX_TRIANGLES} triangles, not {triangles}"
    ))
}

/// The triangles themselves.
fn written(mesh: &MeshFile) -> Result<Source, String> {
    let parts = mesh.read()?.parts;
    let corners: usize = parts.iter().map(|part| part.vertices.len()).sum();
    let triangles: usize = parts.iter().map(|part| part.triangles.len()).sum();
    if corners < LEAST_CORNERS || triangles > MAX_WRITTEN_TRIANGLES {
        return Err(format!(
            "{triangles} triangles with {corners} corners are too few, or too many to be written"
        ));
    }
    let (mut vertex, mut face) = (Vec::new(), Vec::new());
    let mut first = 0;
    for part in &parts {
        vertex.extend(part.vertices.iter().flatten().map(f32::to_string));
        face.extend(
            part.triangles
                .iter()
                .flatten()
                .map(|corner| (first + corner).to_string()),
        );
        first += part.vertices.len() as u32;
    }
    Ok(Source::Written {
        vertex: vertex.join(" "),
        face: face.join(" "),
    })
}

/// Whether all corners are in one plane.
fn is_flat(parts: &[Part]) -> bool {
    let corners = || {
        let corners = parts.iter().nested(|part| &part.vertices);
        corners.map(|corner| Vector3::from(*corner).cast::<f64>())
    };
    let Some(origin) = corners().next() else {
        return true;
    };
    // The corner farthest from the first, the one farthest from the line through both, then the distance from the plane
    // of the three.
    let farthest = |distance: &dyn Fn(&Vector3<f64>) -> f64| {
        let distances = corners().map(|p| (distance(&p), p));
        distances.fold((0.0, origin), |a, b| if b.0 > a.0 { b } else { a })
    };
    let (length, far) = farthest(&|p| (p - origin).norm());
    let along = (far - origin) / length.max(f64::MIN_POSITIVE);
    let (_, aside) = farthest(&|p| (p - origin).cross(&along).norm());
    let normal = along.cross(&(aside - origin));
    let normal = normal / normal.norm().max(f64::MIN_POSITIVE);
    let (height, _) = farthest(&|p| (p - origin).dot(&normal).abs());
    height <= FLAT * length
}
