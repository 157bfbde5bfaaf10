//! Recordings, their files and pages, plots.

mod files;
mod plot;
mod recording;
mod scene;

pub(crate) use plot::{_plot, PyPlot};
pub(crate) use recording::{_recording, PyRecording};
