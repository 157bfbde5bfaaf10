//! Pages, tables and plots of recordings.

use std::path::PathBuf;

use dualbody::view::Recording;

use super::plot::PyPlot;
use super::recording::{PyRecording, models_of};
use crate::prelude::*;

#[pymethods]
impl PyRecording {
    fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.show(py, "100%", "480")?.call_method0("_repr_html_")
    }

    /// Plots columns over time, named as in the table.
    #[pyo3(signature = (*columns))]
    pub(super) fn plot(&self, columns: Vec<String>) -> PyResult<PyPlot> {
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        Ok(PyPlot {
            plot: guarded(|| self.recording.plot(&columns))?.or_raise()?,
        })
    }

    /// Plots one column over another.
    fn phase_plot(&self, x: &str, y: &str) -> PyResult<PyPlot> {
        Ok(PyPlot {
            plot: guarded(|| self.recording.phase_plot(x, y))?.or_raise()?,
        })
    }
}

methods! { PyRecording {
    /// The page as a text: it works offline, in one file.
    fn to_html(&self) -> PyResult<String> { Ok(self.recording.to_html()) }

    /// Writes the page, which needs nothing else, and creates its folders; an OSError names a file that cannot be written.
    fn save_html(&self, path: PathBuf) -> PyResult<()> { self.recording.save_html(path).or_raise() }

    /// The table of all columns as a text of CSV: times (s), coordinates, inputs by what they act on ("u.pivot"; "u0", "u1" where that is unknown), series.
    fn to_csv(&self) -> PyResult<String> { Ok(self.recording.to_csv()) }

    /// Writes the table of all columns as CSV, as of to_csv, and creates its folders; an OSError names a file that cannot be written.
    fn save_csv(&self, path: PathBuf) -> PyResult<()> { self.recording.save_csv(path).or_raise() }

    /// The recording as a text of JSON, which `read` reads.
    fn to_json(&self) -> PyResult<String> { Ok(self.recording.to_json()) }

    /// Writes the recording as JSON, which `read` reads, and creates its folders; an OSError names a file that cannot be written.
    fn save_json(&self, path: PathBuf) -> PyResult<()> { self.recording.save_json(path).or_raise() }

    /// Reads a recording from a table or a JSON file; the robots are not in it.
    #[staticmethod]
    fn read(path: PathBuf, *models) -> PyResult<Self> {
        let empty = Self::new(models)?;
        let robots = models_of(&empty.models);
        let is_table = path.extension().is_some_and(|extension| extension == "csv");
        let recording = guarded(|| match is_table {
            true => Recording::read_csv(&path, &robots),
            false => Recording::read_json(&path, &robots),
        })?;
        let recording = recording.or_raise()?;
        Ok(Self {
            recording,
            models: empty.models,
        })
    }

    /// The HTML viewer in a frame of given size, for notebooks: width and height as in HTML.
    fn show(&self, py: Python, width: &str = "100%", height: &str = "480") -> PyResult<Bound<'py, PyAny>> {
        of_package!(py, "view", "Page").call1((self.to_html()?, width, height))
    }
} }
