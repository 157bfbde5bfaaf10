//! Tangents of states, as methods of a model.

use pyo3::prelude::*;

use super::frames::{_deviation, difference, integrate};
use super::values::{_difference_jacobian, _integrate_jacobian};
use crate::arrays::Array;
use crate::model::PyModel;

#[pymethods]
impl PyModel {
    /// Configuration q ⊕ dv, moved by a tangent vector (velocity times time): (..., nq). q (..., nq), dv (..., nv).
    ///
    /// It differs from q + dv for quaternions: dv contains rotations about body axes, rad, and translations of a floating base along them, m.
    #[pyo3(name = "integrate")]
    fn moved<'py>(
        this: &Bound<'py, Self>,
        q: &Bound<'py, PyAny>,
        dv: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        integrate(this, q, dv, None)
    }

    /// Tangent vector q1 ⊖ q0 from q0 to q1, in body axes at q0: (..., nv). q0 and q1 (..., nq). Rotations take the shorter way.
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

    /// Deviation (difference(q0, q), v - v0) of a state from another, (..., 2 nv): the argument of a linear controller that is designed at the reference.
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
