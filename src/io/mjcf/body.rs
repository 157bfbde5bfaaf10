//! Bodies with their joints, inertias, shapes and sites.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::HashSet;

use super::documents::Source;
use super::entry::Choice;
use super::geom::Geom;
use super::inertial;
use super::joint::{self, JointEntry};
use super::naming::Naming;
use super::orientation::pose;
use super::scene::MjcfGeom;
use super::scenery::Scenery;
use super::site::{self, Site};
use super::tree::Node;
use super::walk::{Part, Walk};
use crate::contact::HeightField;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::io::names::Names;
use crate::io::place::SourcePlace;
use crate::model::{Collision, Visual};
use crate::nested::IntoNested;
use crate::spatial::{Inertia, Transform};

/// A body; the first one is the world.
#[derive(Debug)]
pub(super) struct BodyEntry {
    /// Its name; empty until one is made up, where it has none.
    pub(super) name: String,
    pub(super) parent: usize,
    pub(super) X_PB: Transform<f64>,
    pub(super) joints: Vec<JointEntry>,
    pub(super) inertia: Inertia<f64>,
    /// Part of its weight that is balanced.
    pub(super) gravcomp: f64,
    pub(super) visuals: Vec<Visual>,
    pub(super) collisions: Vec<Collision>,
    /// Numbers of contact of the collisions, in their order.
    pub(super) contacts: Vec<MjcfGeom>,
    /// Shapes that touch by their names only, as parts of pairs.
    pub(super) idle: Vec<(Collision, MjcfGeom)>,
    pub(super) sites: Vec<Site>,
    pub(super) place: SourcePlace,
}

/// All bodies of a description.
#[derive(Debug)]
pub(super) struct Bodies {
    pub(super) entries: Vec<BodyEntry>,
    /// The first plane or height field on the world, with its pose.
    pub(super) ground: Option<(Transform<f64>, MjcfGeom)>,
    /// Its heights, if it is a height field.
    pub(super) heights: Option<HeightField>,
    /// Other planes and height fields on the world.
    pub(super) scenery: Vec<(Scenery, MjcfGeom)>,
    /// The first geom of which something is [not modelled](Self::note_unmodelled), and how many there are.
    pub(super) unmodelled: Option<(SourcePlace, usize)>,
}

/// Reads the bodies of a description.
pub(super) fn read<'t, 'c>(
    sources: &'c [Source<'t>],
    walk: &mut Walk<'t, 'c>,
    context: &mut Context<'_>,
) -> Result<Bodies, LoadError> {
    let mut bodies = Bodies {
        entries: Vec::new(),
        ground: None,
        heights: None,
        scenery: Vec::new(),
        unmodelled: None,
    };
    let root = sources[0].root;
    bodies.entries.push(BodyEntry::new(
        String::new(),
        0,
        Transform::identity(),
        root,
    ));
    let mut open = Vec::new();
    for world in root.all("worldbody") {
        let part = Part::of(world, &sources[0], Naming::plain());
        let mut inside = bodies.parts(&part, 0, walk, context)?;
        inside.extend(open);
        open = inside;
    }
    while let Some((part, parent)) = open.pop() {
        let entry = part.plain();
        let X_PB = part.X * pose(&entry, &part.source.compiler)?;
        let index = bodies.entries.len();
        let mut body = BodyEntry::new(part.name().unwrap_or_default(), parent, X_PB, part.node);
        body.gravcomp = entry.number("gravcomp")?.unwrap_or_default();
        if entry.flag("mocap", false)? {
            context.ignore(
                &body.place,
                "mocap: the body is fixed at its pose in the file",
            );
        }
        bodies.entries.push(body);
        let own = Part {
            X: Transform::identity(),
            ..part
        };
        open.extend(bodies.parts(&own, index, walk, context)?);
    }
    bodies.balance(&sources[0])?;
    bodies.make_names();
    Ok(bodies)
}

/// The inertia that a geom gives its body, if it is of a group that does.
fn mass(geom: &Geom, part: &Part<'_, '_>, context: &mut Context<'_>) -> Inertia<f64> {
    let [least, largest] = part.source.compiler.inertiagrouprange;
    if !(least..=largest).contains(&geom.group) {
        return Inertia::zero();
    }
    match geom.inertia() {
        Ok(own) => part.X.inertia(&own),
        Err(reason) => {
            context.warn(&part.node.place(), reason);
            Inertia::zero()
        }
    }
}

impl BodyEntry {
    fn new(name: String, parent: usize, X_PB: Transform<f64>, node: Node<'_>) -> Self {
        Self {
            name,
            parent,
            X_PB,
            joints: Vec::new(),
            inertia: Inertia::zero(),
            gravcomp: 0.0,
            visuals: Vec::new(),
            collisions: Vec::new(),
            contacts: Vec::new(),
            idle: Vec::new(),
            sites: Vec::new(),
            place: node.place(),
        }
    }
}

