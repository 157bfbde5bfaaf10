//! Forces of a recording as arrows.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::stage::{Poses, Stage, StagePiece};
use super::surface::arrow;
use crate::nested::IntoNested;
use crate::spatial::Transform;
use crate::view::recording::Recording;
use crate::view::skeleton::turned_to;

/// Colour of forces, that of the HTML viewer.
const COLOR: [f64; 4] = [0.90, 0.22, 0.36, 1.0];

/// Length of the largest force of all times, and thickness of arrows, relative to the half diagonal of what is in the picture.
const LONGEST: f64 = 0.5;
const THICKNESS: f64 = 0.016;

/// The forces that act at a time: those of the moment before, as they are held.
pub(super) fn arrows(
    stage: &Stage,
    recording: &Recording,
    poses: &Poses,
    time: f64,
) -> Vec<StagePiece> {
    let all = recording.robots.iter().nested(|track| &track.forces);
    let norms = all.nested(|force| &force.values).map(Vector3::norm);
    let largest = norms.filter(|norm| norm.is_finite()).fold(0.0, f64::max);
    let after = recording.times().partition_point(|&t| t <= time);
    let scale = LONGEST * stage.radius() / largest;
    let (thickness, moment) = (THICKNESS * stage.radius(), after.saturating_sub(1));
    let mut out = Vec::new();
    for (track, poses) in recording.robots.iter().zip(poses) {
        for force in &track.forces {
            let Some(value) = force.values.get(moment) else {
                continue;
            };
            let along = track.placement.rotation * value * scale;
            let length = along.norm();
            if !(length > 0.0 && length.is_finite()) {
                continue;
            }
            let frame = &track.model.frames()[force.frame.0];
            let X_WB = frame.body.map_or(track.placement, |body| poses[body.0]);
            let from = X_WB.point(&frame.placement.translation);
            let pose = Transform::new(turned_to(&along), from);
            out.push(StagePiece::still(pose, COLOR, arrow(length, thickness)));
        }
    }
    out
}
