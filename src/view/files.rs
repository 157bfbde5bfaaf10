//! Files as a whole: what every format does with them.

use std::fs;
use std::io::{Error, ErrorKind};
use std::path::{Component, Path, PathBuf, absolute};

use crate::error::RecordingError;
use crate::input;

/// Larger recordings are not read; their text and their numbers are in memory at once.
const MAX_BYTES: u64 = 4 << 30;

/// Reads a text from a regular file.
pub(super) fn read(path: &Path) -> Result<String, RecordingError> {
    let text = input::read(path, MAX_BYTES).and_then(|bytes| {
        String::from_utf8(bytes).map_err(|error| Error::new(ErrorKind::InvalidData, error))
    });
    text.map_err(|source| io(path, source))
}

/// Writes a text, and the folders above it.
pub(super) fn write(path: &Path, text: impl AsRef<[u8]>) -> Result<(), RecordingError> {
    create_folder(path)?;
    fs::write(path, text).map_err(|source| io(path, source))
}

/// Makes the folders above a file.
pub(super) fn create_folder(path: &Path) -> Result<(), RecordingError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    fs::create_dir_all(folder).map_err(|source| io(path, source))
}

/// A path as a file contains it: relative to the folder of the file, so that a file that is handed on does not tell where on a
/// disk it was made.
///
/// By name alone, without asking the file system. A path that leads upwards by itself does not change, like one on another
/// drive does: what `..` means depends on links.
pub(super) fn from_folder_of(file: &Path, path: &Path) -> PathBuf {
    let relative = || {
        let (folder, whole) = (folder_of(file)?, absolute(path).ok()?);
        let parts = |path: &Path| path.components().map(Component::as_os_str).count();
        let common = folder.components().zip(whole.components());
        let common = common.take_while(|(a, b)| a == b).count();
        let is_plain = !whole.components().any(|part| part == Component::ParentDir);
        if common == 0 || !is_plain {
            return None;
        }
        let up = std::iter::repeat_n(Component::ParentDir, parts(&folder) - common);
        Some(up.chain(whole.components().skip(common)).collect())
    };
    relative().unwrap_or_else(|| path.to_path_buf())
}

/// The inverse of [`from_folder_of`]: a relative path, as seen from the folder of a file. Others stay.
pub(super) fn in_folder_of(file: &Path, path: &Path) -> PathBuf {
    let Some(mut whole) = folder_of(file).filter(|_| path.is_relative()) else {
        return path.to_path_buf();
    };
    let mut parts = path.components().peekable();
    while parts.next_if_eq(&Component::ParentDir).is_some() {
        whole.pop();
    }
    whole.extend(parts);
    whole
}

/// The folder of a file from the root of the file system, if that leads straight down.
fn folder_of(file: &Path) -> Option<PathBuf> {
    let folder = absolute(file).ok()?.parent()?.to_path_buf();
    let is_plain = !folder.components().any(|part| part == Component::ParentDir);
    is_plain.then_some(folder)
}

fn io(path: &Path, source: Error) -> RecordingError {
    RecordingError::Io {
        file: name(path),
        source,
    }
}

/// A path for a person.
pub(super) fn name(path: &Path) -> String {
    path.display().to_string()
}

/// An error at a line.
pub(super) fn malformed(path: &Path, line: usize, reason: impl Into<String>) -> RecordingError {
    RecordingError::Malformed {
        file: name(path),
        line,
        reason: reason.into(),
    }
}

/// An error about robots that do not fit.
pub(super) fn other_robots(path: &Path, reason: impl Into<String>) -> RecordingError {
    RecordingError::OtherRobots {
        file: name(path),
        reason: reason.into(),
    }
}

/// Index of the first time that is not both finite and later than the one before; `None` if there is none.
pub(super) fn first_disorder(times: &[f64]) -> Option<usize> {
    let ordered = |k: usize| times[k].is_finite() && (k == 0 || times[k] > times[k - 1]);
    (0..times.len()).find(|&k| !ordered(k))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn path_from_the_folder_of_a_file_leads_back_to_where_it_was() {
        let cases = [
            ("out/motion.json", "out/mesh.stl", "mesh.stl"),
            ("out/motion.json", "out/a/b.stl", "a/b.stl"),
            ("motion.json", "a/b.stl", "a/b.stl"),
            ("out/deep/motion.json", "robots/b.stl", "../../robots/b.stl"),
            ("out/motion.json", "./out/./b.stl", "b.stl"),
        ];
        for (file, path, expected) in cases {
            let file = Path::new(file);
            for path in [PathBuf::from(path), absolute(path).unwrap()] {
                let stored = from_folder_of(file, &path);
                assert_eq!(stored, Path::new(expected));
                assert_eq!(in_folder_of(file, &stored), absolute(&path).unwrap());
            }
        }
        // The meaning of `..` depends on links.
        let up = absolute("a").unwrap().join("../b.stl");
        assert_eq!(from_folder_of(Path::new("out/motion.json"), &up), up);
        assert_eq!(in_folder_of(Path::new("out/motion.json"), &up), up);
        // More of them than there are folders lead to the root.
        let many = "../".repeat(100) + "b.stl";
        let root = in_folder_of(Path::new("motion.json"), Path::new(&many));
        assert_eq!(root.components().count(), 2, "{root:?}");
    }
}
