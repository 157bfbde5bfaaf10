//! Robots as texts and pages.

use crate::prelude::*;

#[pymethods]
impl PyModel {
    /// The robot as a URDF text.
    fn to_urdf(&self) -> PyResult<String> {
        guarded(|| self.model.to_urdf())?.or_raise()
    }

    /// The robot as a MuJoCo XML text.
    fn to_mjcf(&self) -> PyResult<String> {
        guarded(|| self.model.to_mjcf())?.or_raise()
    }

    /// The tree of links and joints as a text.
    pub(super) fn tree(&self) -> String {
        self.model.tree().to_string()
    }

    /// HTML viewer of the robot, as text.
    fn to_html(&self) -> String {
        dualbody::view::model_page(&self.model)
    }

    pub(super) fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.show(py, "100%", "480")?.call_method0("_repr_html_")
    }
}

methods! { PyModel {
    /// The HTML viewer in a frame of given size, for notebooks: width and height as in HTML.
    fn show(&self, py: Python, width: &str = "100%", height: &str = "480") -> PyResult<Bound<'py, PyAny>> {
        of_package!(py, "view", "Page")
            .call1((self.to_html(), width, height))
    }
} }
