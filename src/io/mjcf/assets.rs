//! Meshes and colours that geoms name.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::cell::{Cell, OnceCell};
use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;

use super::builtin;
use super::compiler::Compiler;
use super::defaults::Classes;
use super::entry::Entry;
use super::height_field::HeightAsset;
use super::mesh_inertia::{self, Volumes};
use super::orientation::pose_named;
use super::tree::Node;
use super::vertices;
use crate::error::LoadError;
use crate::input::MAX_TEXT_BYTES;
use crate::io::ModelOptions;
use crate::io::mesh::MeshFile;
use crate::io::mesh_path::MeshFinder;
use crate::model::Geometry;
use crate::nested::IntoNested;
use crate::spatial::{Inertia, Transform};

/// Methods of the inertia of meshes.
const INERTIAS: [(&str, Volumes); 4] = [
    ("legacy", Volumes::Absolute),
    ("exact", Volumes::Signed),
    ("convex", Volumes::Hull),
    ("shell", Volumes::Shell),
];

/// The most bytes of references to meshes that geoms get: a mesh in the description is large, and any number of geoms can name it.
const MOST_BYTES: u64 = MAX_TEXT_BYTES;

/// A mesh with its file.
#[derive(Clone, Debug)]
pub(super) struct MeshAsset {
    pub(super) geometry: Geometry,
    /// Pose of the frame of the mesh in that of its file.
    pub(super) X_FM: Transform<f64>,
    /// Method of its inertia.
    volumes: Volumes,
    /// The solid in it at density 1, or why there is none, once it was requested.
    solid: Rc<OnceCell<Result<Inertia<f64>, String>>>,
}

impl MeshAsset {
    /// The solid inside of the mesh at density 1 kg/m³; its file is read once.
    ///
    /// # Errors
    /// If the file is not found or cannot be read, or if the surface has no volume.
    pub(super) fn solid(&self) -> Result<Inertia<f64>, String> {
        let found = self.solid.get_or_init(|| {
            let Geometry::Mesh { scale, .. } = &self.geometry else {
                return Ok(Inertia::zero());
            };
            let (_, file) = MeshFile::of(&self.geometry).ok_or("is not found")?;
            mesh_inertia::of(file.read()?, *scale, self.volumes)
        });
        found.clone()
    }
}

/// Context for reading the assets of a model.
#[derive(Clone, Copy, Debug)]
pub(super) struct Settings<'s, 't> {
    pub(super) compiler: &'s Compiler,
    pub(super) classes: &'s Classes<'t>,
    /// Folder of the file, if it is in one.
    pub(super) folder: Option<&'s Path>,
}

/// Meshes and colours by name.
#[derive(Debug, Default)]
pub(super) struct Assets {
    meshes: HashMap<String, Result<MeshAsset, String>>,
    colors: HashMap<String, [f64; 4]>,
    heights: HashMap<String, Result<HeightAsset, String>>,
    /// Vertices of meshes that parameters make.
    made: usize,
    /// Bytes of the references that geoms got.
    given: Cell<u64>,
}

