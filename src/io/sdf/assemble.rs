//! From the tree to the parts of a model.
//!
//! An SDF joint has a frame J of its own; the model's joints have the child link at J when they are at zero. Where the child
//! stands elsewhere, a link without inertia in J, called like the joint, is put between, and the child is fixed to it:
//!
//! `X_PC(q) = X_PJ X(q) X_JC`; towards the root, from the child to the parent, `X_CP(q) = X_CJ X(q)⁻¹ X_JP`,
//! where `X(q)⁻¹` is the same motion about the opposite axis. A ball turns by the inverse rotation then.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::HashSet;

use nalgebra::Matrix3;

use super::frames::Placements;
use super::scene::{Follow, FrameKind, Inertial, MassEntry, Motion, Place, Scene, Shape};
use super::tree::{self, Direction, Edge, Tree, ends, is_held, is_static};
use crate::error::LoadError;
use crate::io::ModelOptions;
use crate::io::context::Context;
use crate::io::report::missing_leader;
use crate::joint::JointKind;
use crate::model::{
    Base, Collision, JointSpec, LinkSpec, Mass, Mimic, Mimicry, ModelBuilder, Visual, inertia_flaw,
};
use crate::spatial::{Inertia, Transform};

/// How far a child link may be from its joint's frame and still be taken to stand on it: the rounding of a chain of poses.
const SAME_FRAME: f64 = 1e-12;

/// Name of the link that is the world itself.
const WORLD: &str = "world";

