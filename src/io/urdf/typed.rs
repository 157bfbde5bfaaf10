//! A robot that `urdf-rs` has read, or a program put together: what of it is not used, and what its zeros mean.

use urdf_rs::{Joint, JointLimit, Material, Robot};

use super::joint::{DOES_NOT_MOVE, NO_LIMIT, is_bounded, kind, unlimited};
use super::part::{Part, note_of_typed};
use super::reader::{DEFAULT_NAME, NAMELESS};
use crate::io::context::Context;
use crate::joint::JointKind;

/// A robot as the reader of texts would have filled it, with the remarks on it.
pub(super) fn completed(context: &mut Context<'_>, robot: &Robot) -> Robot {
    let mut completed = robot.clone();
    if robot.name.is_empty() {
        completed.name = DEFAULT_NAME.into();
        let note = note_of_typed(&completed, Part::Robot, NAMELESS.into());
        context.warnings.push(note);
    }
    for (j, joint) in completed.joints.iter_mut().enumerate() {
        complete_joint(context, robot, j, joint);
    }
    for (l, link) in completed.links.iter_mut().enumerate() {
        for (k, visual) in link.visual.iter_mut().enumerate() {
            if let Some(material) = &mut visual.material {
                complete_material(context, robot, Part::Material(l, k), material);
            }
        }
    }
    for material in &mut completed.materials {
        complete_material(context, robot, Part::Robot, material);
    }
    completed
}

fn complete_joint(context: &mut Context<'_>, robot: &Robot, j: usize, joint: &mut Joint) {
    let kind = kind(&joint.joint_type);
    // What a fixed joint has for limits is not looked at.
    if joint.limit == JointLimit::default() && kind != JointKind::Fixed {
        joint.limit = unlimited();
        if is_bounded(kind) {
            let note = note_of_typed(robot, Part::Joint(j), NO_LIMIT.into());
            context.warnings.push(note);
        }
    }
    if !kind.has_axis() {
        joint.axis = urdf_rs::Axis::default();
    }
    for (reason, part) in unused(joint, j, kind) {
        let note = note_of_typed(robot, part, reason.into());
        context.ignored.push(note);
    }
}

/// Reasons why no one reads parts of a joint, for those that it has.
fn unused(joint: &Joint, j: usize, kind: JointKind) -> Vec<(&'static str, Part)> {
    let limit = &joint.limit;
    let rates = [limit.acceleration, limit.deceleration, limit.jerk];
    let does_not_move = kind == JointKind::Fixed;
    let unused = [
        (
            joint.calibration.is_some(),
            "reference positions for calibration are not used",
            Part::Joint(j),
        ),
        (
            joint.safety_controller.is_some(),
            "safety controllers are not modelled",
            Part::Joint(j),
        ),
        (
            rates.iter().any(|x| x.is_finite()),
            "acceleration, deceleration and jerk are not limited",
            Part::Limit(j),
        ),
        (
            does_not_move && joint.dynamics.is_some(),
            DOES_NOT_MOVE,
            Part::Dynamics(j),
        ),
        (
            does_not_move && joint.mimic.is_some(),
            DOES_NOT_MOVE,
            Part::Mimic(j),
        ),
    ];
    let there = unused.into_iter().filter(|(is_there, ..)| *is_there);
    there.map(|(_, reason, part)| (reason, part)).collect()
}

/// A colour that is none costs the colour, not the robot.
fn complete_material(
    context: &mut Context<'_>,
    robot: &Robot,
    part: Part,
    material: &mut Material,
) {
    let is_color = |color: &urdf_rs::Color| color.rgba.iter().all(|x| x.is_finite());
    if material
        .color
        .as_ref()
        .is_some_and(|color| !is_color(color))
    {
        material.color = None;
        let reason = format!(
            "no colour: that of the material \"{}\" is not finite",
            material.name
        );
        let note = note_of_typed(robot, part, reason);
        context.warnings.push(note);
    }
    if material.texture.is_some() {
        let note = note_of_typed(robot, part, "textures are not shown".into());
        context.ignored.push(note);
    }
}
