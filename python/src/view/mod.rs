//! Recordings, their files and pages, plots.

mod files;
mod plot;
mod recording;
mod scene;

pub(crate) use plot::PyPlot;
pub(crate) use recording::PyRecording;