/// Makes the parts of a model.
pub(super) struct Assembly<'a, 'c> {
    scene: &'a Scene,
    placements: &'a Placements,
    context: &'a mut Context<'c>,
    builder: ModelBuilder,
    /// Names of links and frames.
    names: HashSet<String>,
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
    let name = &scene.frames[scene.models[robot].frame].name;
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
    };
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
                    self.context.warnings.push(place.note(reason));
                }
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
            self.context.ignored.push(place.note(reason));
        }
    }

    /// Fixes a link to the world where it stands.
    fn hold(&mut self, link: usize) {
        let (name, X_WL) = (self.link_name(Some(link)), self.X_W(Some(link)));
        let joint = format!("{WORLD}::{name}");
        let spec = JointSpec::new(joint, JointKind::Fixed, WORLD, name);
        self.builder.add_joint(spec.with_placement(X_WL));
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

    fn link(&mut self, index: usize) -> Result<(), LoadError> {
        let link = &self.scene.links[index];
        let place = &self.scene.frames[link.frame].place;
        let inertial = &link.inertial;
        let inertia = self.inertia(index)?;
        if let Some(flaw) = inertia_flaw(&inertia) {
            self.context
                .warnings
                .push(inertial.place.note(flaw.to_string()));
        }
        let mut spec = LinkSpec::new(self.link_name(Some(index))).with_inertia(inertia);
        for Shape {
            name,
            pose,
            geometry,
            color,
            ..
        } in &link.visuals
        {
            spec = spec.with_visual(Visual {
                name: name.clone(),
                placement: self.in_link(index, pose, place)?,
                geometry: geometry.clone(),
                color: *color,
            });
        }
        for Shape {
            name,
            pose,
            geometry,
            ..
        } in &link.collisions
        {
            spec = spec.with_collision(Collision {
                name: name.clone(),
                placement: self.in_link(index, pose, place)?,
                geometry: geometry.clone(),
            });
        }
        self.builder.add_link(spec);
        Ok(())
    }

    /// The inertia of a link in its own frame.
    fn inertia(&mut self, index: usize) -> Result<Inertia<f64>, LoadError> {
        let link = &self.scene.links[index];
        let Inertial { mass, place } = &link.inertial;
        let default = match mass {
            MassEntry::Given { pose, inertia } => {
                return Ok(self.in_link(index, pose, place)?.inertia(inertia));
            }
            MassEntry::Solid { density } => *density,
        };
        let mut sum = Inertia::zero();
        for shape in &link.collisions {
            let density = Mass::Density(shape.density.unwrap_or(default));
            let X_LS = self.in_link(index, &shape.pose, place)?;
            match shape.geometry.inertia(density) {
                Some(inertia) => sum = sum + X_LS.inertia(&inertia),
                None => {
                    let reason = "auto: meshes are not read and add no mass";
                    self.context.warnings.push(place.note(reason));
                }
            }
        }
        if sum == Inertia::zero() {
            let reason = "auto: the link has no solid collision, so no mass";
            self.context.warnings.push(place.note(reason));
        }
        Ok(sum)
    }

    fn in_link(
        &self,
        link: usize,
        pose: &super::scene::Pose,
        place: &Place,
    ) -> Result<Transform<f64>, LoadError> {
        self.placements.in_link(self.scene, link, pose, place)
    }

    /// Adds a joint and what stands between it and the link that it carries.
    fn joint(&mut self, edge: Edge) -> Result<(), LoadError> {
        let joint = &self.scene.joints[edge.joint];
        let frame = &self.scene.frames[joint.frame];
        let ends = ends(self.scene, self.placements, edge.joint)?;
        let X_WJ = self.placements.X_WF[joint.frame];
        // From here on A is the end at the root, B the other one.
        let (a, b) = match edge.direction {
            Direction::Forward => (ends.parent, ends.child),
            Direction::Backward => (ends.child, ends.parent),
        };
        let X_AJ = self.X_W(a).inverse() * X_WJ;
        let X_JB = X_WJ.inverse() * self.X_W(b);
        let (from, to) = (self.link_name(a), self.link_name(b));
        if joint.motions.is_empty() {
            let spec = JointSpec::new(&frame.name, JointKind::Fixed, from, to);
            self.builder.add_joint(spec.with_placement(X_AJ * X_JB));
            return Ok(());
        }
        let at = self.motions(edge, from, X_AJ, is_identity(&X_JB).then_some(&to))?;
        if at != to {
            let name = format!("{}::fixed", frame.name);
            let spec = JointSpec::new(name, JointKind::Fixed, at, to);
            self.builder.add_joint(spec.with_placement(X_JB));
        }
        Ok(())
    }

    /// Adds the moving joints from a link on, the first placed in it, the last one to a link `to` if that stands there;
    /// returns the link at their end.
    fn motions(
        &mut self,
        edge: Edge,
        from: String,
        X_AJ: Transform<f64>,
        to: Option<&String>,
    ) -> Result<String, LoadError> {
        let mut order: Vec<usize> = (0..self.scene.joints[edge.joint].motions.len()).collect();
        if edge.direction == Direction::Backward {
            order.reverse();
        }
        let (mut at, mut placement) = (from, X_AJ);
        for (k, &i) in order.iter().enumerate() {
            let is_last = k + 1 == order.len();
            let next = match to {
                Some(to) if is_last => to.clone(),
                _ => self.between(&motion_name(self.scene, edge.joint, i)),
            };
            let spec = self.motion(edge, i, &at, &next)?;
            self.builder.add_joint(spec.with_placement(placement));
            (at, placement) = (next, Transform::identity());
        }
        Ok(at)
    }

    /// Adds a link without inertia, called like the joint if that is free.
    fn between(&mut self, joint: &str) -> String {
        let mut name = joint.to_owned();
        while !self.names.insert(name.clone()) {
            name += "::joint";
        }
        self.builder.add_link(LinkSpec::new(&name));
        name
    }

    fn motion(
        &mut self,
        edge: Edge,
        i: usize,
        from: &str,
        to: &str,
    ) -> Result<JointSpec, LoadError> {
        let joint = &self.scene.joints[edge.joint];
        let motion = &joint.motions[i];
        let mut axis = self.axis(joint.frame, motion)?;
        if edge.direction == Direction::Backward {
            axis = axis.map(|x| -x);
            if motion.kind == JointKind::Spherical {
                let reason = "the tree leads from the child to the parent: the coordinates are those of the inverse rotation";
                let place = &self.scene.frames[joint.frame].place;
                self.context.warnings.push(place.note(reason));
            }
        }
        let name = motion_name(self.scene, edge.joint, i);
        let spec = JointSpec::new(name, motion.kind, from, to)
            .with_axis(axis)
            .with_limits(motion.limits)
            .with_damping(motion.damping)
            .with_friction(motion.friction)
            .with_spring(motion.spring.stiffness, motion.spring.rest);
        let Some(follow) = &motion.mimic else {
            return Ok(spec);
        };
        match self.mimic(joint.frame, follow) {
            Ok(mimic) => Ok(spec.with_mimic(mimic)),
            Err(_) if self.builder.mimicry() == Mimicry::Independent => {
                let place = &self.scene.frames[joint.frame].place;
                let note = place.note(missing_leader(&follow.leader));
                self.context.warnings.push(note);
                Ok(spec)
            }
            Err(error) => Err(error),
        }
    }

    /// The axis in the frame of the joint.
    fn axis(&self, frame: usize, motion: &Motion) -> Result<[f64; 3], LoadError> {
        let Some(name) = &motion.expressed_in else {
            return Ok(motion.axis);
        };
        let entry = &self.scene.frames[frame];
        let expressed_in = self.scene.resolve(entry.scope, name, &entry.place)?;
        let R_W = |frame: usize| self.placements.X_WF[frame].rotation;
        let R_JF = R_W(frame).transpose() * R_W(expressed_in);
        Ok((R_JF * nalgebra::Vector3::from(motion.axis)).into())
    }

    /// q = m (`q_leader` − reference) + offset  is  m · `q_leader` + (offset − m · reference).
    fn mimic(&self, frame: usize, follow: &Follow) -> Result<Mimic, LoadError> {
        let entry = &self.scene.frames[frame];
        let leader = self
            .scene
            .resolve(entry.scope, &follow.leader, &entry.place)?;
        let leader = match self.scene.frames[leader].kind {
            FrameKind::Joint(joint) => motion_name(self.scene, joint, follow.axis),
            _ => return Err(entry.place.unknown(&follow.leader)),
        };
        Ok(Mimic {
            leader,
            multiplier: follow.multiplier,
            offset: follow.offset - follow.multiplier * follow.reference,
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
                self.builder
                    .add_frame(&frame.name, self.link_name(link), X_LF);
            }
        }
    }
}

/// The name of one motion of a joint: that of the joint, if it is the only one.
fn motion_name(scene: &Scene, joint: usize, motion: usize) -> String {
    let entry = &scene.joints[joint];
    let name = &scene.frames[entry.frame].name;
    match (entry.motions.len(), motion) {
        (0 | 1, 0) => name.clone(),
        (_, 0) => format!("{name}::axis"),
        _ => format!("{name}::axis2"),
    }
}

fn is_identity(X: &Transform<f64>) -> bool {
    let turn = (X.rotation - Matrix3::identity()).amax();
    turn.max(X.translation.amax()) <= SAME_FRAME
}
