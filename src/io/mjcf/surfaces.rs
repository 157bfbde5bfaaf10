//! Kinds of surfaces of geoms: by them pairs of bodies have contact parameters.

use std::collections::{HashMap, HashSet};

use super::contact::Touch;
use super::scene::{MjcfContacts, MjcfGeom, MjcfScene};
use crate::contact::LinkShapes;
use crate::nested::IntoNested;

/// Kinds of surfaces that are told apart. Each pair of kinds may have parameters of its own.
const MOST: usize = 64;

impl MjcfContacts {
    /// The names of geoms that pairs name.
    pub(super) fn paired(&self) -> HashSet<&str> {
        let names = self.pairs.iter().nested(|pair| &pair.geoms);
        names.map(String::as_str).collect()
    }

    /// The first geom of each kind of surface; whether there are more kinds than are told apart.
    pub(super) fn kinds<'a>(
        &self,
        geoms: impl Iterator<Item = &'a MjcfGeom>,
    ) -> (Vec<&'a MjcfGeom>, bool) {
        let (paired, mut kinds) = (self.paired(), Vec::<&MjcfGeom>::new());
        for geom in geoms {
            if kinds.iter().all(|own| !is_of_kind(geom, own, &paired)) {
                if kinds.len() == MOST {
                    return (kinds, true);
                }
                kinds.push(geom);
            }
        }
        (kinds, false)
    }
}

/// Whether two geoms touch all others alike.
fn is_of_kind(one: &MjcfGeom, other: &MjcfGeom, paired: &HashSet<&str>) -> bool {
    one.is_like(other) && kind(one, paired) == kind(other, paired)
}

/// Data that decide which other geoms a geom touches: its bits, and its name where a pair names it.
pub(super) type Kind<'a> = (u32, u32, Option<&'a str>);

pub(super) fn kind<'a>(geom: &'a MjcfGeom, paired: &HashSet<&str>) -> Kind<'a> {
    let name = geom.name.as_deref();
    let name = name.filter(|name| paired.contains(name));
    (geom.contype, geom.conaffinity, name)
}

impl MjcfScene {
    /// The parameters of a contact of two geoms: those of a pair that names them, or those of both.
    pub(super) fn touch(&self, one: &MjcfGeom, other: &MjcfGeom) -> Touch {
        let pair = self.contacts.pairs.iter().find(|own| own.names(one, other));
        pair.map_or_else(|| one.touch(other), super::scene::MjcfPair::touch)
    }

    /// Gives kinds of surfaces to shapes, and materials to the pairs of kinds that touch by other numbers than the contact model.
    pub(super) fn set_surfaces(&self, shapes: &mut LinkShapes, of_model: &Touch) {
        let (paired, geoms) = (self.contacts.paired(), &self.contacts.geoms);
        let (kinds, _) = self.contacts.kinds(geoms.iter());
        for (k, geom) in self.geoms_of(shapes).into_iter().enumerate() {
            let own =
                geom.and_then(|geom| kinds.iter().position(|own| is_of_kind(geom, own, &paired)));
            if let Some(own) = own {
                shapes.set_kind(k, number(own));
            }
        }
        for (i, one) in kinds.iter().enumerate() {
            for (j, other) in kinds.iter().enumerate().take(i + 1) {
                let touch = self.touch(other, one);
                // The contact model has no margin: that is one of materials.
                let differs = touch != *of_model || touch.margin > 0.0;
                if self.may_touch(other, one) && differs {
                    let material = touch.material(&self.options);
                    shapes.set_pair_material([number(j), number(i)], material);
                }
            }
        }
    }

    /// The geom of each shape of the scenery.
    pub(super) fn geoms_of_scenery(&self) -> impl Iterator<Item = &MjcfGeom> {
        let contacts = &self.contacts;
        let geoms = &contacts.geoms[contacts.geoms.len() - contacts.scenery.len()..];
        let each = contacts.scenery.iter().zip(geoms);
        each.nested(|(own, geom)| std::iter::repeat_n(geom, own.shapes()))
    }

    /// The geom of each shape; `None` where it has none.
    pub(super) fn geoms_of(&self, shapes: &LinkShapes) -> Vec<Option<&MjcfGeom>> {
        let mut of_link: HashMap<&str, Vec<&MjcfGeom>> = HashMap::new();
        for geom in &self.contacts.geoms {
            of_link.entry(&geom.link).or_default().push(geom);
        }
        let mut out = vec![None; shapes.shapes().len()];
        let mut next = 0;
        for link in self.model.links() {
            let frame = &self.model.frames()[link.frame.0];
            let geoms = of_link.get(frame.name.as_str()).map_or(&[][..], |own| own);
            for (k, collision) in link.collisions.iter().enumerate() {
                // Omitted shapes, such as a mesh that cannot be read, are not in the list.
                let placement = frame.placement * collision.placement;
                let own = shapes.shapes().get(next);
                if own.is_some_and(|own| own.link == link.frame && own.placement == placement) {
                    out[next] = geoms.get(k).copied();
                    next += 1;
                }
            }
        }
        let scenery = out[next..].iter_mut().zip(self.geoms_of_scenery());
        scenery.for_each(|(own, geom)| *own = Some(geom));
        out
    }
}

/// The number of a kind among shapes: 0 is none.
fn number(kind: usize) -> u32 {
    u32::try_from(kind + 1).unwrap_or(0)
}
