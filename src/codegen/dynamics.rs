//! Dynamics as graphs.

use super::origin::origin;
use super::ports::{ACCELERATION, FORCE, POSITION, motion};
use crate::dynamics;
use crate::model::Model;
use crate::scalar::traced::{Graph, Port, trace};
use crate::scalar::{Over, Scalar, Traced};

/// Traces [`dynamics::inverse_dynamics`]: inputs `q`, `v`, `a`, output `tau`.
pub fn inverse_dynamics<P: Scalar>(model: &Model<P>) -> Graph
where
    Traced: Over<P>,
{
    let graph = trace(|t| {
        let [q, v] = motion(t, model);
        let a = t.input(Port::vector("a", model.nv()).with_unit(ACCELERATION));
        let tau = dynamics::inverse_dynamics(model, &q, &v, &a);
        t.output(Port::vector("tau", model.nv()).with_unit(FORCE), &tau);
    });
    graph.with_origin(origin(model))
}

/// Traces [`dynamics::forward_dynamics`]: inputs `q`, `v`, `tau`, output `a`.
///
/// # Panics
/// If the mass matrix is singular: [`Model::check_mass_matrix`] says so beforehand.
pub fn forward_dynamics<P: Scalar>(model: &Model<P>) -> Graph
where
    Traced: Over<P>,
{
    let graph = trace(|t| {
        let [q, v] = motion(t, model);
        let tau = t.input(Port::vector("tau", model.nv()).with_unit(FORCE));
        let a = dynamics::forward_dynamics(model, &q, &v, &tau);
        t.output(Port::vector("a", model.nv()).with_unit(ACCELERATION), &a);
    });
    graph.with_origin(origin(model))
}

/// Traces [`dynamics::mass_matrix`]: input `q`, output `M`.
pub fn mass_matrix<P: Scalar>(model: &Model<P>) -> Graph
where
    Traced: Over<P>,
{
    let nv = model.nv();
    let graph = trace(|t| {
        let q = t.input(Port::vector("q", model.nq()).with_unit(POSITION));
        let m = dynamics::mass_matrix(model, &q);
        t.output(Port::matrix("M", nv, nv).with_unit("kg m^2, kg m, kg"), &m);
    });
    graph.with_origin(origin(model))
}

/// Traces [`dynamics::inverse_dynamics_derivatives`] along the tree: inputs `q`, `v`, `a`, outputs `dq`, `dv`, `da`, in
/// tangent directions of q.
pub fn inverse_dynamics_derivatives<P: Scalar>(model: &Model<P>) -> Graph
where
    Traced: Over<P>,
{
    let nv = model.nv();
    let graph = trace(|t| {
        let [q, v] = motion(t, model);
        let a = t.input(Port::vector("a", nv).with_unit(ACCELERATION));
        let d = dynamics::inverse_dynamics_derivatives(model, &q, &v, &a);
        for (name, block) in [("dq", &d.dq), ("dv", &d.dv), ("da", &d.da)] {
            t.output(Port::matrix(name, nv, nv), block);
        }
    });
    graph.with_origin(origin(model))
}
