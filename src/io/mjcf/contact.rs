//! Numbers of contact: of geoms, and which pairs touch.

use super::entry::Entry;
use super::scene::{MjcfContacts, MjcfGeom};
use super::walk::Part;
use crate::error::LoadError;
use crate::io::context::Context;

/// Numbers of a geom where nothing else is said.
const FRICTION: [f64; 3] = [1.0, 0.005, 0.0001];
const SOLREF: [f64; 2] = [0.02, 1.0];
const SOLIMP: [f64; 5] = [0.9, 0.95, 0.001, 0.5, 2.0];

/// Dimensions that a contact force can have.
const CONDIMS: [(&str, u8); 4] = [("1", 1), ("3", 3), ("4", 4), ("6", 6)];

/// Reads the numbers of a geom.
pub(super) fn of_geom(entry: &Entry<'_, '_>) -> Result<MjcfGeom, LoadError> {
    let friction = entry.some_numbers("friction", FRICTION)?;
    if friction.iter().any(|&mu| mu < 0.0) {
        return Err(entry.malformed("friction", "is negative"));
    }
    Ok(MjcfGeom {
        name: None,
        link: String::new(),
        friction,
        condim: entry.word("condim", &CONDIMS)?.unwrap_or(3),
        priority: entry.integer("priority")?.unwrap_or(0),
        contype: bits(entry, "contype")?,
        conaffinity: bits(entry, "conaffinity")?,
        solref: entry.some_numbers("solref", SOLREF)?,
        solimp: entry.some_numbers("solimp", SOLIMP)?,
        margin: entry.number("margin")?.unwrap_or_default(),
        gap: entry.number("gap")?.unwrap_or_default(),
        solmix: entry.number("solmix")?.unwrap_or(1.0),
    })
}

fn bits(entry: &Entry<'_, '_>, name: &'static str) -> Result<u32, LoadError> {
    Ok(entry.integer(name)?.unwrap_or(1).cast_unsigned())
}

/// Reads a pair of a `<contact>` section.
pub(super) fn read_pair(
    part: &Part<'_, '_>,
    contacts: &mut MjcfContacts,
    context: &mut Context<'_>,
) -> Result<(), LoadError> {
    let entry = part.entry(&["pair"])?;
    let (names, out, reason) = match entry.node.tag() {
        "exclude" => {
            let reason = "kept in MjcfScene::contacts: links do not touch one another here anyway";
            (["body1", "body2"], &mut contacts.excluded, reason)
        }
        _ => {
            let reason = "kept in MjcfScene::contacts: links do not touch one another here";
            (["geom1", "geom2"], &mut contacts.pairs, reason)
        }
    };
    let [one, other] = names.map(|name| {
        let own = entry.text(name).ok_or_else(|| entry.missing(name));
        own.map(|own| part.naming.of(own))
    });
    out.push([one?, other?]);
    entry.node.read_all();
    context.ignore(&entry.node.place(), reason);
    Ok(())
}
