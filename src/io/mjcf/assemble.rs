//! Bodies to links and joints.
//!
//! The joints of a body follow each other, each about a line that goes through its anchor p: the pose of the body in its parent is
//!
//! `X_PB(q) = X_PB⁰ · Π T(pᵢ) Mᵢ(qᵢ − refᵢ) T(−pᵢ)`
//!
//! where M is the motion of a joint. Between two joints, and where the last one's anchor is not the origin of the body, is a link without
//! inertia, called like the joint. A coordinate is the number that `MuJoCo` has for it: what a reference moves is in the placement of the joint.
//!
//! A description with one body on the world, which moves freely by a joint without name, floats. Other bodies stand on a link `world`, and those that
//! move freely have joints of kind floating, by the name of the file, so that it finds them. Options choose for a single body.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::HashSet;

use nalgebra::Vector3;

use super::body::{Bodies, BodyEntry};
use super::joint::{JointEntry, Kind};
use super::orientation::about;
use super::scenery::WORLD;
use super::sections::Names;
use super::site::Site;
use crate::io::context::Context;
use crate::io::names;
use crate::io::write::FLOATING_BASE;
use crate::joint::JointKind;
use crate::model::{Base, JointSpec, LinkSpec, ModelBuilder, inertia_flaw};
use crate::nested::IntoNested;
use crate::spatial::Transform;

/// The links and joints of a description.
pub(super) struct Assembly<'a> {
    bodies: &'a Bodies,
    builder: ModelBuilder,
    links: names::Names,
    joints: names::Names,
    /// Whether the only body of the world floats as the base.
    floats: bool,
    /// Whether bodies of the world that move freely are held, according to the options.
    is_held: bool,
    /// Joints that move a link without inertia on the way to their body, by name.
    pub(super) between: HashSet<String>,
    pub(super) names: Names,
}

/// Name of the link of a body, by its index.
pub(super) fn link_of(index: usize, body: &BodyEntry) -> &str {
    match index {
        0 => WORLD,
        _ => &body.name,
    }
}

/// Puts the links and joints of bodies into a builder.
pub(super) fn assemble<'a>(
    bodies: &'a Bodies,
    builder: ModelBuilder,
    wanted: Base,
    context: &mut Context<'_>,
) -> Assembly<'a> {
    let own = || bodies.entries.iter().skip(1);
    let links = own().map(|body| body.name.as_str()).chain([WORLD]);
    let joints = own().nested(|body| &body.joints);
    let alone = free_alone(&bodies.entries);
    let mut assembly = Assembly {
        floats: match (wanted, alone) {
            (Base::Auto, Some(free)) => !has_name(free) && !free.is_passive(),
            (Base::Floating, alone) => alone.is_some(),
            _ => false,
        },
        is_held: wanted == Base::Fixed && alone.is_some(),
        builder,
        links: names::Names::of(links),
        joints: names::Names::of(joints.map(|joint| joint.name.as_str())),
        between: HashSet::new(),
        names: Names::of(bodies),
        bodies,
    };
    if assembly.floats {
        assembly.note_world(context);
    } else {
        assembly.link(0, context);
    }
    for index in 1..bodies.entries.len() {
        assembly.link(index, context);
        assembly.motion(index);
    }
    for body in &bodies.entries {
        assembly.sites(body, context);
    }
    assembly
}

/// The free joint of the only body of the world, if there is one.
fn free_alone(entries: &[BodyEntry]) -> Option<&JointEntry> {
    let mut on_world = entries.iter().skip(1).filter(|body| body.parent == 0);
    match (
        on_world.next().map(|body| &body.joints[..]),
        on_world.next(),
    ) {
        (Some([only]), None) if only.kind == Kind::Free => Some(only),
        _ => None,
    }
}

/// Whether the file has a name for a joint that must be found by it: not the one that files of this library have for floating bases.
fn has_name(joint: &JointEntry) -> bool {
    joint.place.name == joint.name && joint.name != FLOATING_BASE
}

