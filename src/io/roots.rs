//! The folders below which files may be.

use std::borrow::Cow;
use std::fs;
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

/// Folders below which files may be, without symbolic links; everywhere, until the first is added.
#[derive(Clone, Debug, Default)]
pub(super) struct Roots(Option<Vec<PathBuf>>);

impl Roots {
    /// Allows what is below a folder. One that does not exist allows nothing.
    pub(super) fn add(&mut self, folder: &Path) {
        let folders = self.0.get_or_insert_default();
        folders.extend(fs::canonicalize(folder));
    }

    /// `true` if only what is below some folders is allowed.
    pub(super) fn are_given(&self) -> bool {
        self.0.is_some()
    }

    /// The path by which a file may be read: as it is, or with all links followed if only some folders are allowed.
    /// The error does not reveal whether there is a file elsewhere.
    pub(super) fn admit<'p>(&self, path: &'p Path) -> Result<Cow<'p, Path>> {
        let Some(folders) = &self.0 else {
            return Ok(path.into());
        };
        let real = fs::canonicalize(path).ok();
        let is_below = |path: &PathBuf| folders.iter().any(|folder| path.starts_with(folder));
        let found = real.filter(is_below).map(Cow::Owned);
        let reason = "not found below the root folders";
        found.ok_or_else(|| Error::new(ErrorKind::NotFound, reason))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::temporary::Folder;

    #[test]
    fn files_are_admitted_below_the_folders_only_however_they_are_called() {
        let root = Folder::new();
        let inside = root.write("a/in.stl", "");
        let outside = root.write("b/out.stl", "");
        let up = root.path("a/../b/out.stl");
        let mut roots = Roots::default();
        assert_eq!(roots.admit(&up).unwrap(), up);
        roots.add(&root.path("a"));
        let real = fs::canonicalize(&inside).unwrap();
        assert_eq!(roots.admit(&root.path("b/../a/in.stl")).unwrap(), real);
        #[cfg(unix)]
        {
            use std::os::unix::fs::symlink;
            symlink(&outside, root.path("a/link.stl")).unwrap();
            symlink(&inside, root.path("b/link.stl")).unwrap();
            assert_eq!(roots.admit(&root.path("b/link.stl")).unwrap(), real);
            assert!(roots.admit(&root.path("a/link.stl")).is_err());
        }
        let reason = |path: &Path| roots.admit(path).unwrap_err().to_string();
        // There, or not there: no difference.
        assert_eq!(reason(&outside), reason(&root.path("b/none.stl")));
        assert_eq!(reason(&outside), reason(&up));
        // A folder whose name only begins like that of a root is not below it.
        assert!(roots.admit(&root.write("ab/out.stl", "")).is_err());

        roots.add(&root.path("b"));
        assert!(roots.admit(&outside).is_ok());
        let mut nowhere = Roots::default();
        nowhere.add(&root.path("none"));
        assert!(nowhere.admit(&inside).is_err() && nowhere.are_given());
    }
}
