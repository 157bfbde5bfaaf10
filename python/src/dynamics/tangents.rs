//! Tangents of states, as methods of a model.

use pyo3::prelude::*;

use super::{_deviation, _difference_jacobian, _integrate_jacobian};
use crate::arrays::Array;
use crate::model::PyModel;

#[pymethods]
impl PyModel {
    /// Derivative of a configuration in tangent directions, (..., nq, nv): of integrate(q, dv) in dv at zero, so that the rate of q is J v.
    fn integrate_jacobian<'py>(
        this: &Bound<'py, Self>,
        q: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        _integrate_jacobian(this, q, None)
    }

    /// Tangent vector of a change of a configuration's coordinates, (..., nv, nq): the derivative of difference(q, q1) in q1 at q.
    fn difference_jacobian<'py>(
        this: &Bound<'py, Self>,
        q: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        _difference_jacobian(this, q, None)
    }

    /// Deviation (difference(q0, q), v - v0) of a state from another, (..., 2 nv): what a linear controller designed there acts on.
    fn deviation<'py>(
        this: &Bound<'py, Self>,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        q0: &Bound<'py, PyAny>,
        v0: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        _deviation(this, q, v, q0, v0, None)
    }
}
