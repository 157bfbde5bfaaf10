//! Versions of the SDF.

use crate::error::LoadError;
use crate::io::context::{Context, Node};

/// A version of the SDF, major before minor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Version(u32, u32);

impl Version {
    /// The oldest that is read.
    const FIRST: Self = Self(1, 5);
    /// The newest that is known.
    const LAST: Self = Self(1, 11);
    /// The first that has `relative_to`, `attached_to` and `expressed_in`.
    pub(super) const WITH_FRAMES: Self = Self(1, 7);
    /// The first that has degrees and quaternions.
    pub(super) const WITH_ROTATION_FORMATS: Self = Self(1, 9);
    /// The first in which joints follow one another.
    pub(super) const WITH_MIMICS: Self = Self(1, 11);

    /// The version of a file, brought into the range that is known.
    pub(super) fn read(context: &mut Context<'_>, root: Node<'_>) -> Result<Self, LoadError> {
        let text = root.attribute("version").unwrap_or_default().trim();
        if text.is_empty() {
            return Err(context.missing(root, "attribute version"));
        }
        let Some(version) = Self::parse(text) else {
            let reason = "expected a version like 1.9";
            return Err(context.malformed(root, "version", reason));
        };
        let known = version.clamp(Self::FIRST, Self::LAST);
        if known != version {
            let Self(major, minor) = known;
            context.warn(root, format!("version {text} is read as {major}.{minor}"));
        }
        Ok(known)
    }

    /// The version that a text like `1.9` means.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let (major, minor) = text.trim().split_once('.')?;
        Some(Self(major.parse().ok()?, minor.parse().ok()?))
    }

    /// `true` unless files of it may hold what no one here has heard of.
    pub(super) fn is_known(self) -> bool {
        self <= Self::LAST
    }
}
