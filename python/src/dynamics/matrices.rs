//! Inverse of the mass matrix, Coriolis matrix, derivatives of the dynamics.

use dualbody::Model;
use dualbody::dynamics::{
    self as d, CoriolisScratch, ForwardDynamicsDerivatives, ForwardDynamicsDerivativesScratch,
    InverseDynamicsDerivatives, InverseDynamicsDerivativesScratch, MassMatrixInverseScratch,
};
use pyo3::prelude::*;

use super::table::functions;
use super::write::write_all;
use crate::arrays::write_matrix;
use crate::scratch::Memory;

/// Derivatives of inverse dynamics by q, v, a.
pub(crate) fn inverse_slopes(m: &Model, memory: &mut Memory, x: &[&[f64]], out: &mut [f64]) {
    let new = || {
        (
            InverseDynamicsDerivativesScratch::new(m),
            InverseDynamicsDerivatives::zeros(m),
        )
    };
    let (scratch, all) = memory.inverse_derivatives.get_or_insert_with(new);
    d::inverse_dynamics_derivatives_into(m, x[0], x[1], x[2], &[], scratch, all);
    write_all([&all.dq, &all.dv, &all.da], out);
}

/// Derivatives of forward dynamics by q, v, tau.
pub(crate) fn forward_slopes(m: &Model, memory: &mut Memory, x: &[&[f64]], out: &mut [f64]) {
    let new = || {
        (
            ForwardDynamicsDerivativesScratch::new(m),
            ForwardDynamicsDerivatives::zeros(m),
        )
    };
    let (scratch, all) = memory.forward_derivatives.get_or_insert_with(new);
    d::forward_dynamics_derivatives_into(m, x[0], x[1], x[2], &[], scratch, all);
    write_all([&all.dq, &all.dv, &all.dtau], out);
}

functions! {
    /// Inverse of the mass matrix, (..., nv, nv). q (..., nq). [Carpentier 2018]
    mass_matrix_inverse(q) -> |m| vec![m.nv(); 2], |m, memory, x, out| {
        let memory = &mut memory.one;
        let scratch = memory.inverse.get_or_insert_with(|| MassMatrixInverseScratch::new(m));
        d::mass_matrix_inverse_into(m, x[0], scratch, &mut memory.square);
        write_matrix(&memory.square, out);
    };

    /// C(q, v) with C v = Coriolis and centrifugal forces and dM/dt - 2 C skew, (..., nv, nv).
    ///
    /// q (..., nq), v (..., nv). [Echeandia, Wensing 2021]
    coriolis_matrix(q, v) -> |m| vec![m.nv(); 2], |m, memory, x, out| {
        let memory = &mut memory.one;
        let scratch = memory.coriolis.get_or_insert_with(|| CoriolisScratch::new(m));
        d::coriolis_matrix_into(m, x[0], x[1], scratch, &mut memory.square);
        write_matrix(&memory.square, out);
    };

    /// Derivatives of inverse dynamics in one array (..., 3, nv, nv): by q, v, a.
    _inverse_dynamics_derivatives(q, v, a) -> |m| vec![3, m.nv(), m.nv()], inverse_slopes;

    /// Derivatives of forward dynamics in one array (..., 3, nv, nv): by q, v, tau.
    _forward_dynamics_derivatives(q, v, tau) -> |m| vec![3, m.nv(), m.nv()], forward_slopes;

    /// Second derivatives of tau in (q, v, a), tangent: (..., nv, 3 nv, 3 nv). q (..., nq), v and a (..., nv).
    inverse_dynamics_second_derivatives(q, v, a) -> |m| vec![m.nv(), 3 * m.nv(), 3 * m.nv()], |m, _, x, out| {
        let all = d::inverse_dynamics_second_derivatives(m, x[0], x[1], x[2]);
        let width = 9 * m.nv() * m.nv();
        all.iter().zip(out.chunks_mut(width.max(1))).for_each(|(matrix, out)| write_matrix(matrix, out));
    };
}
