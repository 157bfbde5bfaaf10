//! Finder of the mesh files of a description.
//!
//! A reference is a relative or absolute path, `file://path`, `package://name/rest` or `model://name/rest`. It is
//! resolved by asking whether files exist, never by running a program. In the path of a URI `%20` is a space and so on, but a file that
//! has the escape in its name is found too; a path without a scheme is taken as it is.

use std::collections::HashMap;
use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::ModelOptions;
use super::mesh::{is_inline, percent_decoded};
use super::roots::Roots;
use crate::model::{Geometry, UpAxis};
use crate::nested::IntoNested;

/// Finder of mesh files: folders to look in, and how.
#[derive(Debug)]
pub(super) struct MeshFinder {
    /// Folder of the description, if it is in a file, absolute.
    folder: Option<PathBuf>,
    /// Folders given by the caller.
    search_paths: Vec<PathBuf>,
    /// Packages, or folders of packages.
    package_folders: Vec<PathBuf>,
    /// Installations: packages are under `share`.
    prefixes: Vec<PathBuf>,
    /// The folders of the packages that were requested.
    packages: HashMap<String, Vec<PathBuf>>,
    /// Folders in which files may be.
    roots: Roots,
    /// Treatment of the up axis that mesh files state.
    up_axis: UpAxis,
}

impl MeshFinder {
    /// Looks around a folder, in the given folders and in those that the environment names.
    pub(super) fn new(folder: Option<&Path>, options: &ModelOptions) -> Self {
        let list = |name: &str| {
            let value = env::var_os(name).unwrap_or_default();
            env::split_paths(&value)
                .filter(|path| !path.as_os_str().is_empty())
                .collect()
        };
        Self {
            folder: folder.map(absolute),
            search_paths: options.search_paths.clone(),
            package_folders: list("ROS_PACKAGE_PATH"),
            prefixes: list("AMENT_PREFIX_PATH"),
            packages: HashMap::new(),
            roots: options.roots.clone(),
            up_axis: options.up_axis,
        }
    }

    /// A mesh as the model holds it: with its file, if that is found.
    pub(super) fn geometry(&mut self, uri: &str, scale: Option<[f64; 3]>) -> Geometry {
        Geometry::Mesh {
            uri: uri.into(),
            path: self.find(uri),
            scale: scale.unwrap_or([1.0; 3]),
            up_axis: self.up_axis,
        }
    }

    /// Remark on a mesh whose file is not found; `None` if the file is found, and for shapes that are not meshes.
    pub(super) fn flaw(&self, mesh: &Geometry) -> Option<String> {
        let Geometry::Mesh { uri, path, .. } = mesh else {
            return None;
        };
        if path.is_some() || is_inline(uri) {
            return None;
        }
        let places = self.places();
        Some(format!("the mesh \"{uri}\" is not found{places}"))
    }

    /// Names the folders in which files may be, after "is not found".
    pub(super) fn places(&self) -> &'static str {
        if self.roots.are_given() {
            " below the root folders"
        } else {
            ""
        }
    }

    /// The file that a reference means, if it exists.
    pub(super) fn find(&mut self, uri: &str) -> Option<PathBuf> {
        match uri.split_once("://") {
            _ if is_inline(uri) => None,
            None => self.find_plain(uri),
            Some(("file", path)) => self.find_file(path),
            Some(("package" | "model", path)) => {
                let (package, rest) = path.split_once('/')?;
                let rest = rest.trim_start_matches('/');
                let decoded = percent_decoded(rest);
                let below = |folder: &PathBuf| {
                    let decoded = decoded.as_ref().map(|rest| folder.join(rest));
                    decoded.into_iter().chain([folder.join(rest)])
                };
                let paths = self.package(package).iter().nested(below).collect();
                self.first(paths)
            }
            Some(_) => None,
        }
    }

    /// The file of a name in the folder that a reference means, if it exists.
    ///
    /// A reference that is only a name, as in `model://name`, means a folder of that name: a folder that the caller
    /// gives may be a package under any name, but it is not every model.
    pub(super) fn find_in_folder(&mut self, uri: &str, file: &str) -> Option<PathBuf> {
        let uri = uri.trim_end_matches('/');
        match uri.split_once("://") {
            Some(("package" | "model", name)) if !name.contains('/') => {
                let is_named = |folder: &&PathBuf| folder.file_name() == Some(OsStr::new(name));
                let named = self.package(name).iter().filter(is_named);
                let paths = named.map(|folder| folder.join(file)).collect();
                self.first(paths)
            }
            _ => self.find(&format!("{uri}/{file}")),
        }
    }

    fn find_plain(&self, path: &str) -> Option<PathBuf> {
        let path = Path::new(path);
        let absolute = path.is_absolute().then(|| path.to_path_buf());
        let folders = self.folder.iter().chain(&self.search_paths);
        let candidates = folders.map(|folder| folder.join(path)).chain(absolute);
        self.first(candidates.collect())
    }

    /// The file that the part of a URI after `file://` means: with its escapes replaced, or else unchanged.
    fn find_file(&self, path: &str) -> Option<PathBuf> {
        let local = path.strip_prefix("localhost");
        let path = local.filter(|local| local.starts_with('/')).unwrap_or(path);
        let candidates = [percent_decoded(path), Some(path.into())].into_iter();
        self.first(candidates.flatten().map(PathBuf::from).collect())
    }

    /// The first path of a file that may be read.
    fn first(&self, candidates: Vec<PathBuf>) -> Option<PathBuf> {
        candidates.into_iter().find_map(|path| self.existing(&path))
    }

    /// A path, if it is one of a file that may be read.
    pub(super) fn existing(&self, path: &Path) -> Option<PathBuf> {
        let path = self.roots.admit(path).ok()?;
        path.is_file().then(|| path.into_owned())
    }

    /// The folders that exist of those that may be a package.
    fn package(&mut self, package: &str) -> &[PathBuf] {
        if !self.packages.contains_key(package) {
            let found = self.package_candidates(package);
            let found = found.into_iter().filter(|path| path.is_dir()).collect();
            self.packages.insert(package.into(), found);
        }
        &self.packages[package]
    }

    /// The folders that may be a package, in search order.
    fn package_candidates(&self, package: &str) -> Vec<PathBuf> {
        let named = |folder: &Path| {
            let is_package = folder.file_name() == Some(OsStr::new(package));
            let itself = is_package.then(|| folder.to_path_buf());
            [folder.join(package)].into_iter().chain(itself)
        };
        // A folder that the caller gives may be the package under any name, unless another one has that name.
        let given = self.search_paths.iter().map(|path| path.join(package));
        let given = given.chain(self.search_paths.iter().cloned());
        let of_environment = self.package_folders.iter().nested(|path| named(path));
        let installed = self
            .prefixes
            .iter()
            .map(|path| path.join("share").join(package));
        let around = self.folder.iter().nested(|folder| folder.ancestors());
        let around = around.nested(named);
        given
            .chain(of_environment)
            .chain(installed)
            .chain(around)
            .collect()
    }
}

