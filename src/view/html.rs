//! The HTML viewer: a single self-contained file.
//!
//! Its script, in several files in `page/`, draws and interpolates. This crate computes the poses of bodies by
//! [`forward_kinematics`](crate::dynamics::forward_kinematics), with one exception: in a viewer without a motion, sliders rotate or move a body about
//! or along its z axis (see [`joint`](crate::joint)), with its subtree. Such a viewer also marks overlapping collision shapes.
//!
//! External text is embedded only as JSON, with `<` escaped, so that it can neither end its script element nor start another one; the script shows it as text.

use std::path::Path;

use serde::Serialize;

use super::camera::Camera;
use super::collisions::{Collisions, collisions};
use super::files::write;
use super::mesh::Mesh;
use super::meshes::Meshes;
use super::motion::{Motion, motion};
use super::recording::Recording;
use super::scene::{Robot, robot};
use super::scene_object::Scenery;
use crate::error::RecordingError;
use crate::model::Model;

/// Data that the script of the HTML viewer reads.
#[derive(Serialize)]
struct Data<'a> {
    title: &'a str,
    warnings: Vec<String>,
    camera: Option<Camera>,
    robots: Vec<Robot>,
    #[serde(rename = "fixtures")]
    scenery: Vec<Scenery<'a>>,
    meshes: Vec<Mesh>,
    motion: Option<Motion>,
    /// Additional data of the HTML viewer of a running simulation.
    #[serde(skip_serializing_if = "Option::is_none")]
    live: Option<serde_json::Value>,
    /// Of an HTML viewer with sliders.
    #[serde(skip_serializing_if = "Option::is_none")]
    collisions: Option<Collisions>,
}

const STYLE: &str = include_str!("page/page.css");
const BODY: &str = include_str!("page/page.html");

/// Scripts in the order in which they need one another.
const SCRIPTS: [&str; 12] = [
    include_str!("page/data.js"),
    include_str!("page/math.js"),
    include_str!("page/shapes.js"),
    include_str!("page/shaders.js"),
    include_str!("page/renderer.js"),
    include_str!("page/camera.js"),
    include_str!("page/collide.js"),
    include_str!("page/scene.js"),
    include_str!("page/player.js"),
    include_str!("page/plots.js"),
    include_str!("page/controls.js"),
    include_str!("page/main.js"),
];

/// Script of a simulation that runs, after the others.
const LIVE: &str = include_str!("page/live.js");

impl Recording {
    /// Returns the recording as an HTML viewer; see [`save_html`](Self::save_html).
    pub fn to_html(&self) -> String {
        page(self, Some(motion(self)).filter(|_| self.len() > 0), None)
    }

    /// Writes an HTML viewer with the motion of the robots and plots of all values: one file for any browser, without network access. Creates the folder.
    ///
    /// It contains up to 60 times per second, fewer for long recordings, and interpolates between them. A mesh that cannot be shown is replaced by a
    /// box, with a warning in the viewer.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save_html(&self, path: impl AsRef<Path>) -> Result<(), RecordingError> {
        write(path.as_ref(), self.to_html())
    }
}

/// Returns an HTML viewer of a robot without a motion: a slider for each joint of one degree of freedom, marks on colliding links, the tree with
/// names, and optional frames, centres of mass and inertia ellipsoids. Write it to a file with the extension `.html`.
///
/// # Examples
/// ```
/// use dualbody::{model::samples, view::model_page};
///
/// let page = model_page(&samples::arm());
/// assert!(page.starts_with("<!doctype html>"));
/// ```
pub fn model_page(model: &Model) -> String {
    page(&Recording::new(model), None, None)
}

/// The HTML viewer of a simulation that runs on a port of this machine.
///
/// * `targets` – sliders of its inputs
#[cfg(feature = "live")]
pub(super) fn live_page(recording: &Recording, targets: &impl Serialize, port: u16) -> String {
    let live = serde_json::json!({ "targets": targets, "port": port });
    page(recording, None, Some(live))
}

fn page(recording: &Recording, motion: Option<Motion>, live: Option<serde_json::Value>) -> String {
    let mut meshes = Meshes::default();
    let tracks = recording.robots.iter();
    let robots = tracks.map(|track| robot(track, &mut meshes)).collect();
    let objects = recording.scene_objects.iter();
    let scenery = objects.map(|object| object.scenery(&mut meshes)).collect();
    let port = live.as_ref().map(|live| live["port"].clone());
    let data = Data {
        title: &recording.title,
        warnings: meshes.warnings(),
        camera: recording.camera,
        robots,
        scenery,
        meshes: meshes.meshes,
        collisions: motion
            .is_none()
            .then(|| collisions(&recording.robots[0].model))
            .flatten(),
        motion,
        live,
    };
    // Only non-text keys and failing writers cause errors; there are none.
    let data = serde_json::to_string(&data).unwrap_or_else(|error| unreachable!("{error}"));
    let data = data.replace('<', "\\u003c");
    let more = if port.is_some() { LIVE } else { "" };
    let (title, script) = (escaped(&recording.title), SCRIPTS.concat() + more);
    // The viewer may fetch nothing except frames of a simulation from its own server, whatever the HTML file contains.
    let mut policy = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; media-src blob:".to_owned();
    if let Some(port) = &port {
        policy += &format!("; connect-src ws://127.0.0.1:{port} ws://localhost:{port}");
    }
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n{BODY}\
         <script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>\n\"use strict\";\n(() => {{\n{script}}})();\n</script>\n</body>\n</html>\n"
    )
}

/// Text as HTML.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
