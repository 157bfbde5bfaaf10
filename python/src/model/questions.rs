//! Properties of a robot: sizes, names, joints, parameters.

use pyo3::types::PySlice;

use super::report::PyImportReport;
use crate::prelude::*;

getters! { PyModel {
    /// Name of the robot.
    name: &str = |own| own.model.name();

    /// Number of configuration coordinates.
    nq: usize = |own| own.model.nq();

    /// Number of velocity coordinates: degrees of freedom.
    nv: usize = |own| own.model.nv();

    /// Number of moving bodies.
    n_bodies: usize = |own| own.model.n_bodies();

    /// Number of named joints.
    n_joints: usize = |own| own.model.n_joints();

    /// Mass of what moves, kg.
    total_mass: f64 = |own| own.model.total_mass();

    /// Remarks of the reader of its file, a sentence each.
    remarks: Vec<String> = |own| own.model.remarks().to_vec();

    /// Whether its root moves freely.
    has_floating_base: bool = |own| own.model.has_floating_base();

    /// Names of the joints, in the order of the tree.
    joint_names: Vec<&str> = |own| own.model.joint_names();

    /// Names of the links, in the order of the tree.
    link_names: Vec<&str> = |own| own.model.link_names();

    /// Names of all frames, those of links among them.
    frame_names: Vec<&str> = |own| own.model.frame_names();

    /// Damping of each velocity coordinate (nv,), N·m·s/rad or N·s/m.
    damping: Bound<'py, PyAny> = |own, py| vector(py, own.model.damping());

    /// Inertia of the rotor of each velocity coordinate (nv,), kg·m² or kg.
    armature: Bound<'py, PyAny> = |own, py| vector(py, own.model.armature());

    /// Remarks of the reader; None for a robot that was built in code.
    import_report: Option<Py<PyImportReport>> = |own, py| own.report.as_ref().map(|report| report.clone_ref(py));

    /// Masses, inertias, placements, gravity, damping, rotors and springs in one vector; named by parameter_names.
    parameters: Bound<'py, PyAny> = |own, py| vector(py, own.model.parameters().as_slice());

    /// Names of the parameters, in the order of `parameters`.
    parameter_names: Vec<String> = |own| own.model.parameter_layout().names().to_vec();
} }

#[pymethods]
impl PyModel {
    /// Acceleration of gravity, m/s².
    #[getter]
    pub(super) fn gravity(&self) -> (f64, f64, f64) {
        let g = self.model.gravity();
        (g.x, g.y, g.z)
    }

    /// Names of the moving bodies (the first link on each), in the order of external forces.
    #[getter]
    fn body_names(&self) -> Vec<&str> {
        let bodies = 0..self.model.n_bodies();
        bodies
            .map(|k| self.model.body_name(dualbody::model::BodyId(k)))
            .collect()
    }

    /// Range of a joint in q.
    fn joint_q<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PySlice>> {
        let range = self.model.joint_q(self.joint_id(name)?);
        Ok(slice(py, range))
    }

    /// Range of a joint in v.
    fn joint_v<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PySlice>> {
        let range = self.model.joint_v(self.joint_id(name)?);
        Ok(slice(py, range))
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
        of_package!(py, "model", "Limits").call1(numbers)
    }

    /// Links with physically inconsistent inertia: [(link, reason)].
    fn inertia_flaws(&self) -> Vec<(String, String)> {
        let flaws = self.model.inertia_flaws().into_iter();
        flaws
            .map(|(link, flaw)| (link.to_owned(), flaw.to_string()))
            .collect()
    }
}
