//! Regular files of bounded size.

use std::fs::{self, File, Metadata};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Larger descriptions and meshes are not read: those of robots have some megabytes.
pub(crate) const MAX_TEXT_BYTES: u64 = 64 << 20;

/// Reads a regular file of at most so many bytes.
///
/// Kind and size are checked before the file is opened, as opening a pipe waits for a writer, and once more on what was
/// opened. A file that says it is empty is not opened at all: so do the devices under `/proc`, which look like regular
/// files, and may wait or never end.
pub(crate) fn read(path: &Path, max_bytes: u64) -> Result<Vec<u8>> {
    let size = checked_size(&fs::metadata(path)?, max_bytes)?;
    if size == 0 {
        return Ok(Vec::new());
    }
    let file = File::open(path)?;
    let size = checked_size(&file.metadata()?, max_bytes)?;
    let mut bytes = Vec::new();
    // On a target where this does not fit, neither does the file.
    bytes.try_reserve_exact(usize::try_from(size).unwrap_or(usize::MAX))?;
    file.take(size).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The first bytes of a regular file, at most so many, and how many it has in all; with the care that [`read`] takes.
pub(crate) fn read_start(path: &Path, bytes: usize) -> Result<(Vec<u8>, u64)> {
    let mut start = Vec::new();
    if checked_size(&fs::metadata(path)?, u64::MAX)? == 0 {
        return Ok((start, 0));
    }
    let file = File::open(path)?;
    let size = checked_size(&file.metadata()?, u64::MAX)?;
    file.take(bytes as u64).read_to_end(&mut start)?;
    Ok((start, size))
}

fn checked_size(metadata: &Metadata, max_bytes: u64) -> Result<u64> {
    if !metadata.is_file() {
        let reason = "is not a regular file";
        return Err(Error::new(ErrorKind::InvalidInput, reason));
    }
    let size = metadata.len();
    if size > max_bytes {
        let reason = format!("has {size} bytes, more than {max_bytes}");
        return Err(Error::new(ErrorKind::FileTooLarge, reason));
    }
    Ok(size)
}

/// An error of a file as the end of a sentence about it; messages of the operating system are not sentences.
pub(crate) fn reason(error: &Error) -> String {
    match error.raw_os_error() {
        Some(_) => format!("cannot be read: {error}"),
        None => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::temporary::Folder;

    #[test]
    fn bytes_of_a_file_equal_what_was_written_up_to_the_limit() {
        let folder = Folder::new();
        let path = folder.write("a", [7; 100]);
        assert_eq!(read(&path, 100).unwrap(), [7; 100]);
        let error = read(&path, 99).unwrap_err();
        assert_eq!(error.to_string(), "has 100 bytes, more than 99");
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
        assert!(read(&folder.write("empty", ""), 0).unwrap().is_empty());
        assert_eq!(
            read(&folder.path("none"), 1).unwrap_err().kind(),
            ErrorKind::NotFound
        );
    }

    #[test]
    fn start_of_a_file_equals_what_was_written_there() {
        let folder = Folder::new();
        let path = folder.write("a", "0123456789");
        assert_eq!(read_start(&path, 4).unwrap(), (b"0123".to_vec(), 10));
        assert_eq!(read_start(&path, 40).unwrap().0, b"0123456789");
    }

    #[test]
    fn folders_devices_and_pipes_are_refused_before_they_are_opened() {
        let folder = Folder::new();
        let mut others = vec![folder.path("")];
        if cfg!(unix) {
            others.push("/dev/zero".into());
            let pipe = folder.path("pipe");
            let made = std::process::Command::new("mkfifo").arg(&pipe).status();
            others.extend(made.is_ok_and(|status| status.success()).then_some(pipe));
        }
        for path in others {
            let errors = [
                read(&path, u64::MAX).unwrap_err(),
                read_start(&path, 1).unwrap_err(),
            ];
            for error in errors {
                assert_eq!(error.to_string(), "is not a regular file", "{path:?}");
            }
        }
    }

    /// It calls itself a regular file of no bytes; reading it waits for a message of the kernel.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_device_that_calls_itself_an_empty_file_is_not_waited_for() {
        let path = Path::new("/proc/kmsg");
        if path.is_file() {
            assert!(read(path, 100).unwrap().is_empty());
            assert_eq!(read_start(path, 100).unwrap(), (Vec::new(), 0));
        }
    }
}
