//! Derivatives of moves and differences of configurations.

use dualbody::Model;
use nalgebra::DVector;
use num_dual::Dual64;
use pyo3::prelude::*;

use super::table::functions;

functions! {
    /// Derivative of a configuration in tangent directions, (..., nq, nv): of integrate(q, dv) in dv at zero.
    _integrate_jacobian(q) -> |m| vec![m.nq(), m.nv()], |m, _, x, out| write_integrate_jacobian(m, x[0], out);

    /// Tangent vector of a change of a configuration's coordinates, (..., nv, nq): the derivative of difference(q, q1) in q1 at q.
    _difference_jacobian(q) -> |m| vec![m.nv(), m.nq()], |m, _, x, out| write_difference_jacobian(m, x[0], out);
}

/// Writes the derivative of integrate(q, dv) in dv at zero, nq × nv, row by row.
pub(crate) fn write_integrate_jacobian(m: &Model, q: &[f64], out: &mut [f64]) {
    let q = numbers_of(q);
    let zero = numbers_of(&vec![0.0; m.nv()]);
    write_slopes(&zero, out, |dv| m.integrate(&q, dv));
}

/// Writes the derivative of difference(q, q1) in q1 at q, nv × nq, row by row.
pub(crate) fn write_difference_jacobian(m: &Model, q: &[f64], out: &mut [f64]) {
    let q = numbers_of(q);
    write_slopes(&q, out, |moved| m.difference(&q, moved));
}

fn numbers_of(x: &[f64]) -> Vec<Dual64> {
    x.iter().map(|&x| x.into()).collect()
}

/// Writes the Jacobian of a function at a point, row by row.
fn write_slopes(at: &[Dual64], out: &mut [f64], function: impl Fn(&[Dual64]) -> DVector<Dual64>) {
    let n = at.len();
    for j in 0..n {
        let mut moved = at.to_vec();
        moved[j].eps = 1.0;
        for (i, x) in function(&moved).iter().enumerate() {
            out[i * n + j] = x.eps;
        }
    }
}
