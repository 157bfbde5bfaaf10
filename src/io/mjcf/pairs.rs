//! Pairs of bodies and geoms that may touch.

use super::assemble;
use super::body::Bodies;
use super::contact;
use super::scene::{MjcfContacts, MjcfGeom, MjcfPair};
use super::scenery::WORLD;
use super::walk::Part;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::nested::IntoNested;

/// Reads a pair of a `<contact>` section.
pub(super) fn read_pair(
    part: &Part<'_, '_>,
    contacts: &mut MjcfContacts,
    context: &mut Context<'_>,
) -> Result<(), LoadError> {
    let entry = part.entry(&["pair"])?;
    let names = |names: [&'static str; 2]| -> Result<[String; 2], LoadError> {
        let name = |name| {
            let own = entry.text(name).ok_or_else(|| entry.missing(name));
            own.map(|own| match own {
                WORLD => own.to_owned(),
                _ => part.naming.of(own),
            })
        };
        Ok([name(names[0])?, name(names[1])?])
    };
    if entry.node.tag() == "exclude" {
        contacts.excluded.push(names(["body1", "body2"])?);
        return Ok(());
    }
    let pair = contact::of_pair(&entry, names(["geom1", "geom2"])?)?;
    for reason in pair.unmodelled() {
        context.ignore(&entry.node.place(), reason);
    }
    contacts.pairs.push(pair);
    Ok(())
}

impl MjcfPair {
    /// What simulators do not use.
    fn unmodelled(&self) -> impl Iterator<Item = &'static str> {
        let [first, second, _, rolling, other] = self.friction;
        let all = [
            (
                self.condim >= 3 && first != second,
                "friction: the first coefficient acts along both tangents",
            ),
            (
                self.condim >= 6 && rolling != other,
                "friction: the first coefficient of rolling acts about both tangents",
            ),
        ];
        all.into_iter()
            .filter_map(|(is, reason)| is.then_some(reason))
    }
}

impl MjcfContacts {
    /// Remarks on more kinds of surfaces than are told apart.
    pub(super) fn note_kinds(&self, bodies: &Bodies, context: &mut Context<'_>) {
        let geoms = bodies.entries.iter().nested(|body| &body.contacts);
        let first = bodies.entries.first().filter(|_| self.kinds(geoms).1);
        if let Some(first) = first {
            let reason = "friction, solref, solimp: too many kinds of geoms; those beyond the first 64 touch as the first two geoms that can";
            context.warn(&first.place, reason);
        }
    }

    /// The pairs with all geoms that touch, and the ground.
    ///
    /// * `floats` – whether the world is not a link, so that its shapes do not touch
    pub(super) fn placed(mut self, bodies: &Bodies, floats: bool) -> Self {
        for (index, body) in bodies.entries.iter().enumerate().skip(usize::from(floats)) {
            let link = assemble::link_of(index, body);
            let geoms = body.contacts.iter().cloned();
            self.geoms.extend(geoms.map(|geom| MjcfGeom {
                link: link.to_owned(),
                ..geom
            }));
        }
        if !floats {
            let (scenery, geoms): (Vec<_>, Vec<_>) = bodies.scenery.iter().cloned().unzip();
            self.scenery = scenery;
            self.geoms.extend(geoms.into_iter().map(|geom| MjcfGeom {
                link: WORLD.to_owned(),
                ..geom
            }));
        }
        self.ground.clone_from(&bodies.ground);
        self.heights.clone_from(&bodies.heights);
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
