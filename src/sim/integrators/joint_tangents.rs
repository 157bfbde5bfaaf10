//! Motion of a single joint, on dual numbers: in its position or an offset from it, and in another offset or velocity.

use nalgebra::Vector3;

use crate::dynamics::{lifted, moved_by_own_tangents};
use crate::joint::{JointKind, MAX_NV};
use crate::linalg::product::add_scaled;
use crate::model::manifold::{q_range, v_range};
use crate::model::{Body, Model};
use crate::scalar::{Dual, Over, Scalar};
use crate::sim::State;

/// Directions in which a joint is differentiated: a position or offset, then an offset or velocity.
const DIRECTIONS: usize = 2 * MAX_NV;

/// A number of one joint with its derivatives in these.
type Local<T> = Dual<T, DIRECTIONS>;

/// Numbers on which the times of a step may depend.
const TIMES: usize = 2;

/// A number of one joint with its derivatives in these and then in the [centre](Body::center) of its body.
pub(super) type OfNumbers<T> = Dual<T, { TIMES + 3 }>;

/// A tangent of one joint with its derivatives in two others.
pub(super) type JointTangent<T> = [Local<T>; MAX_NV];

/// The velocity of one joint after the step, along the axes of before it, with its derivatives in that of before it.
pub(super) fn stepped_velocity<D: Scalar, T: Scalar>(
    body: &Body<f64>,
    state: &State<T>,
    a: &[T],
    dt: D,
) -> [Dual<T, MAX_NV>; MAX_NV]
where
    Dual<T, MAX_NV>: Over<D>,
{
    let (own, nv) = (v_range(body), body.joint.nv());
    let zero = [Dual::from(0.0); MAX_NV];
    let (mut v, mut rate, mut w) = (zero, zero, zero);
    for (k, at) in own.enumerate() {
        (v[k], rate[k]) = (Dual::variable(state.v[at], k), Dual::constant_of(a[at]));
    }
    let (v, rate) = (&v[..nv], &rate[..nv]);
    (body.joint).step_velocity(&body.center(), v, rate, dt, &mut w[..nv]);
    w
}

/// δq⁺ and δv⁺ of one joint with their derivatives in δq and in the velocity with which it moves.
pub(super) fn joint_step<D: Scalar, T: Scalar>(
    body: &Body<f64>,
    state: &State<T>,
    w: &[Dual<T, MAX_NV>; MAX_NV],
    next: &State<T>,
    dt: D,
) -> (JointTangent<T>, JointTangent<T>)
where
    Local<T>: Over<D>,
{
    let (joint, nq, nv) = (body.joint, body.joint.nq(), body.joint.nv());
    let start = moved(joint, &state.q.as_slice()[q_range(body)]);
    let expected: [Local<T>; MAX_NV + 1] = lifted(&next.q.as_slice()[q_range(body)]);
    let mut dv: JointTangent<T> = std::array::from_fn(|k| Dual::variable(w[k].re, MAX_NV + k));
    let (mut end, mut dq) = (start, [Dual::from(0.0); MAX_NV]);
    let (center, end_q) = (body.center(), &mut end[..nq]);
    joint.move_on(&center, &start[..nq], dt, end_q, &mut dv[..nv]);
    joint.difference(&expected[..nq], &end[..nq], &mut dq[..nv]);
    (dq, dv)
}

/// δq⁺ and δv⁺ of one joint with their derivatives in the time step and the centre of its body, at a fixed acceleration.
///
/// * `kick`, `drift` – times in which the velocity changes, and for which the joint moves at it, s: with their derivatives in two numbers
pub(super) fn joint_step_in_numbers<T: Scalar>(
    body: &Body<f64>,
    state: &State<T>,
    a: &[T],
    next: &State<T>,
    kick: OfNumbers<T>,
    drift: OfNumbers<T>,
) -> [[OfNumbers<T>; MAX_NV]; 2] {
    let (joint, own_q, own_v) = (body.joint, q_range(body), v_range(body));
    let (nq, nv) = (joint.nq(), joint.nv());
    let start: [OfNumbers<T>; MAX_NV + 1] = lifted(&state.q.as_slice()[own_q.clone()]);
    let expected: [OfNumbers<T>; MAX_NV + 1] = lifted(&next.q.as_slice()[own_q]);
    let v: [OfNumbers<T>; MAX_NV + 1] = lifted(&state.v.as_slice()[own_v.clone()]);
    let a: [OfNumbers<T>; MAX_NV + 1] = lifted(&a[own_v]);
    let zero = [Dual::from(0.0); MAX_NV];
    let (mut end, mut dv, mut dq) = (start, zero, zero);
    let center: Vector3<T> = body.center();
    let center = Vector3::from_fn(|k, _| OfNumbers::variable(center[k], TIMES + k));
    joint.step_velocity(&center, &v[..nv], &a[..nv], kick, &mut dv[..nv]);
    let end_q = &mut end[..nq];
    joint.move_on(&center, &start[..nq], drift, end_q, &mut dv[..nv]);
    joint.difference(&expected[..nq], &end[..nq], &mut dq[..nv]);
    [dq, dv]
}

