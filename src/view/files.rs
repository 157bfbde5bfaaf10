//! Files as a whole: what every format does with them.

use std::fs;
use std::path::Path;

use crate::error::RecordingError;

/// Reads a text.
pub(super) fn read(path: &Path) -> Result<String, RecordingError> {
    fs::read_to_string(path).map_err(|source| io(path, source))
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

fn io(path: &Path, source: std::io::Error) -> RecordingError {
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

/// What is wrong with times, if anything: the index of the first one that is not finite and later than the one before.
pub(super) fn first_disorder(times: &[f64]) -> Option<usize> {
    let ordered = |k: usize| times[k].is_finite() && (k == 0 || times[k] > times[k - 1]);
    (0..times.len()).find(|&k| !ordered(k))
}
