//! Tangents of states, as methods of a model.

use pyo3::prelude::*;

use super::frames::{_deviation, difference, integrate};
use super::values::{_difference_jacobian, _integrate_jacobian};
use crate::arrays::Array;
use crate::model::PyModel;

#[pymethods]
impl PyModel {
    /// Configuration q moved by the tangent vector dv, a velocity times a time: (..., nq). q (..., nq), dv (..., nv).
    ///
    /// Not q + dv where there are quaternions: dv has turns in the body's axes, rad, and moves of a floating base along them, m.
    #[pyo3(name = "integrate")]
    fn moved<'py>(
        this: &Bound<'py, Self>,
        q: &Bound<'py, PyAny>,
        dv: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        integrate(this, q, dv, None)
    }

    /// Tangent vector that leads from q0 to q1, in the axes of the bodies at q0: (..., nv). q0 and q1 (..., nq). The shorter way about a turn.
    #[pyo3(name = "difference")]
    fn way<'py>(
        this: &Bound<'py, Self>,
        q0: &Bound<'py, PyAny>,
        q1: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        difference(this, q0, q1, None)
    }

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
