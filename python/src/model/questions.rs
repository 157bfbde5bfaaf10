//! What a robot is: sizes, names, joints, parameters.

use pyo3::prelude::*;
use pyo3::types::PySlice;

use super::handle::PyModel;
use super::report::PyImportReport;
use crate::arrays::vector;

#[pymethods]
impl PyModel {
    /// Name of the robot.
    #[getter]
    pub(super) fn name(&self) -> &str {
        self.model.name()
    }

    /// Number of configuration coordinates.
    #[getter]
    pub(super) fn nq(&self) -> usize {
        self.model.nq()
    }

    /// Number of velocity coordinates: degrees of freedom.
    #[getter]
    pub(super) fn nv(&self) -> usize {
        self.model.nv()
    }

    /// Number of moving bodies.
    #[getter]
    fn n_bodies(&self) -> usize {
        self.model.n_bodies()
    }

    /// Number of named joints.
    #[getter]
    pub(super) fn n_joints(&self) -> usize {
        self.model.n_joints()
    }

    /// Mass of what moves, kg.
    #[getter]
    pub(super) fn total_mass(&self) -> f64 {
        self.model.total_mass()
    }

    /// Remarks from loading its file, one sentence each.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.model.remarks().to_vec()
    }

    /// Acceleration of gravity, m/s².
    #[getter]
    pub(super) fn gravity(&self) -> (f64, f64, f64) {
        let g = self.model.gravity();
        (g.x, g.y, g.z)
    }

    /// Whether its root moves freely.
    #[getter]
    pub(super) fn has_floating_base(&self) -> bool {
        self.model.has_floating_base()
    }

    /// Names of the joints, in the order of the tree.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.model.joint_names()
    }

    /// Names of the links, in the order of the tree.
    #[getter]
    fn link_names(&self) -> Vec<&str> {
        self.model.link_names()
    }

    /// Names of all frames, including links.
    #[getter]
    fn frame_names(&self) -> Vec<&str> {
        self.model.frame_names()
    }

    /// Names of the moving bodies (the first link on each), in the order of external forces.
    #[getter]
    fn body_names(&self) -> Vec<&str> {
        let bodies = 0..self.model.n_bodies();
        bodies
            .map(|k| self.model.body_name(dualbody::model::BodyId(k)))
            .collect()
    }

    /// Damping of each velocity coordinate (nv,), N·m·s/rad or N·s/m.
    #[getter]
    pub(super) fn damping<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, self.model.damping().to_vec()).into_any()
    }

    /// Inertia of the rotor of each velocity coordinate (nv,), kg·m² or kg.
    #[getter]
    pub(super) fn armature<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, self.model.armature().to_vec()).into_any()
    }

    /// Report of loading; None for a robot built in code.
    #[getter]
    pub(super) fn import_report(&self, py: Python<'_>) -> Option<Py<PyImportReport>> {
        self.report.as_ref().map(|report| report.clone_ref(py))
    }

    /// Range of a joint in q.
    fn joint_q<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PySlice>> {
        let range = self.model.joint_q(self.joint_id(name)?);
        Ok(PySlice::new(
            py,
            range.start as isize,
            range.end as isize,
            1,
        ))
    }

    /// Range of a joint in v.
    fn joint_v<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PySlice>> {
        let range = self.model.joint_v(self.joint_id(name)?);
        Ok(PySlice::new(
            py,
            range.start as isize,
            range.end as isize,
            1,
        ))
    }

    /// Kind of a joint: "revolute", "prismatic", …
    fn joint_kind(&self, name: &str) -> PyResult<String> {
        let kind = self.model.joints()[self.joint_id(name)?.0].kind;
        let text = format!("{kind:?}").to_lowercase();
        Ok(text.split('(').next().unwrap_or_default().to_owned())
    }

    /// Limits of a joint: (lower, upper, velocity, effort), None where there is none.
    pub(super) fn limits<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let limits = self.model.limits(self.joint_id(name)?);
        let numbers = (limits.lower, limits.upper, limits.velocity, limits.effort);
        py.import("dualbody.model")?
            .getattr("Limits")?
            .call1(numbers)
    }

    /// Masses, inertias, placements, gravity, damping, rotors and springs in one vector; named by parameter_names.
    #[getter]
    pub(super) fn parameters<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, self.model.parameters().as_slice().to_vec()).into_any()
    }

    /// Names of the parameters, in the order of `parameters`.
    #[getter]
    fn parameter_names(&self) -> Vec<String> {
        self.model.parameter_layout().names().to_vec()
    }

    /// Links with physically inconsistent inertia: [(link, reason)].
    fn inertia_flaws(&self) -> Vec<(String, String)> {
        let flaws = self.model.inertia_flaws().into_iter();
        flaws
            .map(|(link, flaw)| (link.to_owned(), flaw.to_string()))
            .collect()
    }
}
