//! Sites: named poses on bodies.

use super::body::BodyEntry;
use super::geom::ends;
use super::orientation::pose;
use super::walk::Part;
use crate::error::LoadError;
use crate::io::context::Context;

/// Looks of a site, which nothing here shows.
const LOOKS: [&str; 6] = ["size", "type", "rgba", "material", "group", "user"];

/// Reads a site.
pub(super) fn read(
    part: &Part<'_, '_>,
    body: &mut BodyEntry,
    context: &mut Context<'_>,
) -> Result<(), LoadError> {
    let entry = part.entry(&["site"])?;
    let place = part.node.place();
    for name in LOOKS {
        entry.value(name);
    }
    let placement = match ends(&entry)? {
        Some(ends) => ends.X,
        None => pose(&entry, &part.source.compiler)?,
    };
    let placement = part.X * placement;
    match part.name() {
        Some(name) => body.sites.push((name, placement, place)),
        None => context.ignore(&place, "a site without a name is no frame"),
    }
    Ok(())
}
