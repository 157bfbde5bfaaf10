//! Dynamics as graphs.
//!
//! These functions are marked `#[inline]`: only programs that trace compile the recorded code; with the feature `graphs` it is compiled once with the library.

use super::origin::trace_of;
use super::ports::{ACCELERATION, FORCE, POSITION, motion};
use crate::dynamics;
use crate::model::Model;
use crate::scalar::traced::{Graph, Port};

/// Traces [`dynamics::inverse_dynamics`]: inputs `q`, `v`, `a`, output `tau`.
#[cfg_attr(not(feature = "graphs"), inline)]
pub fn inverse_dynamics(model: &Model) -> Graph {
    trace_of(model, |t| {
        let [q, v] = motion(t, model);
        let a = t.input(Port::vector("a", model.nv()).with_unit(ACCELERATION));
        let tau = dynamics::inverse_dynamics(model, &q, &v, &a);
        t.output(Port::vector("tau", model.nv()).with_unit(FORCE), &tau);
    })
}

/// Traces [`dynamics::forward_dynamics`]: inputs `q`, `v`, `tau`, output `a`.
///
/// # Panics
/// If the mass matrix is singular: [`Model::check_mass_matrix`] checks this beforehand.
#[cfg_attr(not(feature = "graphs"), inline)]
pub fn forward_dynamics(model: &Model) -> Graph {
    trace_of(model, |t| {
        let [q, v] = motion(t, model);
        let tau = t.input(Port::vector("tau", model.nv()).with_unit(FORCE));
        let a = dynamics::forward_dynamics(model, &q, &v, &tau);
        t.output(Port::vector("a", model.nv()).with_unit(ACCELERATION), &a);
    })
}

/// Traces [`dynamics::mass_matrix`]: input `q`, output `M`.
#[cfg_attr(not(feature = "graphs"), inline)]
pub fn mass_matrix(model: &Model) -> Graph {
    let nv = model.nv();
    trace_of(model, |t| {
        let q = t.input(Port::vector("q", model.nq()).with_unit(POSITION));
        let m = dynamics::mass_matrix(model, &q);
        t.output(Port::matrix("M", nv, nv).with_unit("kg m^2, kg m, kg"), &m);
    })
}

/// Traces [`dynamics::inverse_dynamics_derivatives`] along the tree: inputs `q`, `v`, `a`, outputs `dq`, `dv`, `da`, in
/// tangent directions of q.
#[cfg_attr(not(feature = "graphs"), inline)]
pub fn inverse_dynamics_derivatives(model: &Model) -> Graph {
    let nv = model.nv();
    trace_of(model, |t| {
        let [q, v] = motion(t, model);
        let a = t.input(Port::vector("a", nv).with_unit(ACCELERATION));
        let d = dynamics::inverse_dynamics_derivatives(model, &q, &v, &a);
        for (name, block) in [("dq", &d.dq), ("dv", &d.dv), ("da", &d.da)] {
            t.output(Port::matrix(name, nv, nv), block);
        }
    })
}
