//! Universal joints as what URDF has: two revolute joints with a link without inertia between.

use super::Names;
use crate::joint::JointKind;
use crate::model::{JointSpec, LinkSpec, ModelBuilder};

/// The description with each universal joint `NAME` as two joints `NAME::axis` and `NAME::axis2`; continuous where they have no limits.
pub(super) fn split(builder: &ModelBuilder) -> ModelBuilder {
    let frames = builder.frames().map(|(name, _, _)| name);
    let mut links = Names::of(builder.links().iter().map(LinkSpec::name).chain(frames));
    let mut names = Names::of(builder.joints().iter().map(JointSpec::name));
    let mut out = builder.clone();
    let mut joints = Vec::with_capacity(builder.joints().len());
    for joint in builder.joints() {
        match halves(joint, &mut names) {
            None => joints.push(joint.clone()),
            Some([first, second]) => {
                let cross = links.fresh(first.name());
                out.add_link(LinkSpec::new(&cross));
                joints.extend([first.with_child(&cross), second.with_parent(&cross)]);
            }
        }
    }
    out.set_joints(joints);
    out
}

/// The two joints; their link between is still to be named.
fn halves(joint: &JointSpec, names: &mut Names) -> Option<[JointSpec; 2]> {
    let second = joint.second_axis()?;
    let kind = |limits: &crate::model::Limits| match (limits.lower, limits.upper) {
        (None, None) => JointKind::Continuous,
        _ => JointKind::Revolute,
    };
    let [name, name2] =
        ["axis", "axis2"].map(|axis| names.fresh(format!("{}::{axis}", joint.name())));
    let spring = joint.spring();
    let first = JointSpec::new(name, kind(joint.limits()), joint.parent(), "")
        .with_placement(*joint.placement())
        .with_axis((*joint.axis()).into())
        .with_limits(*joint.limits())
        .with_damping(joint.damping())
        .with_friction(joint.friction())
        .with_armature(joint.armature())
        .with_spring(spring.stiffness, spring.rest);
    let second = JointSpec::new(name2, kind(&second.limits), "", joint.child())
        .with_axis(second.axis.into())
        .with_limits(second.limits)
        .with_damping(second.damping)
        .with_friction(second.friction)
        .with_armature(second.armature)
        .with_spring(second.spring.stiffness, second.spring.rest);
    Some([first, second])
}
