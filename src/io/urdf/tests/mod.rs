//! Tests of the whole reader.

mod errors;
mod hostile;
mod report;
mod semantics;
mod typed;

use crate::error::LoadError;
use crate::io::{ImportNote, ImportReport, ModelOptions};
use crate::model::Model;

const INERTIAL: &str = r#"<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>"#;

/// A robot of these parts.
fn robot(parts: &str) -> String {
    format!("<robot name=\"r\">{parts}</robot>")
}

/// A body on a joint between the world and `arm`.
fn arm_on(joint: &str) -> String {
    robot(&format!(
        r#"<link name="world"/><link name="arm">{INERTIAL}</link>{joint}"#
    ))
}

/// A joint `j` of a kind between the world and `arm`, with these parts.
fn joint(kind: &str, parts: &str) -> String {
    format!(
        r#"<joint name="j" type="{kind}"><parent link="world"/><child link="arm"/>{parts}</joint>"#
    )
}

fn load(xml: &str) -> (Model, ImportReport) {
    ModelOptions::default()
        .load_urdf_str(xml)
        .unwrap_or_else(|error| panic!("{error}\n{xml}"))
}

fn error(xml: &str) -> LoadError {
    match ModelOptions::default().load_urdf_str(xml) {
        Ok(_) => panic!("no error:\n{xml}"),
        Err(error) => error,
    }
}

/// The remarks as (path, name, line).
fn places(notes: &[ImportNote]) -> Vec<(&str, &str, u32)> {
    notes
        .iter()
        .map(|note| (note.path.as_str(), note.name.as_str(), note.line))
        .collect()
}
