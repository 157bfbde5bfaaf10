//! Forces on bodies from forces by name, and robots that nothing holds.

use dualbody::dynamics::{self as d, NamedForces};
use dualbody::spatial::{Force, Representation};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::Named;
use super::write::write_force;
use crate::arrays::{Array, empty, numbers_mut, read_vector};
use crate::errors::OrRaise;
use crate::model::PyModel;

/// Forces on the bodies in their frames, (n_bodies, 6), from forces on frames and links by name: what `external` of the dynamics takes.
///
/// q (nq,); forces {name: (6,)}: [linear; angular] (N, N·m) in a representation.
#[pyfunction]
#[pyo3(signature = (model, q, forces, representation="mixed"))]
pub(crate) fn external_forces<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    forces: &Bound<'py, PyDict>,
    representation: &str,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let q = read_vector("q", q, Some(m.nq()))?;
    let representation = Representation::find(m, representation)?;
    let mut named = NamedForces::default();
    for (name, force) in forces {
        let force = read_vector("forces", &force, Some(6))?;
        let force = Force::from_array(std::array::from_fn(|k| force[k]));
        let name: String = name.extract()?;
        named
            .add_frame_force(m, &name, &force, representation)
            .or_raise()?;
    }
    let kinematics = d::forward_kinematics(m, &q, &vec![0.0; m.nv()]);
    let bodies = d::external_forces(m, &kinematics, &named);
    let array = empty(model.py(), &[m.n_bodies(), 6]);
    let out = numbers_mut(&array);
    out.chunks_mut(6)
        .zip(&bodies)
        .for_each(|(out, force)| write_force(force, out));
    Ok(array)
}

/// Raises a ValueError that names the joints that nothing resists, if the mass matrix is singular.
#[pyfunction]
pub(crate) fn check_mass_matrix(model: &Bound<'_, PyModel>) -> PyResult<()> {
    model.get().model.check_mass_matrix().or_raise()
}
