//! Contacts of a scene: links with the ground, and bodies with each other.

use std::collections::HashMap;

use super::contact::Touch;
use super::scene::{MjcfGeom, MjcfPair, MjcfScene};
use super::scenery::{Scenery, WORLD};
use super::surfaces::{Kind, kind};
use crate::collision::Groups;
use crate::contact::{
    CollisionOptions, ContactLaw, ContactOptions, Contacts, LinkShapes, RelaxedRigid, Terrain,
};
use crate::error::UnknownName;
use crate::nested::IntoNested;
use crate::sorting::sort_seldom;
use crate::spatial::Transform;

/// Kinds of geoms that touch others by one rule: more do not fit in the bits of groups.
const MOST_KINDS: usize = 32;

/// Geoms that are compared to find whether some touch.
const MOST_COMPARED: usize = 200;

impl MjcfScene {
    /// The contacts; `None` where nothing can touch.
    pub(super) fn touching(&self) -> Option<Contacts> {
        let between = self.between();
        let ground = self.contacts.ground.as_ref();
        let heights = self.contacts.heights.clone().map(Terrain::HeightField);
        let ground =
            ground.and_then(|(pose, geom)| Some((heights.or_else(|| terrain(pose))?, geom)));
        let links = ground.as_ref().map(|(_, geom)| self.links_on(geom));
        let links = links.unwrap_or_default();
        if links.is_empty() && between.is_none() {
            return None;
        }
        let model = &self.model;
        let law = between.map_or_else(RelaxedRigid::default, |own| own.law(&self.options));
        let terrain = ground.map(|(terrain, _)| terrain);
        let options = ContactOptions::default();
        let contacts = match terrain.filter(|_| !links.is_empty()) {
            Some(terrain) => {
                let names: Vec<&str> = links.iter().map(|(link, _)| *link).collect();
                let contacts = Contacts::with_options(model, terrain, relaxed(law), &options);
                contacts.ok()?.with_links(model, &names).ok()?
            }
            None => {
                let none = Terrain::flat(0.0);
                let contacts = Contacts::new(model, none, relaxed(law));
                contacts.with_selection(|_| false)
            }
        };
        let with_law = |contacts: Contacts, (link, touch): &(&str, Touch)| {
            let law = touch.law(&self.options);
            let contacts = contacts.with_law(model, link, relaxed(law)).ok()?;
            let contacts = contacts.with_margin(model, link, touch.margin).ok()?;
            (contacts.with_turning_friction(model, link, touch.turning)).ok()
        };
        let contacts = links.iter().try_fold(contacts, with_law)?;
        match between {
            Some(own) => self.with_pairs(contacts, relaxed(law), &own),
            None => Some(contacts),
        }
    }

