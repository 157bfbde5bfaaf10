//! What is linear in the inertial parameters.

use dualbody::dynamics as d;
use pyo3::prelude::*;

use super::table::functions;
use crate::arrays::write_matrix;

functions! {
    /// Matrix Y with tau = Y p, p the ten inertial parameters of each body, (..., nv, 10 n_bodies). q (..., nq), v and a (..., nv).
    joint_torque_regressor(q, v, a) -> |m| vec![m.nv(), 10 * m.n_bodies()], |m, _, x, out| {
        write_matrix(&d::joint_torque_regressor(m, x[0], x[1], x[2]), out);
    };

    /// Row y with T = y p, p the ten inertial parameters of each body, (..., 10 n_bodies). q (..., nq), v (..., nv).
    kinetic_energy_regressor(q, v) -> |m| vec![10 * m.n_bodies()], |m, _, x, out| {
        out.copy_from_slice(d::kinetic_energy_regressor(m, x[0], x[1]).as_slice());
    };

    /// Row y with U = y p, p the ten inertial parameters of each body, (..., 10 n_bodies). q (..., nq).
    potential_energy_regressor(q) -> |m| vec![10 * m.n_bodies()], |m, _, x, out| {
        out.copy_from_slice(d::potential_energy_regressor(m, x[0]).as_slice());
    };
}