impl Bodies {
    /// Reads the children of a body; returns the bodies among it, the first one last.
    fn parts<'t, 'c>(
        &mut self,
        of: &Part<'t, 'c>,
        index: usize,
        walk: &mut Walk<'t, 'c>,
        context: &mut Context<'_>,
    ) -> Result<Vec<(Part<'t, 'c>, usize)>, LoadError> {
        let inside = walk.inside(of)?;
        let has_inertial = inside.iter().any(|part| part.node.tag() == "inertial");
        let of_geoms = index > 0
            && match of.source.compiler.inertiafromgeom {
                Choice::Yes => true,
                Choice::No => false,
                Choice::Auto => !has_inertial,
            };
        let mut inner = Vec::new();
        let mut stated = Inertia::zero();
        let mut sum = Inertia::zero();
        for part in inside {
            match part.node.tag() {
                "body" => inner.push((part, index)),
                "joint" | "freejoint" => self.joint(&part, index, context)?,
                "geom" => {
                    let geom = self.geom(&part, index, context)?;
                    if of_geoms {
                        sum = sum + mass(&geom, &part, context);
                    }
                }
                "site" => self.entries[index]
                    .sites
                    .extend(site::read(&part, context)?),
                "inertial" if index > 0 => {
                    let own = inertial::read(&part.plain(), &part.source.compiler)?;
                    stated = part.X.inertia(&own);
                }
                _ => {}
            }
        }
        if index > 0 {
            let inertia = if of_geoms { sum } else { stated };
            self.entries[index].inertia = inertial::bounded(inertia, &of.source.compiler);
        }
        inner.reverse();
        Ok(inner)
    }

    fn joint(
        &mut self,
        part: &Part<'_, '_>,
        index: usize,
        context: &mut Context<'_>,
    ) -> Result<(), LoadError> {
        let entry = match part.node.tag() {
            "freejoint" => part.plain(),
            _ => part.entry(&["joint"])?,
        };
        let mut joint = joint::read(&entry, &part.source.compiler, &part.X, context)?;
        joint.name = part.name().unwrap_or_default();
        if index == 0 {
            let reason = "the world has no joints";
            return Err(part.node.place().unsupported(reason));
        }
        let body = &mut self.entries[index];
        let is_free = |joint: &JointEntry| joint.kind == joint::Kind::Free;
        body.joints.push(joint);
        let on_world = body.parent == 0;
        if body.joints.iter().any(is_free) && !(on_world && body.joints.len() == 1) {
            let reason = "a free joint is the only one of a body of the world";
            return Err(part.node.place().unsupported(reason));
        }
        Ok(())
    }

    /// Reads a geom and adds its shape to a body.
    fn geom(
        &mut self,
        part: &Part<'_, '_>,
        index: usize,
        context: &mut Context<'_>,
    ) -> Result<Geom, LoadError> {
        let source = part.source;
        let entry = part.entry(&["geom"])?;
        let mut geom = Geom::read(&entry, &source.compiler, &source.assets)?;
        geom.contact.name = part.name();
        let contact = &geom.contact;
        let differs = |first: Option<&MjcfGeom>| first.is_some_and(|own| !own.is_like(contact));
        if differs(self.entries[index].contacts.first()) && geom.touches() {
            let first = || (part.node.place(), 0);
            self.unmodelled.get_or_insert_with(first).1 += 1;
        }
        self.shape(&geom, part.X * geom.X, index, &part.node.place(), context);
        Ok(geom)
    }

    /// Adds a shape to a body.
    fn shape(
        &mut self,
        geom: &Geom,
        placement: Transform<f64>,
        index: usize,
        place: &SourcePlace,
        context: &mut Context<'_>,
    ) {
        let Some(geometry) = geom.geometry().cloned() else {
            self.scene_shape(geom, placement, index, place, context);
            return;
        };
        let name = geom.contact.name.clone();
        let body = &mut self.entries[index];
        if geom.is_shown() {
            body.visuals.push(Visual {
                name: name.clone(),
                placement,
                geometry: geometry.clone(),
                color: geom.color,
            });
        }
        let collision = Collision {
            name,
            placement,
            geometry,
        };
        if geom.touches() {
            body.collisions.push(collision);
            body.contacts.push(geom.contact.clone());
        } else if collision.name.is_some() {
            body.idle.push((collision, geom.contact.clone()));
        }
    }

    /// Scales all masses to the sum that is requested.
    fn balance(&mut self, main: &Source<'_>) -> Result<(), LoadError> {
        let wanted = main.compiler.settotalmass;
        let total: f64 = self.entries.iter().map(|body| body.inertia.mass).sum();
        if wanted <= 0.0 || total <= 0.0 {
            return Ok(());
        }
        for body in &mut self.entries {
            body.inertia = body.inertia.scaled(wanted / total);
        }
        Ok(())
    }

    /// Lets shapes touch that pairs name.
    pub(super) fn pair(&mut self, names: &HashSet<&str>) {
        for body in &mut self.entries {
            for (collision, contact) in std::mem::take(&mut body.idle) {
                let is_paired = contact
                    .name
                    .as_deref()
                    .is_some_and(|own| names.contains(own));
                if is_paired {
                    body.collisions.push(collision);
                    body.contacts.push(contact);
                }
            }
        }
    }

    /// Makes up names: of bodies by their number, of joints after their body.
    fn make_names(&mut self) {
        let mut bodies = Names::of(self.entries.iter().map(|body| body.name.as_str()));
        let joints = self.entries.iter().nested(|body| &body.joints);
        let mut joints = Names::of(joints.map(|joint| joint.name.as_str()));
        for (i, body) in self.entries.iter_mut().enumerate().skip(1) {
            if body.name.is_empty() {
                body.name = bodies.fresh(format!("body_{i}"));
            }
            let idle = body.idle.iter_mut().map(|(_, contact)| contact);
            for contact in body.contacts.iter_mut().chain(idle) {
                contact.link.clone_from(&body.name);
            }
            for (k, joint) in body.joints.iter_mut().enumerate() {
                if joint.name.is_empty() {
                    let number = if k == 0 { String::new() } else { k.to_string() };
                    joint.name = joints.fresh(format!("{}::joint{number}", body.name));
                }
            }
        }
    }
}