impl Assets {
    /// Reads the assets; those that nothing here can use are left unread.
    pub(super) fn read<'t>(
        root: Node<'t>,
        settings: Settings<'_, 't>,
        options: &ModelOptions,
    ) -> Result<Self, LoadError> {
        let mut out = Self::default();
        let mut finder = MeshFinder::new(settings.folder, options);
        let all = || root.all("asset").nested(Node::children);
        let textures = all().filter(|node| node.tag() == "texture");
        let textures: HashSet<&str> = textures.filter_map(texture_name).collect();
        for node in all() {
            match node.tag() {
                "mesh" => out.mesh(node, settings, &mut finder)?,
                "hfield" => out.height_field(node, settings, &mut finder)?,
                "material" => out.add_material(node, settings.classes, &textures)?,
                _ => {}
            }
        }
        Ok(out)
    }

    fn add_material<'t>(
        &mut self,
        node: Node<'t>,
        classes: &Classes<'t>,
        textures: &HashSet<&str>,
    ) -> Result<(), LoadError> {
        let entry = Entry::new(node, classes, 0, &["material"])?;
        let layers = node.children().filter(|node| node.tag() == "layer");
        for node in std::iter::once(node).chain(layers) {
            if let Some(name) = node.peek("texture").filter(|name| !textures.contains(name)) {
                let reason = "there is no texture of that name";
                return Err(node.place().malformed("texture", name, reason));
            }
        }
        let color = entry.some_numbers("rgba", [1.0; 4])?;
        if let Some(name) = entry.text("name") {
            self.colors.insert(name.into(), color);
        }
        Ok(())
    }

    fn mesh<'t>(
        &mut self,
        node: Node<'t>,
        settings: Settings<'_, 't>,
        finder: &mut MeshFinder,
    ) -> Result<(), LoadError> {
        let entry = Entry::new(node, settings.classes, 0, &["mesh"])?;
        let file = entry.text("file");
        let name = name_of(&entry, file)?;
        let builtin = builtin::read(&entry, &mut self.made)?;
        let uri = match (builtin, file) {
            (Some(own), _) => vertices::reference(name, own.vertices, own.triangles),
            (None, Some(file)) => Ok(path_of(file, settings.compiler)),
            (None, None) => vertices::read(&entry, name)?,
        };
        let scale = entry.numbers::<3>("scale")?;
        let X_FM = pose_named(&entry, ["refpos", "refquat"])?;
        let volumes = entry.word("inertia", &INERTIAS)?;
        let mesh = uri.map(|uri| MeshAsset {
            X_FM,
            volumes: volumes.unwrap_or(Volumes::Absolute),
            geometry: finder.geometry(&uri, scale),
            solid: Rc::default(),
        });
        self.meshes.insert(name.into(), mesh);
        Ok(())
    }

    fn height_field<'t>(
        &mut self,
        node: Node<'t>,
        settings: Settings<'_, 't>,
        finder: &mut MeshFinder,
    ) -> Result<(), LoadError> {
        let entry = Entry::new(node, settings.classes, 0, &["hfield"])?;
        let file = entry.text("file");
        let name = name_of(&entry, file)?;
        let path = file.and_then(|file| finder.find(&path_of(file, settings.compiler)));
        let heights = HeightAsset::read(&entry, path.as_deref())?;
        self.heights.insert(name.into(), heights);
        Ok(())
    }

    /// The height field of a name; `None` if there is none, or the reason why it cannot be used.
    pub(super) fn heights_of(&self, name: &str) -> Option<Result<&HeightAsset, &str>> {
        let found = self.heights.get(name)?;
        Some(found.as_ref().map_err(String::as_str))
    }

    /// Whether there is a mesh of a name.
    pub(super) fn has_mesh(&self, name: &str) -> bool {
        self.meshes.contains_key(name)
    }

    /// The mesh of a name; `None` if there is none, or the reason why it cannot be used.
    pub(super) fn mesh_of(&self, name: &str) -> Option<Result<&MeshAsset, &str>> {
        let found = self.meshes.get(name)?.as_ref().map_err(String::as_str);
        Some(found.and_then(|mesh| {
            if let Geometry::Mesh { uri, .. } = &mesh.geometry {
                self.given.set(self.given.get() + uri.len() as u64);
            }
            match self.given.get() {
                0..=MOST_BYTES => Ok(mesh),
                _ => Err("is too large for so many geoms"),
            }
        }))
    }

    /// The colour of the material that an element names, if it names one.
    pub(super) fn material(&self, entry: &Entry<'_, '_>) -> Result<Option<[f64; 4]>, LoadError> {
        let Some(name) = entry.text("material") else {
            return Ok(None);
        };
        let unknown = || entry.malformed("material", "there is no material of that name");
        self.color(name).ok_or_else(unknown).map(Some)
    }

    /// The colour of a material.
    pub(super) fn color(&self, material: &str) -> Option<[f64; 4]> {
        self.colors.get(material).copied()
    }
}

/// The name of an asset: otherwise that of its file.
fn name_of<'t>(entry: &Entry<'t, '_>, file: Option<&'t str>) -> Result<&'t str, LoadError> {
    let stem = file.and_then(|file| Path::new(file).file_stem()?.to_str());
    let name = entry.text("name").or(stem);
    name.ok_or_else(|| entry.missing("name"))
}

/// The name of a texture: otherwise that of its file.
fn texture_name(node: Node<'_>) -> Option<&str> {
    let stem = || Path::new(node.peek("file")?).file_stem()?.to_str();
    node.peek("name").or_else(stem)
}

/// The path of a mesh from the folder of the description.
fn path_of(file: &str, compiler: &Compiler) -> String {
    let name = Path::new(file).file_name().and_then(|name| name.to_str());
    let file = match name {
        Some(name) if compiler.strippath => name,
        _ => file,
    };
    match compiler.meshdir.trim_end_matches('/') {
        "" => file.into(),
        _ if Path::new(file).is_absolute() => file.into(),
        folder => format!("{folder}/{file}"),
    }
}