impl Assembly<'_> {
    /// The builder with all links and joints, and the base that it has.
    pub(super) fn finish(&self) -> (ModelBuilder, Base) {
        let base = if self.floats {
            Base::Floating
        } else {
            Base::Fixed
        };
        (self.builder.clone(), base)
    }

    /// Whether the first body of the world floats as the base.
    pub(super) fn floats(&self) -> bool {
        self.floats
    }

    /// A robot with a floating base has nothing fixed to the world.
    fn note_world(&self, context: &mut Context<'_>) {
        let world = &self.bodies.entries[0];
        let has_shapes = !world.visuals.is_empty() || !world.collisions.is_empty();
        if has_shapes || !self.bodies.scenery.is_empty() {
            let reason =
                "shapes of the world: the only body floats, so that the model has no link for them";
            context.ignore(&world.place, reason);
        }
        for free in self.bodies.entries[1]
            .joints
            .iter()
            .filter(|own| own.is_passive())
        {
            let reason = "damping, friction and rotor inertia of a floating base: set them on the model, or let its joint have a name";
            context.ignore(&free.place, reason);
        }
    }

    fn name(&self, index: usize) -> &str {
        link_of(index, &self.bodies.entries[index])
    }

    /// Adds the link of a body; one whose weight is balanced in part is two.
    fn link(&mut self, index: usize, context: &mut Context<'_>) {
        let body = &self.bodies.entries[index];
        let name = self.name(index).to_owned();
        if let Some(flaw) = inertia_flaw(&body.inertia) {
            context.warn(&body.place, flaw.to_string());
        }
        let balanced = body.gravcomp;
        let mut spec = LinkSpec::new(&name).with_inertia(body.inertia);
        if balanced == 1.0 {
            spec = spec.without_gravity();
        } else if balanced > 0.0 && balanced < 1.0 {
            spec = spec.with_inertia(body.inertia.scaled(1.0 - balanced));
            self.balance(&name, body);
        } else if balanced != 0.0 {
            let reason = format!("gravcomp {balanced} is not from 0 to 1");
            context.ignore(&body.place, reason);
        }
        for shape in &body.visuals {
            spec = spec.with_visual(shape.clone());
        }
        for shape in &body.collisions {
            spec = spec.with_collision(shape.clone());
        }
        let at = body.place.position.clone();
        self.builder.set_position(false, &name, at);
        self.builder.add_link(spec);
    }

    /// Adds the part of a body that gravity does not act on.
    fn balance(&mut self, name: &str, body: &BodyEntry) {
        let part = self.links.fresh(format!("{name}::balanced"));
        let inertia = body.inertia.scaled(body.gravcomp);
        let spec = LinkSpec::new(&part).with_inertia(inertia);
        self.builder.add_link(spec.without_gravity());
        self.fix(name, &part, Transform::identity());
    }

    /// Fixes a link to another one.
    fn fix(&mut self, from: &str, to: &str, placement: Transform<f64>) {
        let name = self.joints.fresh(format!("{to}::fixed"));
        let spec = JointSpec::new(name, JointKind::Fixed, from, to);
        self.builder.add_joint(spec.with_placement(placement));
    }

    /// Adds the joints between a body and its parent.
    fn motion(&mut self, index: usize) {
        let body = &self.bodies.entries[index];
        let (from, to) = (self.name(body.parent).to_owned(), body.name.clone());
        match &body.joints[..] {
            [free] if free.kind == Kind::Free => self.free(free, from, to, body.X_PB),
            joints => self.chain(joints, from, &to, body.X_PB),
        }
    }

    fn free(&mut self, joint: &JointEntry, from: String, to: String, X_WB: Transform<f64>) {
        if self.is_held {
            self.fix(&from, &to, X_WB);
        } else if !self.floats {
            let spec = JointSpec::new(&joint.name, JointKind::Floating, from, to);
            self.add(joint, spec);
        }
    }

    fn chain(&mut self, joints: &[JointEntry], from: String, to: &str, X_PB: Transform<f64>) {
        let (mut at, mut placement) = (from, X_PB);
        for (i, joint) in joints.iter().enumerate() {
            let reaches = i + 1 == joints.len() && joint.anchor == Vector3::zeros();
            let next = match reaches {
                true => to.to_owned(),
                false => self.between(joint),
            };
            let T = Transform::from_translation(joint.anchor);
            let X_PJ = placement * T * displaced(joint, -joint.reference);
            let kind = match (joint.kind, joint.axis.limits.lower) {
                (Kind::Slide, _) => JointKind::Prismatic,
                (Kind::Ball | Kind::Free, _) => JointKind::Spherical,
                (Kind::Hinge, Some(_)) => JointKind::Revolute,
                (Kind::Hinge, None) => JointKind::Continuous,
            };
            let spec = JointSpec::new(&joint.name, kind, at, &next);
            self.add(joint, spec.with_placement(X_PJ));
            (at, placement) = (next, T.inverse());
        }
        if at != to {
            self.fix(&at, to, placement);
        }
    }

    /// Adds a joint with what acts along it.
    fn add(&mut self, joint: &JointEntry, spec: JointSpec) {
        let at = joint.place.position.clone();
        self.builder.set_position(true, &joint.name, at);
        self.builder.add_joint(spec.along(joint.axis.clone()));
    }

    /// Adds a link without inertia, called like the joint that moves it.
    fn between(&mut self, joint: &JointEntry) -> String {
        let name = self.links.fresh(format!("{}::link", joint.name));
        self.builder.add_link(LinkSpec::new(&name));
        self.between.insert(joint.name.clone());
        name
    }

    /// Adds the sites of a body as frames.
    fn sites(&mut self, body: &BodyEntry, context: &mut Context<'_>) {
        let on_world = std::ptr::eq(body, &self.bodies.entries[0]);
        let link = if on_world { WORLD } else { &body.name };
        for Site {
            name,
            placement,
            place,
        } in &body.sites
        {
            if on_world && self.floats {
                let reason =
                    "the only body floats, so that the model has no link for sites of the world";
                context.ignore(place, reason);
                continue;
            }
            let frame = match self.links.take_new(name) {
                true => name.clone(),
                false => self.links.fresh(format!("{name}::site")),
            };
            if frame != *name {
                let reason = format!(
                    "a body or another site has that name: the frame is called \"{frame}\""
                );
                context.warn(place, reason);
            }
            self.builder
                .set_position(false, &frame, place.position.clone());
            self.builder.add_frame(&frame, link, *placement);
            self.names.sites.entry(name.clone()).or_insert(frame);
        }
    }
}

/// The motion of a joint at a coordinate.
fn displaced(joint: &JointEntry, by: f64) -> Transform<f64> {
    let axis = joint.axis.axis;
    match joint.kind {
        Kind::Hinge if by != 0.0 => Transform::new(about(&axis, by), Vector3::zeros()),
        Kind::Slide => Transform::from_translation(axis * by),
        _ => Transform::identity(),
    }
}