/// The path from the root of the file system, without asking the file system where that is possible.
fn absolute(path: &Path) -> PathBuf {
    // An empty path, the parent of a bare file name, is the working folder.
    let path = if path.as_os_str().is_empty() {
        Path::new(".")
    } else {
        path
    };
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::temporary::Folder;

    fn finder(folder: Option<&Path>) -> MeshFinder {
        MeshFinder {
            folder: folder.map(absolute),
            search_paths: Vec::new(),
            package_folders: Vec::new(),
            prefixes: Vec::new(),
            packages: HashMap::new(),
            roots: Roots::default(),
            up_axis: UpAxis::default(),
        }
    }

    const URI: &str = "package://arm_description/meshes/link.stl";

    #[test]
    fn package_reference_finds_the_file_in_every_place_that_may_hold_it() {
        let root = Folder::new();
        let mesh = root.write("src/arm_description/meshes/link.stl", "");
        let installed = root.write("install/share/arm_description/meshes/link.stl", "");
        let (src, package) = (root.path("src"), root.path("src/arm_description"));

        for folder in [&src, &package] {
            let mut given = finder(None);
            given.search_paths.push(folder.clone());
            assert_eq!(given.find(URI).as_ref(), Some(&mesh), "given {folder:?}");
            let mut of_environment = finder(None);
            of_environment.package_folders.push(folder.clone());
            assert_eq!(of_environment.find(URI).as_ref(), Some(&mesh), "{folder:?}");
        }
        let mut prefixed = finder(None);
        prefixed.prefixes.push(root.path("install"));
        assert_eq!(prefixed.find(URI), Some(installed));
        for folder in ["src/arm_description/urdf", "src/other/urdf"] {
            let mut around = finder(Some(&root.path(folder)));
            assert_eq!(around.find(URI).as_ref(), Some(&mesh), "around {folder}");
        }
        assert_eq!(finder(Some(&root.path("elsewhere"))).find(URI), None);
    }

    #[test]
    fn plain_and_file_references_find_the_file() {
        let root = Folder::new();
        let mesh = root.write("robot/meshes/link.stl", "");
        let mut beside = finder(Some(&root.path("robot")));
        assert_eq!(beside.find("meshes/link.stl"), Some(mesh.clone()));
        let path = mesh.display();
        assert_eq!(
            finder(None).find(&format!("file://{path}")),
            Some(mesh.clone())
        );
        assert_eq!(finder(None).find(&path.to_string()), Some(mesh.clone()));
    }

    #[test]
    fn file_references_are_percent_decoded() {
        let root = Folder::new();
        for (name, reference) in [
            ("my robot/a mesh.stl", "my%20robot/a%20mesh.stl"),
            ("größe.stl", "gr%C3%B6%c3%9fe.stl"),
            ("100%.stl", "100%25.stl"),
            // A lone sign means itself, and a name that has the escape in it is found as well.
            ("5%.stl", "5%.stl"),
            ("a%2b.stl", "a%2b.stl"),
        ] {
            let mesh = root.write(name, "");
            for host in ["", "localhost"] {
                let uri = format!("file://{host}{}/{reference}", root.path("").display());
                assert_eq!(finder(None).find(&uri), Some(mesh.clone()), "{uri}");
            }
            let plain = finder(Some(&root.path(""))).find(reference);
            assert_eq!(plain.is_some(), name == reference, "{reference}");
        }
    }

    #[test]
    fn strange_references_find_nothing_and_do_no_harm() {
        let root = Folder::new();
        let mut finder = finder(Some(&root.path("")));
        let long = format!("package://{}", "a/".repeat(10_000));
        for uri in [
            "",
            "://",
            "package://",
            "package:///no-such-mesh",
            "package://../..",
            "http://a/b.stl",
            "a\0b",
            "file:///a%00b",
            "file://%ff%fe",
            "file://%é",
            &long,
        ] {
            assert_eq!(finder.find(uri), None, "{uri:?}");
        }
    }
}
