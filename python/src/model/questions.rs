//! Properties of a robot: sizes, names, joints, parameters, masses link by link, configurations, texts and pages.

use pyo3::types::PySlice;
use rand::SeedableRng;

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

    /// Mass of a link, kg: of the link alone, also if several fixed links form one body.
    fn link_mass(&self, link: &str) -> PyResult<f64> {
        Ok(self.model.link_inertia(link).or_raise()?.mass)
    }

    /// Centre of mass of a link in its frame, (3,), m; NaN for a link without mass.
    fn link_center_of_mass<'py>(&self, py: Python<'py>, link: &str) -> PyResult<Bound<'py, PyAny>> {
        let com = self.model.link_inertia(link).or_raise()?.com();
        Ok(vector(py, com.as_slice()))
    }

    /// Inertia of a link in its frame, (6, 6), rows and columns [linear; angular].
    fn link_inertia<'py>(&self, py: Python<'py>, link: &str) -> PyResult<Array<'py>> {
        let array = empty(py, &[6, 6]);
        let inertia = self.model.link_inertia(link).or_raise()?.to_matrix();
        // Symmetric: columns are rows.
        numbers_mut(&array).copy_from_slice(inertia.as_slice());
        Ok(array)
    }

    /// Masses of all links in the order of link_names, (n_links,), kg.
    #[getter]
    fn link_masses<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        let all = self.model.link_inertias();
        vector(
            py,
            &all.iter().map(|inertia| inertia.mass).collect::<Vec<_>>(),
        )
    }

    /// Inertias of all links in their frames, in the order of link_names, (n_links, 6, 6).
    #[getter]
    fn link_inertias<'py>(&self, py: Python<'py>) -> Array<'py> {
        let all = self.model.link_inertias();
        let array = empty(py, &[all.len(), 6, 6]);
        for (inertia, out) in all.iter().zip(numbers_mut(&array).chunks_mut(36)) {
            out.copy_from_slice(inertia.to_matrix().as_slice());
        }
        array
    }

    /// Neutral configuration (nq,).
    pub(super) fn neutral<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, self.model.neutral().as_slice())
    }

    /// Random configuration within the limits, (nq,); equal seeds give equal results.
    fn random_configuration<'py>(&self, seed: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (py, seed) = (seed.py(), whole("seed", seed)?);
        let mut rng = rand::rngs::Xoshiro256PlusPlus::seed_from_u64(seed);
        let q = self.model.random_configuration(&mut rng);
        Ok(vector(py, q.as_slice()))
    }
}

methods! { PyModel {
    /// Configuration on the path from q0 (t = 0) to q1 (t = 1): (..., nq).
    fn interpolate(&self, q0, q1, t: f64) -> PyResult<Array<'py>> {
        let (m, nq) = (&self.model, [self.model.nq()]);
        self.map(&[argument("q0", q0, &nq), argument("q1", q1, &nq)], &nq, &|x, out| {
            out.copy_from_slice(m.interpolate(x[0], x[1], t).as_slice());
        })
    }

    /// Random velocity of at most a speed in each coordinate, (nv,); equal seeds give equal results.
    fn random_velocity(&self, seed, speed: f64 = 1.0) -> PyResult<Bound<'py, PyAny>> {
        let (py, seed) = (seed.py(), whole("seed", seed)?);
        let mut rng = rand::rngs::Xoshiro256PlusPlus::seed_from_u64(seed);
        let v = guarded(|| self.model.random_velocity(&mut rng, speed))?;
        Ok(vector(py, v.as_slice()))
    }
} }

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
        of_package!(py, "view", "Page").call1((self.to_html(), width, height))
    }
} }
