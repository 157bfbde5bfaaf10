//! Sites: named poses on bodies.

use super::body::BodyEntry;
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
    if entry.text("fromto").is_some() {
        context.ignore(&place, "fromto: the place of the site is that of its pos");
    }
    let placement = part.X * pose(&entry, &part.source.compiler)?;
    match part.name() {
        Some(name) => body.sites.push((name, placement, place)),
        None => context.ignore(&place, "a site without a name is no frame"),
    }
    Ok(())
}