/// The rate of a joint's offset with its derivatives in offset and velocity.
pub(super) fn tangent_rate<T: Scalar>(body: &Body<f64>, offset: &[T], v: &[T]) -> JointTangent<T> {
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
pub(super) fn integrated<T: Scalar>(
    body: &Body<f64>,
    q: &[T],
    offset: &[T],
    end: &[T],
) -> JointTangent<T> {
    let (own_q, own_v) = (q_range(body), v_range(body));
    integrated_alone(body.joint, &q[own_q.clone()], &offset[own_v], &end[own_q])
}

/// [`integrated`] from the numbers of that joint alone.
pub(super) fn integrated_alone<T: Scalar>(
    joint: JointKind,
    q: &[T],
    offset: &[T],
    end: &[T],
) -> JointTangent<T> {
    let start = moved(joint, q);
    let expected: [Local<T>; MAX_NV + 1] = lifted(end);
    let mut tangent = [Dual::from(0.0); MAX_NV];
    for (k, &x) in offset.iter().enumerate() {
        tangent[k] = Dual::variable(x, MAX_NV + k);
    }
    let (nq, nv) = (joint.nq(), joint.nv());
    let (mut moved_on, mut x) = (start, [Dual::from(0.0); MAX_NV]);
    joint.integrate(&start[..nq], &tangent[..nv], &mut moved_on[..nq]);
    joint.difference(&expected[..nq], &moved_on[..nq], &mut x[..nv]);
    x
}

/// The position of a joint with its derivatives in its own tangents, which are the first directions.
fn moved<T: Scalar>(joint: JointKind, q: &[T]) -> [Local<T>; MAX_NV + 1] {
    let moved: [Dual<T, MAX_NV>; MAX_NV + 1] = moved_by_own_tangents(joint, q);
    moved.map(|x| {
        let mut out = Dual::constant_of(x.re);
        out.eps[..MAX_NV].copy_from_slice(&x.eps);
        out
    })
}

/// Adds weights of `q ⊕ offset`, in the tangent space there, to those of q and of the offset.
pub(crate) fn add_integrated<T: Scalar>(
    model: &Model,
    q: &[T],
    offset: &[T],
    end: &[T],
    weights: &[T],
    by_q: &mut [T],
    by_offset: &mut [T],
) {
    for body in model.independent() {
        if body.joint.nv() == 1 {
            by_q[body.v] += weights[body.v];
            by_offset[body.v] += weights[body.v];
        } else {
            let x = integrated(body, q, offset, end);
            add_transposed(body, &x, weights, by_q, by_offset);
        }
    }
}

/// Adds weights of the rates of offsets to those of the offsets and of the velocities.
pub(super) fn add_tangent_rate<T: Scalar>(
    model: &Model,
    offset: &[T],
    v: &[T],
    weights: &[T],
    by_offset: &mut [T],
    by_v: &mut [T],
) {
    for body in model.independent() {
        if body.joint.nv() == 1 {
            by_v[body.v] += weights[body.v];
        } else {
            let x = tangent_rate(body, offset, v);
            add_transposed(body, &x, weights, by_offset, by_v);
        }
    }
}

/// Adds weights of a tangent of one joint to those of the two others on which it depends.
fn add_transposed<T: Scalar>(
    body: &Body<f64>,
    x: &JointTangent<T>,
    weights: &[T],
    by_first: &mut [T],
    by_second: &mut [T],
) {
    let (first, nv) = (body.v, body.joint.nv());
    for (k, x) in x.iter().enumerate().take(nv) {
        let weight = weights[first + k];
        add_scaled(&mut by_first[first..first + nv], &x.eps[..nv], weight);
        let second = &x.eps[MAX_NV..MAX_NV + nv];
        add_scaled(&mut by_second[first..first + nv], second, weight);
    }
}
