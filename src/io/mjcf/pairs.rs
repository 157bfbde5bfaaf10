//! Pairs of bodies and geoms that may touch.

use super::body::Bodies;
use super::scene::MjcfContacts;
use super::walk::Part;
use crate::error::LoadError;
use crate::io::context::Context;

/// Reads a pair of a `<contact>` section.
pub(super) fn read_pair(part: &Part<'_, '_>, contacts: &mut MjcfContacts) -> Result<(), LoadError> {
    let entry = part.entry(&["pair"])?;
    let (names, out) = match entry.node.tag() {
        "exclude" => (["body1", "body2"], &mut contacts.excluded),
        _ => (["geom1", "geom2"], &mut contacts.pairs),
    };
    let [one, other] = names.map(|name| {
        let own = entry.text(name).ok_or_else(|| entry.missing(name));
        own.map(|own| part.naming.of(own))
    });
    out.push([one?, other?]);
    Ok(())
}

impl MjcfContacts {
    /// The pairs with all geoms that touch, and the ground.
    ///
    /// * `floats` – whether the world is not a link, so that its shapes do not touch
    pub(super) fn placed(mut self, bodies: &Bodies, floats: bool) -> Self {
        for body in bodies.entries.iter().skip(usize::from(floats)) {
            self.geoms.extend(body.contacts.iter().cloned());
        }
        self.ground.clone_from(&bodies.ground);
        self
    }
}

/// Excludes bodies that several joints connect, as `MuJoCo` excludes those that one does, with what is fixed to them.
pub(super) fn exclude_neighbours(
    bodies: &Bodies,
    contacts: &mut MjcfContacts,
    context: &mut Context<'_>,
) {
    /// Most pairs: files have some tens.
    const MOST: usize = 100_000;
    let entries = &bodies.entries;
    let mut parts: Vec<usize> = vec![0; entries.len()];
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); entries.len()];
    for (i, body) in entries.iter().enumerate() {
        parts[i] = match body.joints.is_empty() {
            true => parts[body.parent],
            false => i,
        };
        if !body.contacts.is_empty() {
            members[parts[i]].push(i);
        }
    }
    let several = (entries.iter().enumerate()).filter(|(_, body)| body.joints.len() > 1);
    for (i, body) in several.filter(|(_, body)| parts[body.parent] != 0) {
        for &a in &members[parts[body.parent]] {
            for &b in &members[i] {
                if contacts.excluded.len() >= MOST {
                    let reason = "too many bodies on several joints: some touch their neighbours";
                    return context.warn(&body.place, reason);
                }
                let names = [a, b].map(|k| entries[k].name.clone());
                contacts.excluded.push(names);
            }
        }
    }
}
