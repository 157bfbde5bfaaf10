//! Notes on the properties that a URDF has no place for.

use crate::io::xml::numbers;
use crate::model::{DEFAULT_GRAVITY, Geometry, JointSpec, LinkSpec, Mimicry, ModelBuilder};

/// Lists the properties that the file leaves out; `hidden` is a world link that is not the parent of the robot.
pub(super) fn notes(builder: &ModelBuilder, hidden: Option<&str>) -> Vec<String> {
    let mut notes = Vec::new();
    let gravity = builder.gravity.as_slice();
    if gravity != DEFAULT_GRAVITY {
        notes.push(format!("left out: gravity {}", numbers(gravity)));
    }
    if let Some(world) = hidden {
        notes.push(format!(
            "left out: link {world}, which the robot does not hang on"
        ));
    }
    if builder.has_override(None) {
        notes.push("left out: damping and armature of the floating base".into());
    }
    notes.extend(builder.links.iter().filter_map(of_link));
    for joint in &builder.joints {
        of_joint(builder, joint, &mut notes);
    }
    notes
}

/// The shapes of a link that the format does not have.
fn of_link(link: &LinkSpec) -> Option<String> {
    let visuals = link.visuals.iter().map(|own| &own.geometry);
    let all = visuals.chain(link.collisions.iter().map(|own| &own.geometry));
    let count = all
        .filter(|shape| matches!(shape, Geometry::Ellipsoid { .. }))
        .count();
    let name = &link.name;
    (count > 0).then(|| {
        format!(
            "left out: {count} ellipsoids of link {name}, a shape that the format does not have"
        )
    })
}

fn of_joint(builder: &ModelBuilder, joint: &JointSpec, notes: &mut Vec<String>) {
    let (name, armature, spring) = (&joint.name, joint.armature, &joint.spring);
    if let (Mimicry::Independent, Some(mimic)) = (builder.mimicry, joint.mimic.as_ref()) {
        let (leader, multiplier, offset) = (&mimic.leader, mimic.multiplier, mimic.offset);
        notes.push(format!(
            "left out: joint {name} moves independently of {leader}, which it was to mimic ({multiplier}, {offset})"
        ));
    }
    if joint.is_passive {
        notes.push(format!("left out: joint {name} takes no input"));
    }
    if armature != 0.0 {
        notes.push(format!("left out: armature {armature} of joint {name}"));
    }
    if spring.stiffness != 0.0 {
        let (stiffness, rest) = (spring.stiffness, spring.rest);
        notes.push(format!(
            "left out: spring {stiffness} with rest position {rest} of joint {name}"
        ));
    }
    if builder.has_override(Some(name)) {
        notes.push(format!(
            "left out: differences between the axes of joint {name}"
        ));
    }
}
