//! Energies, and forces of springs and damping.

use dualbody::dynamics as d;
use pyo3::prelude::*;

use super::table::functions;

functions! {
    /// Kinetic energy, (...), J. q (..., nq), v (..., nv).
    kinetic_energy(q, v) -> |_| Vec::new(), |m, _, x, out| out[0] = d::kinetic_energy(m, x[0], x[1]);

    /// Potential energy of gravity, -m g' p_com, (...), J: it grows with height. q (..., nq).
    potential_energy(q) -> |_| Vec::new(), |m, _, x, out| out[0] = d::potential_energy(m, x[0]);

    /// Energy of the joints' springs, (...), J. q (..., nq).
    elastic_energy(q) -> |_| Vec::new(), |m, _, x, out| out[0] = d::elastic_energy(m, x[0]);

    /// Forces of springs and damping, (..., nv), N·m or N. q (..., nq), v (..., nv).
    passive_forces(q, v) -> |m| vec![m.nv()], |m, _, x, out| d::passive_forces_into(m, x[0], x[1], out);
}
