//! Tangents of states, as methods of a model.

use super::frames::{_deviation, difference, integrate};
use super::values::{_difference_jacobian, _integrate_jacobian};
use crate::prelude::*;

/// Methods that call functions of the table.
macro_rules! tangents {
    ($($(#[$attribute:meta])* $name:ident($($x:ident),+) = $function:ident;)*) => {
        #[pymethods]
        impl PyModel { $(
            $(#[$attribute])*
            fn $name<'py>(this: &Bound<'py, Self>, $($x: &Bound<'py, PyAny>),+) -> PyResult<Array<'py>> {
                $function(this, $($x,)+ None)
            }
        )* }
    };
}

tangents! {
    /// Configuration q ⊕ dv, moved by a tangent vector (velocity times time): (..., nq). q (..., nq), dv (..., nv).
    ///
    /// It differs from q + dv for quaternions: dv contains rotations about body axes, rad, and translations of a floating base along them, m.
    #[pyo3(name = "integrate")]
    moved(q, dv) = integrate;

    /// Tangent vector q1 ⊖ q0 from q0 to q1, in body axes at q0: (..., nv). q0 and q1 (..., nq). Rotations take the shorter way.
    #[pyo3(name = "difference")]
    way(q0, q1) = difference;

    /// Derivative of a configuration in tangent directions, (..., nq, nv): of integrate(q, dv) in dv at zero, so that the rate of q is J v.
    integrate_jacobian(q) = _integrate_jacobian;

    /// Tangent vector of a change of a configuration's coordinates, (..., nv, nq): the derivative of difference(q, q1) in q1 at q.
    difference_jacobian(q) = _difference_jacobian;

    /// Deviation (difference(q0, q), v - v0) of a state from another, (..., 2 nv): the argument of a linear controller that is designed at the reference.
    deviation(q, v, q0, v0) = _deviation;
}
