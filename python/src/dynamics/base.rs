//! Other representations of the velocity of the base.

use dualbody::Model;
use dualbody::dynamics::{BaseFrame, BaseQuantity};
use dualbody::spatial::Representation;
use nalgebra::DMatrix;
use pyo3::prelude::*;

use super::Named;
use super::table::functions;
use crate::arrays::{Array, read_matrix, read_vector};
use crate::errors::{shape_error, value_error};
use crate::model::PyModel;

functions! {
    /// Velocity whose base part is in another representation, (..., nv). q (..., nq), v (..., nv).
    velocity_to_representation(q, v; representation: Representation) -> |m| vec![m.nv()], |m, _, x, to, out| {
        out.copy_from_slice(BaseFrame::new(m, to).to_representation(x[0], BaseQuantity::Velocity, x[1]).as_slice());
    };

    /// Velocity of this library from one whose base part is in another representation, (..., nv). q (..., nq), v (..., nv).
    velocity_from_representation(q, v; representation: Representation) -> |m| vec![m.nv()], |m, _, x, from, out| {
        out.copy_from_slice(BaseFrame::new(m, from).from_representation(x[0], BaseQuantity::Velocity, x[1]).as_slice());
    };

    /// Joint forces whose base part is in another representation, (..., nv). q (..., nq), tau (..., nv).
    force_to_representation(q, tau; representation: Representation) -> |m| vec![m.nv()], |m, _, x, to, out| {
        out.copy_from_slice(BaseFrame::new(m, to).to_representation(x[0], BaseQuantity::Force, x[1]).as_slice());
    };

    /// Joint forces of this library from some whose base part is in another representation, (..., nv). q (..., nq), tau (..., nv).
    force_from_representation(q, tau; representation: Representation) -> |m| vec![m.nv()], |m, _, x, from, out| {
        out.copy_from_slice(BaseFrame::new(m, from).from_representation(x[0], BaseQuantity::Force, x[1]).as_slice());
    };

    /// Acceleration whose base part is in another representation, (..., nv). q (..., nq), v and a (..., nv).
    acceleration_to_representation(q, v, a; representation: Representation) -> |m| vec![m.nv()], |m, _, x, to, out| {
        out.copy_from_slice(BaseFrame::new(m, to).to_representation(x[0], BaseQuantity::Acceleration { v: x[1] }, x[2]).as_slice());
    };

    /// Acceleration of this library from one whose base part is in another representation, (..., nv). q (..., nq), v and a (..., nv).
    acceleration_from_representation(q, v, a; representation: Representation) -> |m| vec![m.nv()], |m, _, x, from, out| {
        out.copy_from_slice(BaseFrame::new(m, from).from_representation(x[0], BaseQuantity::Acceleration { v: x[1] }, x[2]).as_slice());
    };
}

/// Jacobian of one configuration for velocities whose base part is in another representation. q (nq,), jacobian (rows, nv).
#[pyfunction]
pub(crate) fn jacobian_to_representation<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    jacobian: &Bound<'py, PyAny>,
    representation: &str,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let (q, jacobian) = (
        read_vector("q", q, Some(m.nq()))?,
        columns("jacobian", jacobian, m)?,
    );
    let to = Representation::find(m, representation)?;
    Ok(crate::arrays::matrix(
        model.py(),
        &BaseFrame::new(m, to).jacobian(&q, &jacobian),
    ))
}

/// Mass matrix of one configuration for velocities whose base part is in another representation. q (nq,), mass_matrix (nv, nv).
#[pyfunction]
pub(crate) fn mass_matrix_to_representation<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    mass_matrix: &Bound<'py, PyAny>,
    representation: &str,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let (q, matrix) = (
        read_vector("q", q, Some(m.nq()))?,
        columns("mass_matrix", mass_matrix, m)?,
    );
    if matrix.nrows() != m.nv() {
        return Err(value_error("mass_matrix is not square"));
    }
    let to = Representation::find(m, representation)?;
    let base = BaseFrame::new(m, to);
    let half = base.jacobian(&q, &matrix).transpose();
    Ok(crate::arrays::matrix(model.py(), &base.jacobian(&q, &half)))
}

fn columns(name: &'static str, value: &Bound<'_, PyAny>, model: &Model) -> PyResult<DMatrix<f64>> {
    let matrix = read_matrix(name, value)?;
    if matrix.ncols() == model.nv() {
        return Ok(matrix);
    }
    let expected = format!("(rows, {})", model.nv());
    Err(shape_error(name, matrix.shape(), expected))
}
