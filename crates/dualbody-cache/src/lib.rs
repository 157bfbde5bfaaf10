//! A folder that stores compiled code of [dualbody](https://docs.rs/dualbody), and finds it by its sources.
//!
//! `dualbody-native` and `dualbody-cuda` use it. A file or folder is written under a temporary name and renamed when it is complete, so programs that
//! compile the same code at the same time never read a part of it. No file is removed.
//!
//! # Examples
//! ```
//! use dualbody_cache::{Cache, FileError};
//!
//! let cache = Cache::new(std::env::temp_dir().join("dualbody-cache-example"));
//! let path = cache.path("answer", ["what was compiled", "by what", "with which flags"]);
//! if !path.exists() {
//!     let compile = |path: &std::path::Path| std::fs::write(path, "42").map_err(FileError::at(path));
//!     cache.keep(&path, compile)?;
//! }
//! assert_eq!(std::fs::read(&path).map_err(FileError::at(&path))?, b"42");
//! # Ok::<(), FileError>(())
//! ```

#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{env, fs, io, process};

use sha2::{Digest, Sha256};

/// A folder of files or folders that are made once.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
}

/// Error for a file or folder that cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}", path = .path.display())]
pub struct FileError {
    /// The file or folder.
    pub path: PathBuf,
    /// Reason of the system.
    pub reason: io::Error,
}

impl FileError {
    /// Adds the path to an error of the system.
    pub fn at(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        |reason| Self { path, reason }
    }
}

impl Cache {
    /// The folder, which is made when something is kept in it, so that only its owner may write to it.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
        }
    }

    /// The folder of a name among the user's caches; `None` if neither `XDG_CACHE_HOME` nor `HOME` is set.
    pub fn of_user(name: &str) -> Option<Self> {
        let set = |variable: &str| {
            let path = env::var_os(variable).filter(|path| !path.is_empty());
            path.map(PathBuf::from)
        };
        let all = set("XDG_CACHE_HOME").or_else(|| Some(set("HOME")?.join(".cache")))?;
        Some(Self::new(all.join(name)))
    }

    /// The folder that was chosen, else that of a name [among the user's](Self::of_user).
    pub fn or_of_user(chosen: Option<&Self>, name: &str) -> Option<Self> {
        chosen.cloned().or_else(|| Self::of_user(name))
    }

    /// The path of a file that is made from texts, in their order, whether or not it exists: `name` and a hash of the texts.
    pub fn path<'a>(&self, name: &str, texts: impl IntoIterator<Item = &'a str>) -> PathBuf {
        let mut hash = Sha256::new();
        for text in texts {
            // The length distinguishes "ab", "c" from "a", "bc".
            hash.update((text.len() as u64).to_le_bytes());
            hash.update(text);
        }
        let hash = hash.finalize();
        let digits: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
        self.folder.join(format!("{name}-{digits}"))
    }

    /// Makes a file or folder at a path of this one. A file that is there is replaced; of a folder that another program has made
    /// meanwhile the other's stays.
    ///
    /// * `make` – makes it at the path that it is given
    ///
    /// # Errors
    /// If `make` fails, or it cannot be moved to its path; nothing is left of it then.
    pub fn keep<E: From<FileError>>(
        &self,
        path: &Path,
        make: impl FnOnce(&Path) -> Result<(), E>,
    ) -> Result<(), E> {
        make_private(&self.folder).map_err(FileError::at(&self.folder))?;
        let own = unfinished(path);
        let kept = make(&own).and_then(|()| Ok(finish(&own, path)?));
        if kept.is_err() {
            // The rest is unused.
            let _ = fs::remove_dir_all(&own).or_else(|_| fs::remove_file(&own));
        }
        kept
    }
}

/// Makes a folder that only its owner may write to, if it is not there.
fn make_private(folder: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

/// A path beside the final one, of this call alone.
fn unfinished(path: &Path) -> PathBuf {
    static CALLS: AtomicUsize = AtomicUsize::new(0);
    let call = CALLS.fetch_add(1, Ordering::Relaxed);
    path.with_extension(format!("{}-{call}", process::id()))
}

/// Gives a file or folder its final name, unless a folder is there already.
fn finish(own: &Path, path: &Path) -> Result<(), FileError> {
    match fs::rename(own, path) {
        Err(_) if path.is_dir() => fs::remove_dir_all(own).map_err(FileError::at(own)),
        renamed => renamed.map_err(FileError::at(path)),
    }
}

#[cfg(test)]
mod tests;
