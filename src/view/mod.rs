//! Looking at robots: recordings of motions, their files, and a page that shows them in any browser.
//!
//! A [`Recording`] is what a person looks at after a simulation: the states and inputs of one or several robots over
//! one time axis, scalars by name, frames to trace, forces to draw, obstacles and goals beside them. It is made from a
//! rollout in one call, or filled step by step.
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
//! | file | holds | read back by |
//! |---|---|---|
//! | CSV | every number: times, states, inputs, forces, series | [`Recording::read_csv`] |
//! | JSON | the same, and what to trace and show | [`Recording::read_json`] |
//! | HTML | what a person sees, thinned out to what a screen can show | a person |
//!
//! | question | function | cost |
//! |---|---|---|
//! | what happened in a rollout? | [`Recording::from_rollout`], with ground and rods [`Recording::of_simulation`] | copies its states |
//! | in a batch, to some of its robots? | [`Recording::from_batch`] | the same for each |
//! | while it runs? | [`Recording::push`] | O(n) a moment |
//! | as a page, a table, data? | [`Recording::save_html`], [`Recording::save_csv`], [`Recording::save_json`] | linear in what is recorded |
//! | just the robot, with sliders? | [`model_page`] | linear in its meshes |
//! | how well was a robot identified? | `identification_page` (feature `identification`) | linear in the motion |
//! | more than robots? | [`Recording::add_shape`], [`Track::trace`], [`Recording::add_series`] | |
//! | what sensors read? | [`Recording::add_readings`] | an evaluation of each moment |
//!
//! With the feature `plot`, `Recording::plot` and `Recording::phase_plot` make pictures of columns as SVG and PNG. With
//! the feature `render`, `Recording::save_png` and `Recording::save_gif` draw pictures and animations without a browser. With
//! the feature `live`, `Live` shows a simulation in the browser while it runs, to be dragged and steered. With
//! the feature `rerun`, `RerunStream` sends a simulation to the Rerun viewer while it runs, and `Recording::save_rrd`
//! writes a file that the viewer opens.
//!
//! Recordings never change what they record: nothing here is imported by the simulation.

mod applied;
mod blob;
mod bond;
mod camera;
mod collisions;
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
