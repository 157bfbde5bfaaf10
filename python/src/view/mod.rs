//! Recordings, their files and pages, plots.

/// Methods that write something as a text, and to a file.
macro_rules! files {
    ($class:ident.$field:ident { $($(#[$doc:meta])* $text:ident, $(#[$of_file:meta])* $save:ident;)* }) => {
        #[pymethods]
        impl $class { $(
            $(#[$doc])*
            fn $text(&self) -> PyResult<String> {
                guarded(|| self.$field.$text())
            }

            $(#[$of_file])*
            ///
            /// The folders above it are made; an OSError names a file that cannot be written.
            fn $save(&self, path: PathBuf) -> PyResult<()> {
                guarded(|| self.$field.$save(path))?.or_raise()
            }
        )* }
    };
}

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
