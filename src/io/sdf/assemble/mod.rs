//! Assembles the parts of a model from the tree: the root in its place, every link, the joints from the root outwards, frames.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

mod joint;
mod link;

pub(super) use joint::motion_name;

use std::collections::HashSet;

use super::frames::Placements;
use super::scene::{FrameKind, Scene};
use super::tree::{self, Tree, is_held, is_static};
use crate::error::LoadError;
use crate::io::ModelOptions;
use crate::io::context::Context;
use crate::joint::JointKind;
use crate::model::{Base, JointSpec, LinkSpec, ModelBuilder};
use crate::spatial::Transform;

/// Name of the link that is the world itself.
const WORLD: &str = "world";

/// Name, in its model, of the joint on which a model of a world floats.
const FLOATING_BASE: &str = "floating_base";

/// Makes the parts of a model.
pub(super) struct Assembly<'a, 'c> {
    scene: &'a Scene,
    placements: &'a Placements,
    context: &'a mut Context<'c>,
    builder: ModelBuilder,
    /// Names of links and frames.
    names: HashSet<String>,
    /// Joints that others follow.
    leaders: HashSet<usize>,
}

/// Makes the model's parts from a scene whose robot is a model of the given index.
pub(super) fn assemble(
    scene: &Scene,
    robot: usize,
    options: &ModelOptions,
    context: &mut Context<'_>,
) -> Result<ModelBuilder, LoadError> {
    let placements = &Placements::new(scene, robot)?;
    let tree = tree::build(scene, placements, robot)?;
    let own_name = &scene.frames[scene.models[robot].frame].name;
    let name = scene.title.as_ref().unwrap_or(own_name);
    let builder = ModelBuilder::new(name)
        .with_source(context.file)
        .with_mimicry(options.mimicry);
    let frames = scene
        .frames
        .iter()
        .filter(|frame| matches!(frame.kind, FrameKind::Link(_) | FrameKind::Free(_)));
    let names = frames.map(|frame| frame.name.clone()).collect();
    let mut assembly = Assembly {
        scene,
        placements,
        context,
        builder,
        names,
        leaders: HashSet::new(),
    };
    assembly.find_leaders();
    assembly.base(&tree, options.base, robot);
    for link in 0..scene.links.len() {
        assembly.link(link)?;
    }
    for &edge in &tree.edges {
        assembly.joint(edge)?;
    }
    assembly.frames(robot);
    Ok(assembly.builder)
}

impl Assembly<'_, '_> {
    /// Puts the root in its place.
    fn base(&mut self, tree: &Tree, base: Base, robot: usize) {
        let place = &self.scene.frames[self.scene.models[robot].frame].place;
        match tree.root {
            None => {
                self.builder.add_link(LinkSpec::new(WORLD));
            }
            Some(root) if base == Base::Fixed => {
                self.builder.add_link(LinkSpec::new(WORLD));
                self.hold(root);
            }
            Some(root) => {
                if self.placements.X_WF[self.scene.links[root].frame] != Transform::identity() {
                    let reason =
                        "the initial pose of a floating robot is not kept: set it in the state";
                    self.context.warn(place, reason);
                }
            }
        }
        let mut taken = HashSet::new();
        for &link in &tree.floating {
            match base {
                Base::Fixed => self.hold(link),
                Base::Auto | Base::Floating => self.float(link, &mut taken),
            }
        }
        for link in 0..self.scene.links.len() {
            if is_static(self.scene, link) {
                self.hold(link);
            }
        }
        for joint in (0..self.scene.joints.len()).filter(|&joint| is_held(self.scene, joint)) {
            let place = &self.scene.frames[self.scene.joints[joint].frame].place;
            let reason = "a static model does not move: all its links are fixed to the world";
            self.context.ignore(place, reason);
        }
    }

    /// Fixes a link to the world where it stands.
    fn hold(&mut self, link: usize) {
        let (name, X_WL) = (self.link_name(Some(link)), self.X_W(Some(link)));
        let joint = format!("{WORLD}::{name}");
        let spec = JointSpec::new(joint, JointKind::Fixed, WORLD, name);
        self.builder.add_joint(spec.with_placement(X_WL));
    }

    /// Lets a link float, at first where it stands, by a joint that is called after its model, or after itself where another link of the model
    /// floats.
    fn float(&mut self, link: usize, taken: &mut HashSet<String>) {
        let name = self.link_name(Some(link));
        let model = name.split_once("::").map_or(&*name, |(model, _)| model);
        let mut joint = format!("{model}::{FLOATING_BASE}");
        if !taken.insert(joint.clone()) {
            joint = format!("{name}::{FLOATING_BASE}");
        }
        let spec = JointSpec::new(joint, JointKind::Floating, WORLD, &name).passive();
        self.builder
            .add_joint(spec.with_placement(self.X_W(Some(link))));
    }

    fn link_name(&self, link: Option<usize>) -> String {
        link.map_or_else(
            || WORLD.to_owned(),
            |link| self.scene.frames[self.scene.links[link].frame].name.clone(),
        )
    }

    fn X_W(&self, link: Option<usize>) -> Transform<f64> {
        link.map_or_else(Transform::identity, |link| {
            self.placements.X_WF[self.scene.links[link].frame]
        })
    }

    /// Adds the frames that the file names.
    fn frames(&mut self, robot: usize) {
        let scene = self.scene;
        for (i, frame) in scene
            .frames
            .iter()
            .enumerate()
            .skip(scene.models[robot].frame)
        {
            if matches!(frame.kind, FrameKind::Free(_)) {
                let link = self.placements.link[i];
                let X_LF = self.X_W(link).inverse() * self.placements.X_WF[i];
                let at = frame.place.position.clone();
                self.builder.set_position(false, &frame.name, at);
                self.builder
                    .add_frame(&frame.name, self.link_name(link), X_LF);
            }
        }
    }
}
