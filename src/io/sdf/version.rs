//! Versions of the SDF.

use crate::error::LoadError;
use crate::io::context::{Context, Node};
use crate::io::version::Version;

/// The oldest that is read.
const FIRST: Version = Version(1, 5);
/// The newest that is known.
const LAST: Version = Version(1, 11);
/// The first that has `relative_to`, `attached_to` and `expressed_in`.
pub(super) const WITH_FRAMES: Version = Version(1, 7);
/// The first that has degrees and quaternions.
pub(super) const WITH_ROTATION_FORMATS: Version = Version(1, 9);
/// The first in which joints follow each other.
pub(super) const WITH_MIMICS: Version = Version(1, 11);

/// The version of a file, brought into the range that is known.
pub(super) fn read(context: &mut Context<'_>, root: Node<'_>) -> Result<Version, LoadError> {
    let text = root.attribute("version").unwrap_or_default().trim();
    if text.is_empty() {
        return Err(context.missing(root, "attribute version"));
    }
    let Some(version) = Version::parse(text) else {
        let reason = "expected a version like 1.9";
        return Err(context.malformed(root, "version", reason));
    };
    let known = version.clamp(FIRST, LAST);
    if known != version {
        let Version(major, minor) = known;
        context.warn(root, format!("version {text} is read as {major}.{minor}"));
    }
    Ok(known)
}

/// `true` unless files of a version may contain unknown elements.
pub(super) fn is_known(version: Version) -> bool {
    version <= LAST
}
