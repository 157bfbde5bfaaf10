//! All links at once.

use dualbody::dynamics as d;
use dualbody::spatial::Representation;
use pyo3::prelude::*;

use super::table::functions;
use super::write::write_motion;
use crate::arrays::write_matrix;

functions! {
    /// Velocities of all links in the order of ``model.link_names``, (..., n_links, 6). q (..., nq), v (..., nv).
    link_velocities(q, v; representation: Representation = "body") -> |m| vec![m.links().len(), 6], |m, _, x, r, out| {
        for (link, out) in m.links().iter().zip(out.chunks_mut(6)) {
            write_motion(&d::frame_velocity(m, x[0], x[1], link.frame, r), out);
        }
    };

    /// Accelerations of all links, (..., n_links, 6): classical if mixed, else spatial. q (..., nq), v and a (..., nv).
    link_accelerations(q, v, a; representation: Representation = "body") -> |m| vec![m.links().len(), 6], |m, _, x, r, out| {
        for (link, out) in m.links().iter().zip(out.chunks_mut(6)) {
            write_motion(&d::frame_acceleration(m, x[0], x[1], x[2], link.frame, r), out);
        }
    };

    /// Jacobians of all links in the order of ``model.link_names``, (..., n_links, 6, nv). q (..., nq).
    link_jacobians(q; representation: Representation = "body") -> |m| vec![m.links().len(), 6, m.nv()], |m, memory, x, r, out| {
        let jacobian = &mut memory.one.frame;
        for (link, out) in m.links().iter().zip(out.chunks_mut((6 * m.nv()).max(1))) {
            d::frame_jacobian_into(m, x[0], link.frame, r, jacobian);
            write_matrix(jacobian, out);
        }
    };

    /// Rates of the Jacobians of all links along v, (..., n_links, 6, nv). q (..., nq), v (..., nv).
    link_jacobian_derivatives(q, v; representation: Representation = "body") -> |m| vec![m.links().len(), 6, m.nv()], |m, memory, x, r, out| {
        let jacobian = &mut memory.one.frame;
        for (link, out) in m.links().iter().zip(out.chunks_mut((6 * m.nv()).max(1))) {
            d::frame_jacobian_derivative_into(m, x[0], x[1], link.frame, r, jacobian);
            write_matrix(jacobian, out);
        }
    };
}
