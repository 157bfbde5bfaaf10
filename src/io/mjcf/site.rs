//! Sites: named poses on bodies.

use super::geom::ends;
use super::orientation::pose;
use super::walk::Part;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::io::place::SourcePlace;
use crate::spatial::Transform;

/// Looks of a site, which nothing here shows.
const LOOKS: [&str; 6] = ["size", "type", "rgba", "material", "group", "user"];

/// A site with a name.
#[derive(Debug)]
pub(super) struct Site {
    pub(super) name: String,
    /// Pose in its body.
    pub(super) placement: Transform<f64>,
    pub(super) place: SourcePlace,
}

/// Reads a site; `None`, with a remark, for one without a name.
pub(super) fn read(
    part: &Part<'_, '_>,
    context: &mut Context<'_>,
) -> Result<Option<Site>, LoadError> {
    let entry = part.entry(&["site"])?;
    let place = part.node.place();
    for name in LOOKS {
        entry.value(name);
    }
    part.source.assets.material(&entry)?;
    let placement = match ends(&entry)? {
        Some(ends) => ends.X,
        None => pose(&entry, &part.source.compiler)?,
    };
    let placement = part.X * placement;
    let Some(name) = part.name() else {
        context.ignore(&place, "a site without a name does not become a frame");
        return Ok(None);
    };
    Ok(Some(Site {
        name,
        placement,
        place,
    }))
}
