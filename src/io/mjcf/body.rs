//! Bodies with their joints, inertias, shapes and sites.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::documents::Source;
use super::entry::Choice;
use super::geom::Geom;
use super::inertial;
use super::joint::{self, JointEntry};
use super::naming::Naming;
use super::orientation::pose;
use super::references::References;
use super::scene::MjcfGeom;
use super::scenery::Scenery;
use super::site::{self, Site};
use super::tree::Node;
use super::walk::{Part, Walk};
use crate::contact::HeightField;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::io::place::SourcePlace;
use crate::model::{Collision, Visual};
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
    /// The names of all parts, until sections take them.
    pub(super) references: References,
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
        references: References::new(sources),
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
    bodies.references.check_targets()?;
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
            self.references.add("worldbody", &part);
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
}
