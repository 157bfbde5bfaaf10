//! Recordings, their files and pages, plots.

mod files;
mod pictures;
mod plot;
mod recording;
mod scene;

pub(crate) use pictures::PyPictures;
pub(crate) use plot::{_plot, PyPlot};
pub(crate) use recording::{_recording, PyRecording};
