//! Visualisation: recordings of motions, their files, and an HTML viewer for any browser.
//!
//! A [`Recording`] contains the states and inputs of one or several robots over one time axis, named scalars, traced frames, forces, obstacles and
//! goals. Make it from a rollout in one call, or fill it step by step.
//!
//! ```no_run
//! use dualbody::{Simulator, State, model::samples, view::Recording};
//!
//! let simulator = Simulator::new(samples::cartpole()).with_time_step(0.01);
//! let rollout = simulator.rollout(&State::new(&[0.0, 0.5], &[0.0; 2]), 1000, |_, _, _| {});
//! let recording = Recording::from_rollout(simulator.model(), &rollout);
//! recording.save_html("out/cartpole/index.html")?; // opens in any browser, without a network
//! recording.save_csv("out/cartpole/motion.csv")?;
//! # Ok::<(), dualbody::RecordingError>(())
//! ```
//!
//! | file | content | read back by |
//! |---|---|---|
//! | CSV | all values: times, states, inputs, forces, series | [`Recording::read_csv`] |
//! | JSON | the same, with display settings | [`Recording::read_json`] |
//! | HTML | viewer for any browser, with reduced time resolution | – |
//!
//! | question | function | cost |
//! |---|---|---|
//! | record a rollout? | [`Recording::from_rollout`], with ground, contacts and constraints [`Recording::of_simulation`] | copies its states |
//! | record some robots of a batch? | [`Recording::from_batch`] | the same for each |
//! | record a running simulation? | [`Recording::push`] | O(n) per time |
//! | save as HTML viewer, table, data? | [`Recording::save_html`], [`Recording::save_csv`], [`Recording::save_json`] | linear in the size of the recording |
//! | show a robot with sliders? | [`model_page`] | linear in its meshes |
//! | report of an identification? | `identification_page` (feature `identification`) | linear in the motion |
//! | obstacles, traces, curves? | [`Recording::add_shape`], [`Track::trace`], [`Recording::add_series`] | |
//! | sensor readings? | [`Recording::add_readings`] | one evaluation per time |
//!
//! With the feature `plot`, `Recording::plot` and `Recording::phase_plot` plot columns as SVG and PNG. With the feature `render`,
//! `Recording::save_png` and `Recording::save_gif` draw pictures and animations without a browser. With the feature `live`, `Live` shows an
//! interactive running simulation in the browser. With the feature `rerun`, `RerunStream` sends a simulation to the Rerun viewer while it runs, and
//! `Recording::save_rrd` writes a file that the viewer opens.
//!
//! Recordings have no effect on the simulation, which does not import this module.

mod applied;
mod blob;
mod bond;
mod camera;
mod collisions;
mod contacts;
mod csv;
mod files;
mod furnish;
mod ground;
#[cfg(feature = "live")]
mod hold;
mod html;
#[cfg(feature = "identification")]
mod identification;
mod json;
#[cfg(feature = "live")]
mod live;
mod mesh;
mod meshes;
mod motion;
#[cfg(feature = "render")]
mod pictures;
#[cfg(feature = "plot")]
mod plot;
#[cfg(feature = "plot")]
mod plots;
#[cfg(any(feature = "plot", feature = "render"))]
mod png;
mod readings;
mod recording;
#[cfg(feature = "rerun")]
mod rerun;
mod rows;
mod scene;
mod scene_object;
mod shape;
mod skeleton;
#[cfg(test)]
mod tests;
mod touches;
mod track;

pub use crate::error::RecordingError;
pub use camera::Camera;
pub use ground::Heights;
pub use html::model_page;
#[cfg(feature = "identification")]
pub use identification::identification_page;
#[cfg(feature = "live")]
pub use live::Live;
#[cfg(feature = "render")]
pub use pictures::{Picture, PictureOptions, Pictures};
#[cfg(feature = "plot")]
pub use plot::{Plot, PlotLine, PlotScale};
pub use recording::{Recording, Series};
#[cfg(feature = "rerun")]
pub use rerun::RerunStream;
pub use scene_object::{Appearance, SceneObject};
pub use track::{ForceTrack, Track};
