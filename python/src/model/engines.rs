//! States in the coordinates of other engines.

use dualbody::Model;
use dualbody::sim::{Engine, EngineCoordinates};
use nalgebra::DVector;
use pyo3::prelude::*;

use super::handle::PyModel;
use crate::arrays::{read_vector, vector};
use crate::errors::{OrRaise, choice, guarded};

fn engine(name: &str) -> PyResult<Engine> {
    let choices = [
        ("pinocchio", Engine::Pinocchio),
        ("mujoco", Engine::MuJoCo),
        ("jaxsim", Engine::JaxSim),
    ];
    choice("engine", name, &choices)
}

pub(super) fn coordinates<'m>(
    model: &'m Model,
    name: &str,
    joints: Option<Vec<String>>,
) -> PyResult<EngineCoordinates<'m>> {
    let coordinates = EngineCoordinates::new(model, engine(name)?);
    match joints {
        None => Ok(coordinates),
        Some(joints) => guarded(|| coordinates.with_joint_order(&joints))?.or_raise(),
    }
}

fn pair<'py>(
    py: Python<'py>,
    a: DVector<f64>,
    b: DVector<f64>,
) -> (Bound<'py, PyAny>, Bound<'py, PyAny>) {
    let array = |x: DVector<f64>| vector(py, x.as_slice().to_vec()).into_any();
    (array(a), array(b))
}

#[pymethods]
impl PyModel {
    /// State of this robot in the coordinates of "pinocchio", "mujoco" or "jaxsim": (q, v). Joints may be in another order.
    #[pyo3(signature = (engine, q, v, joint_order=None))]
    fn to_engine<'py>(
        &self,
        py: Python<'py>,
        engine: &str,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        joint_order: Option<Vec<String>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let coordinates = coordinates(&self.model, engine, joint_order)?;
        let q = read_vector("q", q, Some(self.model.nq()))?;
        let v = read_vector("v", v, Some(self.model.nv()))?;
        let (q, v) = guarded(|| coordinates.state_to(&dualbody::State::new(&q, &v)))?;
        Ok(pair(py, q, v))
    }

    /// State (q, v) of this robot from the coordinates of "pinocchio", "mujoco" or "jaxsim".
    #[pyo3(signature = (engine, q, v, joint_order=None))]
    fn from_engine<'py>(
        &self,
        py: Python<'py>,
        engine: &str,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        joint_order: Option<Vec<String>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let coordinates = coordinates(&self.model, engine, joint_order)?;
        let q = read_vector("q", q, Some(coordinates.nq()))?;
        let v = read_vector("v", v, Some(self.model.nv()))?;
        let state = guarded(|| coordinates.state_from(&q, &v))?;
        Ok(pair(py, state.q, state.v))
    }
}
