//! Material libraries (`.mtl`) of OBJ files.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::soup::Color;
use crate::input;

/// Most libraries of a mesh: one is the rule.
const MAX_LIBRARIES: usize = 32;

/// Larger libraries are not read: one of a hundred materials has some kilobytes.
const MAX_BYTES: u64 = 1 << 20;

/// Diffuse colours by name of the material, from files below a folder.
#[derive(Debug)]
pub(super) struct MaterialLibraries {
    /// Absolute, without links.
    folder: Option<PathBuf>,
    colors: HashMap<String, Color>,
    count: usize,
}

impl MaterialLibraries {
    /// A collection that finds no files.
    pub(super) fn none() -> Self {
        Self {
            folder: None,
            colors: HashMap::new(),
            count: 0,
        }
    }

    /// Makes a collection without materials yet.
    pub(super) fn below(folder: &Path) -> Self {
        // The parent of a bare file name is the working folder.
        let is_empty = folder.as_os_str().is_empty();
        let folder = if is_empty { Path::new(".") } else { folder };
        Self {
            folder: fs::canonicalize(folder).ok(),
            ..Self::none()
        }
    }

    /// The colour of a material, if it has one.
    pub(super) fn color(&self, material: &str) -> Color {
        self.colors.get(material).copied().flatten()
    }

    /// Takes in the materials of a file, or says why not.
    pub(super) fn add(&mut self, name: &str) -> Result<(), String> {
        self.count += 1;
        if self.count > MAX_LIBRARIES {
            return Err(format!("there are more than {MAX_LIBRARIES}"));
        }
        let path = self.find(name)?;
        let bytes = input::read(&path, MAX_BYTES);
        let bytes = bytes.map_err(|error| format!("it {}", input::reason(&error)))?;
        self.read(&String::from_utf8_lossy(&bytes));
        Ok(())
    }

    /// The file, only if it is below the folder once all links are followed; a caller does not learn whether there is one
    /// elsewhere.
    fn find(&self, name: &str) -> Result<PathBuf, String> {
        let folder = self.folder.as_deref();
        let path = folder.and_then(|folder| fs::canonicalize(folder.join(name)).ok());
        let path = path.filter(|path| folder.is_some_and(|folder| path.starts_with(folder)));
        path.ok_or_else(|| "it is not found below the folder of the mesh".into())
    }

    fn read(&mut self, text: &str) {
        let mut material = None;
        for line in text.lines() {
            let (key, value) = key_and_value(line);
            match (key, &material) {
                ("newmtl", _) => material = Some(value.to_owned()),
                ("Kd" | "kd", Some(name)) => {
                    self.colors.insert(name.clone(), color(value));
                }
                _ => {}
            }
        }
    }
}

/// The first word of a line and the rest; nothing in a comment.
pub(super) fn key_and_value(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (key, value) = line
        .split_once(|c: char| c.is_ascii_whitespace())
        .unwrap_or((line, ""));
    (key, value.trim_start())
}

/// The colour that one or three numbers mean; opaque, as exporters do not agree on the sense of opacity.
fn color(value: &str) -> Color {
    let numbers = value.split_ascii_whitespace().map(|word| word.parse().ok());
    let numbers: Option<Vec<f32>> = numbers.take(3).collect();
    let rgb = match numbers?[..] {
        [grey] => [grey; 3],
        [r, g, b] => [r, g, b],
        _ => return None,
    };
    let is_finite = rgb.iter().all(|x| x.is_finite());
    is_finite.then_some([rgb[0], rgb[1], rgb[2], 1.0])
}
