//! Motion of one joint by itself, on dual numbers: in its position or an offset from it, and in another offset or velocity.

use crate::dynamics::{lifted, moved_by_own_tangents};
use crate::joint::{JointKind, MAX_NV};
use crate::model::Body;
use crate::model::manifold::{q_range, v_range};
use crate::scalar::Dual;
use crate::sim::State;

/// Directions in which a joint is differentiated: a position or offset, then an offset or velocity.
const DIRECTIONS: usize = 2 * MAX_NV;

/// A number of one joint with its derivatives in these.
type Local = Dual<f64, DIRECTIONS>;

/// A tangent of one joint with its derivatives in two others.
pub(super) type JointTangent = [Local; MAX_NV];

/// The velocity of one joint after the step, along the axes of before it, with its derivatives in that of before it.
pub(super) fn stepped_velocity(
    body: &Body<f64>,
    state: &State,
    a: &[f64],
    dt: f64,
) -> [Dual<f64, MAX_NV>; MAX_NV] {
    let (own, nv) = (v_range(body), body.joint.nv());
    let zero = [Dual::from(0.0); MAX_NV];
    let (mut v, mut rate, mut w) = (zero, zero, zero);
    for (k, at) in own.enumerate() {
        (v[k], rate[k]) = (Dual::variable(state.v[at], k), a[at].into());
    }
    body.joint
        .step_velocity(&v[..nv], &rate[..nv], dt, &mut w[..nv]);
    w
}

/// δq⁺ and δv⁺ of one joint with their derivatives in δq and in the velocity with which it moves.
pub(super) fn joint_step(
    body: &Body<f64>,
    state: &State,
    w: &[Dual<f64, MAX_NV>; MAX_NV],
    next: &State,
    dt: f64,
) -> (JointTangent, JointTangent) {
    let (joint, nq, nv) = (body.joint, body.joint.nq(), body.joint.nv());
    let start = moved(joint, &state.q.as_slice()[q_range(body)]);
    let expected = lifted::<f64, Local>(&next.q.as_slice()[q_range(body)]);
    let mut dv: JointTangent = std::array::from_fn(|k| Dual::variable(w[k].re, MAX_NV + k));
    let (mut end, mut dq) = (start, [Dual::from(0.0); MAX_NV]);
    joint.move_on(&start[..nq], dt, &mut end[..nq], &mut dv[..nv]);
    joint.difference(&expected[..nq], &end[..nq], &mut dq[..nv]);
    (dq, dv)
}

/// The rate of a joint's offset with its derivatives in offset and velocity.
pub(super) fn tangent_rate(body: &Body<f64>, offset: &[f64], v: &[f64]) -> JointTangent {
    let zero = [Dual::from(0.0); MAX_NV];
    let (own, nv) = (v_range(body), body.joint.nv());
    let (mut u, mut w, mut out) = (zero, zero, zero);
    for (k, at) in own.enumerate() {
        u[k] = Dual::variable(offset[at], k);
        w[k] = Dual::variable(v[at], MAX_NV + k);
    }
    body.joint.tangent_rate(&u[..nv], &w[..nv], &mut out[..nv]);
    out
}

/// (q ⊕ δq) ⊕ (offset + δ) ⊖ `end` of one joint, with its derivatives in δq and in δ.
pub(super) fn integrated(body: &Body<f64>, q: &[f64], offset: &[f64], end: &[f64]) -> JointTangent {
    let (joint, own) = (body.joint, q_range(body));
    let start = moved(joint, &q[own.clone()]);
    let expected = lifted::<f64, Local>(&end[own]);
    let mut tangent = [Dual::from(0.0); MAX_NV];
    for (k, &x) in offset[v_range(body)].iter().enumerate() {
        tangent[k] = Dual::variable(x, MAX_NV + k);
    }
    let (nq, nv) = (joint.nq(), joint.nv());
    let (mut moved_on, mut x) = (start, [Dual::from(0.0); MAX_NV]);
    joint.integrate(&start[..nq], &tangent[..nv], &mut moved_on[..nq]);
    joint.difference(&expected[..nq], &moved_on[..nq], &mut x[..nv]);
    x
}

/// The position of a joint with its derivatives in its own tangents, which are the first directions.
fn moved(joint: JointKind, q: &[f64]) -> [Local; MAX_NV + 1] {
    let moved: [Dual<f64, MAX_NV>; MAX_NV + 1] = moved_by_own_tangents(joint, q);
    moved.map(|x| {
        let mut out = Dual::from(x.re);
        out.eps[..MAX_NV].copy_from_slice(&x.eps);
        out
    })
}
