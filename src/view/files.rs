//! Files as a whole: what every format does with them.

use std::fs;
use std::io::{Error, ErrorKind};
use std::path::Path;

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

/// What is wrong with times, if anything: the index of the first one that is not finite and later than the one before.
pub(super) fn first_disorder(times: &[f64]) -> Option<usize> {
    let ordered = |k: usize| times[k].is_finite() && (k == 0 || times[k] > times[k - 1]);
    (0..times.len()).find(|&k| !ordered(k))
}
