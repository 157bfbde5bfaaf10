//! A member of a world: its parts with their names in the world, and its joint.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use crate::error::{LoadError, UnknownName};
use crate::joint::JointKind;
use crate::model::checks::check_pose;
use crate::model::graph::WORLD;
use crate::model::operations::ATTACHMENT;
use crate::model::{Base, JointSpec, LinkSpec, Model, ModelBuilder};
use crate::spatial::Transform;

/// Name, after the prefix, of the joint of a floating robot.
pub(crate) const BASE_JOINT: &str = "floating_base";

/// Place of a member: on the world, or fixed to a frame of another one.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Stand {
    InWorld,
    /// Name of the frame.
    On(String),
}

/// Parts of a member, with their names in the world, and the joint that holds their root. Its parent may be a frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Member {
    pub(super) parts: ModelBuilder,
    pub(super) mount: JointSpec,
}

impl Member {
    /// A robot whose names get a prefix; it floats if its model floats and it is not mounted.
    pub(super) fn robot(
        model: &Model,
        prefix: &str,
        stand: Stand,
        placement: &Transform<f64>,
    ) -> Self {
        let mut parts = model.to_builder().with_prefix(prefix);
        ModelBuilder::new("").agree_on_mimicry(&mut parts);
        let root = format!("{prefix}{}", model.link_names()[0]);
        let floating = format!("{prefix}{BASE_JOINT}");
        let floats = stand == Stand::InWorld && model.has_floating_base();
        own_base(&mut parts, floats.then_some(&floating));
        // A link `world` above a floating robot is fixed, and links fixed to it float.
        let is_apart = floats && model.link_names()[0] == WORLD;
        if is_apart {
            float_below(&mut parts, &root, &floating);
        }
        let mount = match floats && !is_apart {
            true => free(&floating, &root),
            false => JointSpec::new(
                format!("{prefix}{ATTACHMENT}"),
                JointKind::Fixed,
                WORLD,
                root,
            ),
        };
        Self {
            parts,
            mount: mount.with_placement(*placement),
        }
        .on(stand)
    }

    /// A single link that floats or is fixed; the joint has its name.
    pub(super) fn link(
        link: LinkSpec,
        kind: JointKind,
        stand: Stand,
        placement: &Transform<f64>,
    ) -> Self {
        let name = link.name.clone();
        let parts = alone(link);
        let mount = match kind {
            JointKind::Floating => free(&name, &name),
            _ => JointSpec::new(&name, kind, WORLD, &name),
        };
        Self {
            parts,
            mount: mount.with_placement(*placement),
        }
        .on(stand)
    }

    fn on(mut self, stand: Stand) -> Self {
        if let Stand::On(frame) = stand {
            self.mount = self.mount.with_parent(frame);
        }
        self
    }

    /// Checks the pose.
    pub(super) fn check(&self, name: &str) -> Result<(), LoadError> {
        check_pose(&self.parts, "member", name, &self.mount.placement)
    }

    /// Checks the parameters of a single link.
    pub(super) fn check_link(link: LinkSpec) -> Result<(), LoadError> {
        alone(link).build().map(drop)
    }

    /// The joint that holds the member, on the link that carries its frame.
    pub(super) fn mount_on(&self, parts: &ModelBuilder) -> Result<JointSpec, UnknownName> {
        if self.mount.parent == WORLD {
            return Ok(self.mount.clone());
        }
        let (link, X_LF) = parts.find_frame(&self.mount.parent)?;
        let mount = self.mount.clone().with_parent(link);
        Ok(mount.with_placement(X_LF * self.mount.placement))
    }
}

/// A single fixed link.
fn alone(link: LinkSpec) -> ModelBuilder {
    let mut parts = ModelBuilder::new(&link.name).with_base(Base::Fixed);
    parts.add_link(link);
    parts
}

/// A floating joint without input.
fn free(name: &str, child: &str) -> JointSpec {
    JointSpec::new(name, JointKind::Floating, WORLD, child).passive()
}

/// Gives damping and armature of a floating base to the joint that takes its place, or drops them with the base.
fn own_base(parts: &mut ModelBuilder, joint: Option<&String>) {
    parts
        .overrides
        .retain(|edit| edit.joint.is_some() || joint.is_some());
    for edit in &mut parts.overrides {
        edit.joint = edit.joint.take().or_else(|| joint.cloned());
    }
}

/// Inserts a floating frame between a fixed link and the links fixed to it.
fn float_below(parts: &mut ModelBuilder, standing: &str, floating: &str) {
    for joint in &mut parts.joints {
        if joint.parent == standing {
            joint.parent = floating.to_owned();
        }
    }
    parts.add_link(LinkSpec::new(floating));
    parts.add_joint(free(floating, floating).with_parent(standing));
}
