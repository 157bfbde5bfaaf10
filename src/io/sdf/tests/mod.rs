//! Tests of the whole reader.

mod errors;
mod files;
mod frames;
mod hostile;
mod joints;
mod report;
mod worlds;

use crate::tests::ROUNDING;
use nalgebra::Vector3;

use crate::error::LoadError;
use crate::io::{ImportNote, ImportReport, ModelOptions};
use crate::model::Model;
use crate::spatial::Transform;

const INERTIAL: &str = "<inertial><mass>1</mass><inertia><ixx>1</ixx><ixy>0</ixy><ixz>0</ixz><iyy>1</iyy><iyz>0</iyz><izz>1</izz></inertia></inertial>";

/// A quarter turn as a text.
const QUARTER: &str = "1.5707963267948966";

/// A model `r` of these parts in a version; `LINK:a` stands for a link `a` of 1 kg.
fn robot_of(version: &str, parts: &str) -> String {
    format!("<sdf version=\"{version}\"><model name=\"r\">{parts}</model></sdf>")
}

/// A model `r` of these parts in the newest version, as [`robot_of`] writes it.
fn robot(parts: &str) -> String {
    robot_of("1.11", parts)
}

/// A link with inertia and these parts.
fn link(name: &str, parts: &str) -> String {
    format!("<link name=\"{name}\">{parts}{INERTIAL}</link>")
}

/// A joint with these parts.
fn joint(name: &str, kind: &str, parent: &str, child: &str, parts: &str) -> String {
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent>{parent}</parent><child>{child}</child>{parts}</joint>"
    )
}

/// A fixed joint to the world.
fn anchor(child: &str) -> String {
    joint("anchor", "fixed", "world", child, "")
}

fn load(xml: &str) -> (Model, ImportReport) {
    ModelOptions::default()
        .load_sdf_str(xml)
        .unwrap_or_else(|error| panic!("{error}\n{xml}"))
}

fn error(xml: &str) -> LoadError {
    match ModelOptions::default().load_sdf_str(xml) {
        Ok(_) => panic!("no error:\n{xml}"),
        Err(error) => error,
    }
}

/// The pose of a frame at a configuration.
fn pose_at(model: &Model, q: &[f64], frame: &str) -> Transform<f64> {
    let id = model
        .frame(frame)
        .unwrap_or_else(|| panic!("{frame}: {:?}", model.frame_names()));
    crate::dynamics::frame_pose(model, q, id)
}

/// The pose of a frame where all joints are at zero.
fn pose(model: &Model, frame: &str) -> Transform<f64> {
    pose_at(model, model.neutral().as_slice(), frame)
}

#[track_caller]
fn assert_at(found: &Transform<f64>, position: [f64; 3], x_axis: [f64; 3]) {
    let position = (found.translation - Vector3::from(position)).amax();
    let x_axis = (found.rotation.column(0) - Vector3::from(x_axis)).amax();
    assert!(
        position < 10.0 * ROUNDING && x_axis < 10.0 * ROUNDING,
        "{found:?}"
    );
}

/// The remarks as (path, name, line).
fn places(notes: &[ImportNote]) -> Vec<(&str, &str, u32)> {
    notes
        .iter()
        .map(|note| (note.path.as_str(), note.name.as_str(), note.line))
        .collect()
}
