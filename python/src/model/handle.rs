//! The class `Model`.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use dualbody::model::JointId;

use super::report::PyImportReport;
use crate::prelude::*;

/// Robot: an immutable tree of bodies and joints.
///
/// Made by `Model.from_urdf`, `Model.from_sdf`, `Model.from_mjcf`, `ModelBuilder` or a function of `dualbody.samples`. Units are SI; q has nq numbers,
/// velocities, accelerations and forces have nv. A floating base has q[:3], its place in the world, and q[3:7], its quaternion (w, x, y, z); v[:3]
/// and v[3:6] are its linear and angular velocity in its own axes, tau[:6] force and torque there. A ball joint has a quaternion in q and an
/// angular velocity in the child's axes in v. Joints come in the order of the tree (`joint_q`, `joint_v`), which need not be that of the file.
/// Equal robots compare equal, wherever they come from. Pickles as its description.
#[pyclass(frozen, name = "Model", module = "dualbody", weakref)]
pub(crate) struct PyModel {
    pub(crate) model: Arc<Model>,
    /// One number for each robot that was made: what working memory is known by.
    pub(crate) id: u64,
    pub(crate) report: Option<Py<PyImportReport>>,
    /// Name of the function of this module that makes the robot, and its arguments.
    pub(super) recipe: (&'static str, Py<PyTuple>),
}

/// Makes numbers that identify models and simulators.
pub(crate) fn next_id() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed)
}

functions! {
    /// Calls a method of a robot that gives a changed one.
    fn _edited(model: &Bound<'py, PyModel>, method: &str, arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
        model.call_method1(method, arguments)
    }
}

#[pymethods]
impl PyModel {
    pub(super) fn __repr__(&self) -> String {
        let m = &self.model;
        let base = match m.has_floating_base() {
            true => "floating",
            false => "fixed",
        };
        format!(
            "Model(\"{}\", nq={}, nv={}, {} joints, {} base, {:.6} kg)",
            m.name(),
            m.nq(),
            m.nv(),
            m.n_joints(),
            base,
            m.total_mass()
        )
    }

    /// Whether all parts and numbers are equal; where the robot comes from does not count.
    fn __eq__(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.model, &other.model) || *self.model == *other.model
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.model.name().hash(&mut hasher);
        // Zeros of both signs are equal.
        let numbers = self.model.parameters();
        numbers
            .iter()
            .for_each(|x| (x + 0.0).to_bits().hash(&mut hasher));
        hasher.finish()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Recipe<'py> {
        let make = py.import("dualbody._dualbody")?.getattr(self.recipe.0)?;
        Ok((make, self.recipe.1.bind(py).clone().into_any()))
    }
}

impl PyModel {
    pub(crate) fn new(model: Model, recipe: (&'static str, Bound<'_, PyTuple>)) -> Self {
        Self {
            model: Arc::new(model),
            id: next_id(),
            report: None,
            recipe: (recipe.0, recipe.1.unbind()),
        }
    }

    /// A changed robot, which remembers what it was made of.
    pub(super) fn edited<'py>(
        this: &Bound<'py, Self>,
        method: &str,
        arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error = PyErr>,
        model: Model,
    ) -> PyResult<Self> {
        let py = this.py();
        let arguments = arguments.into_pyobject(py)?;
        let recipe = (this, method, arguments).into_pyobject(py)?;
        Ok(Self::new(model, ("_edited", recipe)))
    }

    /// Applies a function of rows that needs no working memory.
    ///
    /// * `tail` – shape of the result of one row
    pub(crate) fn map<'py>(
        &self,
        arguments: &[Argument<'_, 'py>],
        tail: &[usize],
        one: &(dyn Fn(&[&[f64]], &mut [f64]) + Sync),
    ) -> PyResult<Array<'py>> {
        map_plain((&self.model, self.id), arguments, tail, one)
    }

    pub(super) fn joint_id(&self, name: &str) -> PyResult<JointId> {
        self.model.find_joint(name).or_raise()
    }
}
