//! Centre of mass.

use dualbody::dynamics as d;
use pyo3::prelude::*;

use super::table::functions;
use super::write::write_vector3;
use crate::arrays::write_matrix;

functions! {
    /// Centre of mass in the world, (..., 3), m. q (..., nq).
    center_of_mass(q) -> |_| vec![3], |m, _, x, out| write_vector3(&d::center_of_mass(m, x[0]), out);

    /// Velocity of the centre of mass in the world, (..., 3), m/s. q (..., nq), v (..., nv).
    center_of_mass_velocity(q, v) -> |_| vec![3], |m, _, x, out| write_vector3(&d::center_of_mass_velocity(m, x[0], x[1]), out);

    /// Acceleration of the centre of mass in the world, (..., 3), m/s². q (..., nq), v and a (..., nv).
    center_of_mass_acceleration(q, v, a) -> |_| vec![3], |m, _, x, out| {
        write_vector3(&d::center_of_mass_acceleration(m, x[0], x[1], x[2]), out);
    };

    /// Jacobian of the centre of mass: its velocity is J v, (..., 3, nv). q (..., nq).
    center_of_mass_jacobian(q) -> |m| vec![3, m.nv()], |m, _, x, out| write_matrix(&d::center_of_mass_jacobian(m, x[0]), out);

    /// Derivative of the centre of mass in tangent directions of q, (..., 3, nv), m. q (..., nq).
    center_of_mass_derivatives(q) -> |m| vec![3, m.nv()], |m, _, x, out| write_matrix(&d::center_of_mass_derivatives(m, x[0]), out);
}
