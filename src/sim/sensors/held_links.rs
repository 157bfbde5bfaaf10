//! The links that a force–torque sensor holds: its own, and those that are fixed to it.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::{HashMap, HashSet};

use nalgebra::Vector3;

use super::exterior::each_exterior_force;
use super::moment::Moment;
use crate::joint::JointKind;
use crate::model::{BodyId, FrameId, Model, ModelBuilder};
use crate::numbers::Numbers;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{cross, lift_vector, rotate_back, scale};
use crate::spatial::{Force, Inertia};

/// Links that are fixed to one another, with what they are made of and what they carry.
#[derive(Clone, Debug)]
pub(super) struct HeldLinks {
    /// The body that they are part of; `None` is the world.
    body: Option<BodyId>,
    /// Whether they are all of it.
    are_body: bool,
    /// Their frames.
    frames: Vec<FrameId>,
    /// Inertia of all of them, and of those that gravity does not act on, in the body.
    inertia: Inertia<f64>,
    weightless: Inertia<f64>,
    /// The bodies that they carry.
    children: Vec<BodyId>,
}

impl HeldLinks {
    /// Those that a link carries on its own body.
    pub(super) fn new(model: &Model, link: FrameId) -> Self {
        let builder = model.to_builder();
        let names = carried_links(&builder, &model.frames()[link.0].name);
        let has = |name: &str| names.contains(name);
        let body = model.frames()[link.0].body;
        let mut on_body = model
            .links()
            .iter()
            .map(|link| &model.frames()[link.frame.0]);
        let are_body =
            body.is_some() && on_body.all(|frame| frame.body != body || has(&frame.name));
        let [inertia, weightless] = inertias(model, &builder, &has);
        Self {
            body,
            are_body,
            frames: frames(model, &builder, &has),
            inertia,
            weightless,
            children: children(model, &builder, body, &has),
        }
    }

    /// The bodies whose joints' forces their own follows from.
    pub(super) fn loaded(&self) -> Vec<BodyId> {
        match self.body.filter(|_| self.are_body) {
            Some(body) => vec![body],
            None => self.children.clone(),
        }
    }

    /// Whether their force depends on the pose of their body in the world.
    pub(super) fn need_pose(&self) -> bool {
        !self.are_body && self.weightless != Inertia::zero()
    }

    /// The force that holds them, on the body and in it.
    pub(super) fn force<P: Scalar, T: Over<P>>(&self, at: &Moment<'_, P, T>) -> Force<T> {
        let (forces, poses) = (at.forces, at.motions.X_PB);
        if let (Some(body), true) = (self.body, self.are_body) {
            return forces[body.0];
        }
        let mut F = self.inertial_force(at);
        for child in &self.children {
            F += poses[child.0].force(&forces[child.0]);
        }
        each_exterior_force(at.at, at.found, at.kinematics, |frame, body, exterior| {
            if body == self.body && frame.is_some_and(|frame| self.frames.contains(&frame)) {
                F = F - exterior;
            }
        });
        F
    }

    /// The force that their own inertia and weight need.
    fn inertial_force<P: Scalar, T: Over<P>>(&self, at: &Moment<'_, P, T>) -> Force<T> {
        if self.inertia == Inertia::zero() {
            return Force::zero();
        }
        let (V, A) = (at.velocity(self.body), at.acceleration_of(self.body));
        let lifted = |inertia: &Inertia<f64>| inertia.map_numbers(&mut |x| T::constant(x));
        let F = lifted(&self.inertia).force::<T>(&V, &A);
        if !self.need_pose() {
            return F;
        }
        let gravity: Vector3<T> = lift_vector(at.at.model().gravity());
        let gravity = rotate_back(&at.kinematics.pose(self.body).rotation, &gravity);
        let weightless = lifted(&self.weightless);
        // Where gravity does not act, A has it all the same.
        F + Force::new(
            scale(&gravity, weightless.mass),
            cross(&weightless.first_moment, &gravity),
        )
    }
}

/// The link that carries a frame: itself if it is one.
pub(super) fn carrying_link(model: &Model, frame: FrameId) -> FrameId {
    if model.links().iter().any(|link| link.frame == frame) {
        return frame;
    }
    let own = &model.frames()[frame.0];
    let builder = model.to_builder();
    let added = builder.frames.iter().find(|frame| frame.name == own.name);
    let link = added.and_then(|frame| model.frame(&frame.link));
    // Frames of the library's own are on the body alone.
    let of_body = || own.body.map_or(frame, |body| model.body_frame(body));
    link.unwrap_or_else(of_body)
}

/// A link and those that are fixed to it, farther from the root.
fn carried_links(builder: &ModelBuilder, link: &str) -> HashSet<String> {
    let mut fixed: HashMap<&str, Vec<&str>> = HashMap::new();
    let joints = builder.joints.iter();
    for joint in joints.filter(|joint| joint.kind == JointKind::Fixed) {
        fixed.entry(&joint.parent).or_default().push(&joint.child);
    }
    let (mut open, mut out) = (vec![link], HashSet::new());
    while let Some(link) = open.pop() {
        if out.insert(link.to_owned()) {
            open.extend(fixed.get(link).into_iter().flatten());
        }
    }
    out
}

/// Their frames, and frames that were added to them.
fn frames(model: &Model, builder: &ModelBuilder, has: &impl Fn(&str) -> bool) -> Vec<FrameId> {
    let added: HashSet<&str> = builder
        .frames
        .iter()
        .filter_map(|frame| has(&frame.link).then_some(frame.name.as_str()))
        .collect();
    let all = model.frames().iter().enumerate();
    let own = all.filter(|(_, frame)| has(&frame.name) || added.contains(frame.name.as_str()));
    own.map(|(k, _)| FrameId(k)).collect()
}

/// Inertia of all of them, and of those that gravity does not act on, in their body.
fn inertias(
    model: &Model,
    builder: &ModelBuilder,
    has: &impl Fn(&str) -> bool,
) -> [Inertia<f64>; 2] {
    let floats: HashSet<&str> = builder
        .links
        .iter()
        .filter_map(|link| (!link.has_gravity).then_some(link.name.as_str()))
        .collect();
    let mut out = [Inertia::zero(), Inertia::zero()];
    for (link, inertia) in model.links().iter().zip(model.link_inertias()) {
        let frame = &model.frames()[link.frame.0];
        if has(&frame.name) {
            let in_body = frame.placement.inertia(&inertia);
            out[0] = out[0] + in_body;
            if floats.contains(frame.name.as_str()) {
                out[1] = out[1] + in_body;
            }
        }
    }
    out
}

/// The bodies whose joints they carry.
fn children(
    model: &Model,
    builder: &ModelBuilder,
    body: Option<BodyId>,
    has: &impl Fn(&str) -> bool,
) -> Vec<BodyId> {
    let parents: HashMap<&str, &str> = builder
        .joints
        .iter()
        .map(|joint| (joint.name.as_str(), joint.parent.as_str()))
        .collect();
    let joints = model.joints().iter();
    let carried = joints.filter(|joint| {
        let first = &model.bodies()[joint.bodies().start];
        let parent = parents.get(joint.name.as_str());
        first.parent == body && parent.is_some_and(|link| has(link))
    });
    carried.map(|joint| BodyId(joint.bodies().start)).collect()
}
