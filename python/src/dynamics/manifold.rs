//! Derivatives of moves and differences of configurations, deviations of states.

use dualbody::Model;
use pyo3::prelude::*;

use super::table::functions;
use crate::arrays::write_matrix;

functions! {
    /// Derivative of a configuration in tangent directions, (..., nq, nv): of integrate(q, dv) in dv at zero.
    _integrate_jacobian(q) -> |m| vec![m.nq(), m.nv()], |m, _, x, out| write_integrate_jacobian(m, x[0], out);

    /// Tangent vector of a change of a configuration's coordinates, (..., nv, nq): the derivative of difference(q, q1) in q1 at q.
    _difference_jacobian(q) -> |m| vec![m.nv(), m.nq()], |m, _, x, out| write_difference_jacobian(m, x[0], out);

    /// Deviation of a state from another, (..., 2 nv). q, q0 (..., nq), v, v0 (..., nv).
    _deviation(q, v, q0, v0) -> |m| vec![2 * m.nv()], |m, _, x, out| {
        let (dq, dv) = out.split_at_mut(m.nv());
        m.difference_into(x[2], x[0], dq);
        for (out, (v, v0)) in dv.iter_mut().zip(x[1].iter().zip(x[3])) {
            *out = v - v0;
        }
    };
}

/// Writes the derivative of integrate(q, dv) in dv at zero, nq × nv, row by row.
pub(crate) fn write_integrate_jacobian(m: &Model, q: &[f64], out: &mut [f64]) {
    write_matrix(&m.integrate_jacobian(q), out);
}

/// Writes the derivative of difference(q, q1) in q1 at q, nv × nq, row by row.
pub(crate) fn write_difference_jacobian(m: &Model, q: &[f64], out: &mut [f64]) {
    write_matrix(&m.difference_jacobian(q), out);
}
