//! Recordings, their files and pages, plots.

mod files;
mod live;
mod pictures;
mod plot;
mod recording;
mod scene;

pub(crate) use live::PyLive;
pub(crate) use pictures::PyPictures;
pub(crate) use plot::{_plot, PyPlot};
pub(crate) use recording::{_recording, PyRecording};