    /// Links that touch the ground, with the parameters of their first geom that does and the largest friction and margin of all of them.
    fn links_on<'a>(&'a self, ground: &MjcfGeom) -> Vec<(&'a str, Touch)> {
        let mut links: Vec<(&str, Touch)> = Vec::new();
        let geoms = self.contacts.geoms.iter();
        let touching = geoms.filter(|own| self.may_touch(own, ground) && self.moves(&own.link));
        for geom in touching {
            let touch = self.touch(geom, ground);
            match links.iter_mut().rfind(|(link, _)| *link == geom.link) {
                Some((_, own)) => own.merge(&touch),
                None => links.push((&geom.link, touch)),
            }
        }
        links
    }

    /// The parameters of contacts between bodies, if geoms can touch: those of the first two that can.
    fn between(&self) -> Option<Touch> {
        // Those that are fixed to the world do not touch each other.
        let mut kinds: HashMap<(Kind<'_>, bool), Vec<&MjcfGeom>> = HashMap::new();
        let paired = self.contacts.paired();
        for geom in &self.contacts.geoms {
            let own = (kind(geom, &paired), self.moves(&geom.link));
            let alike = kinds.entry(own).or_default();
            // Two links of a kind represent all: they show whether it touches others, and itself.
            if alike.len() < 2 && alike.iter().all(|own| own.link != geom.link) {
                alike.push(geom);
            }
        }
        let mut all: Vec<&MjcfGeom> = kinds.into_values().flatten().collect();
        let place = |geom: &MjcfGeom| {
            let mut geoms = self.contacts.geoms.iter();
            geoms.position(|own| std::ptr::eq(own, geom))
        };
        sort_seldom(&mut all, |one, other| place(one).cmp(&place(other)));
        all.truncate(MOST_COMPARED);
        let pairs = (all.iter().enumerate())
            .nested(|(i, one)| all[..i].iter().map(move |other| (other, one)));
        let mut touching = pairs.filter(|(one, other)| {
            let moves = self.moves(&one.link) || self.moves(&other.link);
            one.link != other.link && moves && self.may_touch(one, other)
        });
        touching.next().map(|(one, other)| self.touch(one, other))
    }

    /// Whether two geoms touch: by their types, or as a pair.
    pub(super) fn may_touch(&self, one: &MjcfGeom, other: &MjcfGeom) -> bool {
        let mut pairs = self.contacts.pairs.iter();
        one.touches(other) || pairs.any(|own| own.names(one, other))
    }

    /// The contacts with those between bodies.
    fn with_pairs(&self, contacts: Contacts, law: ContactLaw, touch: &Touch) -> Option<Contacts> {
        let model = &self.model;
        let mut shapes = LinkShapes::new(model);
        self.add_scenery(&mut shapes).ok()?;
        shapes.let_neighbours_touch(model, self.contacts.neighbours_touch);
        self.group(&mut shapes);
        self.set_surfaces(&mut shapes, touch);
        let has_shapes = |link: &String| shapes.find_link(model, link).is_ok();
        let excluded = self.contacts.excluded.iter();
        let excluded = excluded.filter(|[a, b]| has_shapes(a) && has_shapes(b));
        let excluded: Vec<[&str; 2]> = excluded.map(|[a, b]| [a.as_str(), b.as_str()]).collect();
        shapes.exclude(model, &excluded).ok()?;
        if !any_may_touch(&shapes) {
            return Some(contacts);
        }
        let options = CollisionOptions {
            turning: touch.turning,
            ..CollisionOptions::default().with_self_collision()
        };
        contacts.with_link_shapes(model, law, shapes, &options).ok()
    }

    /// Adds the scenery behind all other shapes.
    pub(super) fn add_scenery(&self, shapes: &mut LinkShapes) -> Result<(), UnknownName> {
        let model = &self.model;
        for own in &self.contacts.scenery {
            match own {
                Scenery::Plane(pose) => shapes.add_half_space(model, WORLD, *pose)?,
                Scenery::Heights(surface) => shapes.add_surface(model, WORLD, surface)?,
            }
        }
        Ok(())
    }

    /// Puts the shapes of geoms into groups: a group for each kind of them.
    fn group(&self, shapes: &mut LinkShapes) {
        let paired = self.contacts.paired();
        let mut kinds: Vec<(Kind<'_>, &MjcfGeom)> = Vec::new();
        for geom in &self.contacts.geoms {
            let kind = kind(geom, &paired);
            if kinds.len() < MOST_KINDS && kinds.iter().all(|(own, _)| *own != kind) {
                kinds.push((kind, geom));
            }
        }
        let groups = |geom: &MjcfGeom| {
            let is_own = |(own, _): &(Kind<'_>, &MjcfGeom)| *own == kind(geom, &paired);
            let own = kinds.iter().position(is_own)?;
            let touched = kinds.iter().enumerate();
            let touched = touched.filter(|(_, (_, other))| self.may_touch(geom, other));
            Some(Groups {
                own: 1 << own,
                mask: touched.fold(0, |mask, (k, _)| mask | 1 << k),
            })
        };
        let geoms = self.geoms_of(shapes);
        for (shape, geom) in shapes.shapes_mut().iter_mut().zip(geoms) {
            if let Some(groups) = geom.and_then(groups) {
                shape.groups = groups;
            }
        }
    }

    /// Whether a frame moves.
    pub(super) fn moves(&self, link: &str) -> bool {
        let frame = self.model.frame(link);
        frame.is_some_and(|frame| self.model.frames()[frame.0].body.is_some())
    }
}

/// Whether some shapes may touch each other: taken for granted where there are very many.
fn any_may_touch(shapes: &LinkShapes) -> bool {
    /// Shapes of which all pairs are looked at.
    const FEW: usize = 1000;
    let n = shapes.shapes().len();
    n > FEW || (0..n).any(|i| (0..i).any(|j| shapes.may_touch(i, j)))
}

fn relaxed(law: RelaxedRigid) -> ContactLaw {
    ContactLaw::RelaxedRigid(law)
}

/// The plane z = 0 of a pose as terrain, if its normal points up.
pub(super) fn terrain(pose: &Transform<f64>) -> Option<Terrain> {
    /// Least height of the normal: steeper ground has no height over its points.
    const LEAST: f64 = 1e-3;
    let normal = pose.rotation.column(2).into_owned();
    let is_finite = pose.translation.iter().all(|x| x.is_finite());
    (is_finite && normal.z > LEAST).then(|| Terrain::plane(pose.translation.into(), normal.into()))
}

impl MjcfPair {
    /// Whether these are its geoms.
    pub(super) fn names(&self, one: &MjcfGeom, other: &MjcfGeom) -> bool {
        let named = |geom: &MjcfGeom, name: &String| geom.name.as_ref() == Some(name);
        let [a, b] = &self.geoms;
        named(one, a) && named(other, b) || named(one, b) && named(other, a)
    }
}
