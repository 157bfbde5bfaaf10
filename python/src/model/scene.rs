//! Descriptions of more than a robot, as simulators are made of them.

use std::path::PathBuf;
use std::sync::Arc;

use dualbody::io::MjcfScene;

use super::handle::next_id;
use super::load::{Source, of_description, warn_of_floating_arm};
use super::report::PyImportReport;
use crate::prelude::*;

/// Everything that a description holds. Read once, for the robot, its simulators and their keyframes; pickles as the description.
#[pyclass(frozen, name = "_Scene", module = "dualbody._dualbody")]
pub(crate) struct PyScene {
    model: Arc<Model>,
    report: Py<PyImportReport>,
    /// Of an MJCF.
    pub(crate) mjcf: Option<MjcfScene>,
    /// Format, text, path and keywords.
    recipe: Py<PyTuple>,
}

impl PyScene {
    /// The content of a description in a format, "urdf" or "mjcf": a text that begins like XML, or a file.
    pub(crate) fn of_description<'py>(
        format: &str,
        description: &Bound<'py, PyAny>,
        keywords: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, Self>> {
        let scene = of_description(_load_scene, format, description, keywords)?;
        Bound::new(description.py(), scene)
    }

    /// The simulator of everything in it.
    pub(crate) fn simulator(&self) -> PyResult<Simulator> {
        match &self.mjcf {
            Some(scene) => guarded(|| scene.simulator()),
            None => guarded(|| {
                self.report
                    .get()
                    .report
                    .simulator(Model::clone(&self.model))
            }),
        }
    }
}

#[pymethods]
impl PyScene {
    fn __reduce__<'py>(&self, py: Python<'py>) -> Recipe<'py> {
        let make = of_package!(py, "_dualbody", "_load_scene");
        Ok((make.clone(), self.recipe.bind(py).clone().into_any()))
    }
}

functions! {
    /// Reads everything that a description holds; the arguments are those of `_load_model`.
    fn _load_scene(py: Python, format: &str, text: Option<String>, path: Option<PathBuf>, options: &Bound<'py, PyDict>) -> PyResult<PyScene> {
        let source = Source::new(text, path, options)?;
        let (model, mjcf, report) = py.detach(|| match format {
            "mjcf" => source
                .load(|own, path| own.load_mjcf_scene_file(path), |own, text| own.load_mjcf_scene_str(text))
                .map(|(scene, report)| (scene.model.clone(), Some(scene), report)),
            _ => source
                .load(|own, path| own.load_urdf_file(path), |own, text| own.load_urdf_str(text))
                .map(|(model, report)| (model, None, report)),
        })?;
        warn_of_floating_arm(py, &model, &report)?;
        Ok(PyScene {
            model: Arc::new(model),
            report: Py::new(py, PyImportReport { report })?,
            mjcf,
            recipe: source.recipe(format, options)?.unbind(),
        })
    }

    /// The robot of a description.
    fn _scene_model(scene: &Bound<'py, PyScene>) -> PyResult<PyModel> {
        let own = scene.get();
        Ok(PyModel {
            model: Arc::clone(&own.model),
            id: next_id(),
            report: Some(own.report.clone_ref(scene.py())),
            recipe: ("_scene_model", (scene,).into_pyobject(scene.py())?.unbind()),
        })
    }
}
