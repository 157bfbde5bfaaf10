//! Universal joints as what URDF has: two revolute joints with a link without inertia between.

use crate::io::names::Names;
use crate::joint::JointKind;
use crate::model::{JointSpec, LinkSpec, ModelBuilder, SecondAxis};

/// The description with each universal joint `NAME` as two joints `NAME::axis` and `NAME::axis2`; continuous where they have no limits.
pub(super) fn split(builder: &ModelBuilder) -> ModelBuilder {
    let frames = builder.frames.iter().map(|frame| frame.name.as_str());
    let mut links = Names::of(
        builder
            .links
            .iter()
            .map(|link| link.name.as_str())
            .chain(frames),
    );
    let mut names = Names::of(builder.joints.iter().map(|joint| joint.name.as_str()));
    let mut out = builder.clone();
    let mut joints = Vec::with_capacity(builder.joints.len());
    for joint in &builder.joints {
        match halves(joint, &mut names) {
            None => joints.push(joint.clone()),
            Some([first, second]) => {
                let cross = links.fresh(&first.name);
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
    let second = joint.second.as_ref()?;
    let [name, name2] =
        ["axis", "axis2"].map(|axis| names.fresh(format!("{}::{axis}", &joint.name)));
    let half = |name: String, parent: &str, child: &str, axis: SecondAxis| {
        let kind = match (axis.limits.lower, axis.limits.upper) {
            (None, None) => JointKind::Continuous,
            _ => JointKind::Revolute,
        };
        JointSpec::new(name, kind, parent, child).along(axis)
    };
    let first = half(name, &joint.parent, "", joint.first_axis());
    let second = half(name2, "", &joint.child, second.clone());
    Some([first.with_placement(joint.placement), second])
}
