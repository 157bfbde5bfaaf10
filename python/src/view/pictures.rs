//! Pictures and animations of recordings.

use std::path::PathBuf;

use dualbody::view::{Picture, PictureOptions, Pictures};
use numpy::PyArray3;
use pyo3::types::PyBytes;

use super::recording::{PyRecording, models_of};
use crate::prelude::*;

/// Rows of pixels (height, width, 3), red, green, blue.
type Pixels<'py> = Bound<'py, PyArray3<u8>>;

fn array(py: Python<'_>, picture: Picture) -> PyResult<Pixels<'_>> {
    let shape = [picture.height as usize, picture.width as usize, 3];
    PyArray1::from_vec(py, picture.pixels).reshape(shape)
}

fn options(width: u32, height: u32, rate: f64, speed: f64) -> PictureOptions {
    PictureOptions {
        width,
        height,
        rate,
        speed,
    }
}

/// Draws robots in poses that need not be recorded.
#[pyclass(name = "Pictures", module = "dualbody", frozen)]
pub(crate) struct PyPictures {
    pictures: Pictures,
    models: Vec<Py<PyModel>>,
}

getters! { PyPictures {
    /// Remarks on meshes that are not shown as they are.
    warnings: Vec<String> = |own| own.pictures.warnings().to_vec();
} }

methods! { PyPictures {
    /// Pictures of the robots of a recording, with its objects and its camera. Meshes are read once.
    #[new]
    fn new(py: Python, recording: &PyRecording, width: u32 = 640, height: u32 = 480) -> PyResult<Self> {
        let options = options(width, height, 25.0, 1.0);
        Ok(Self {
            pictures: guarded(|| Pictures::new(&recording.recording, options))?,
            models: (recording.models.iter()).map(|model| model.clone_ref(py)).collect(),
        })
    }

    /// The picture of the robots at configurations q, one of each: (height, width, 3), uint8.
    fn of(&self, py: Python, *q) -> PyResult<Pixels<'py>> {
        let models = models_of(&self.models);
        if q.len() != models.len() {
            let (given, expected) = (q.len(), models.len());
            refuse!("{given} configurations, expected {expected}");
        }
        let states = q.iter().zip(&models).map(|(q, model)| {
            let q = read_vector("q", &q, Some(model.nq()))?;
            Ok(State::new(&q, &vec![0.0; model.nv()]))
        });
        let states = states.collect::<PyResult<Vec<_>>>()?;
        let states: Vec<&State> = states.iter().collect();
        let picture = py.detach(|| guarded(|| self.pictures.of(&states)))?;
        array(py, picture)
    }
} }

methods! { PyRecording {
    /// The picture at a time (s), between moments interpolated: (height, width, 3), uint8.
    fn picture(&self, py: Python, time: f64, width: u32 = 640, height: u32 = 480) -> PyResult<Pixels<'py>> {
        let options = options(width, height, 25.0, 1.0);
        let picture = py.detach(|| guarded(|| self.recording.picture(time, options)))?;
        array(py, picture)
    }

    /// Writes the picture at a time as PNG, and the folders above it; an OSError names a file that cannot be written.
    fn save_png(&self, py: Python, path: PathBuf, time: f64, width: u32 = 640, height: u32 = 480) -> PyResult<()> {
        let options = options(width, height, 25.0, 1.0);
        py.detach(|| guarded(|| self.recording.save_png(path, time, options)))?.or_raise()
    }

    /// Writes the motion as an animation that repeats, a GIF, and the folders above it; an OSError names a file that cannot be written.
    fn save_gif(&self, py: Python, path: PathBuf, width: u32 = 640, height: u32 = 480, rate: f64 = 25.0, speed: f64 = 1.0) -> PyResult<()> {
        let options = options(width, height, rate, speed);
        py.detach(|| guarded(|| self.recording.save_gif(path, options)))?.or_raise()
    }

    /// The animation of save_gif as bytes: a notebook shows them by IPython.display.Image.
    fn to_gif(&self, py: Python, width: u32 = 640, height: u32 = 480, rate: f64 = 25.0, speed: f64 = 1.0) -> PyResult<Bound<'py, PyBytes>> {
        let options = options(width, height, rate, speed);
        let gif = py.detach(|| guarded(|| self.recording.to_gif(options)))?;
        Ok(PyBytes::new(py, &gif))
    }
} }
