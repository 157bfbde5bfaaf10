//! Motion of a single joint, on dual numbers: in its position or an offset from it, and in another offset or velocity.

use nalgebra::Vector3;

use crate::dynamics::{lifted, moved_by_own_tangents};
use crate::joint::{JointKind, MAX_NV};
use crate::linalg::product::add_scaled;
use crate::model::manifold::{q_range, v_range};
use crate::model::{Body, Model};
use crate::scalar::{CHUNK, Dual, MapEach, Scalar, from_each};
use crate::sim::State;

/// Directions in which a joint is differentiated: a position or offset, then an offset or velocity.
const DIRECTIONS: usize = 2 * MAX_NV;

/// Numbers on which the times of a step may depend.
const TIMES: usize = 2;

/// A number of one joint with its derivatives in these and then in the [centre](Body::center) of its body.
pub(super) type OfNumbers<T> = Dual<T, { TIMES + 3 }>;

/// A tangent of one joint with its derivatives in two others.
pub(super) type JointTangent<T> = [Dual<T, DIRECTIONS>; MAX_NV];

/// A number with its derivatives in some of these directions: all joints are compiled for one width, and wider numbers take several turns.
pub(super) type Part<T> = Dual<T, CHUNK>;

/// Numbers of a joint along its axes.
pub(super) type Parts<T> = [Part<T>; MAX_NV];

/// A number with its slope in a direction, where that is among the directions from `first` on.
pub(super) fn seeded<T: Scalar>(x: T, slope: T, direction: usize, first: usize) -> Part<T> {
    let mut out = Dual::constant_of(x);
    if (first..first + CHUNK).contains(&direction) {
        out.eps[direction - first] = slope;
    }
    out
}

/// Several numbers in a row with slope one, those of directions from `direction` on.
fn variables<T: Scalar>(x: &[T], direction: usize, first: usize) -> Parts<T> {
    let mut out = [Dual::from(0.0); MAX_NV];
    for (k, &x) in x.iter().enumerate() {
        out[k] = seeded(x, T::one(), direction + k, first);
    }
    out
}

/// The derivatives of tangents in `n` directions, some at a time.
///
/// * `place` – where the derivative in a direction belongs
/// * `part` – the tangents with their derivatives in directions from the one on that it is given
pub(super) fn in_parts<T: Scalar, const N: usize, const K: usize>(
    n: usize,
    place: impl Fn(usize) -> usize,
    part: impl Fn(usize) -> [Parts<T>; K],
) -> [[Dual<T, N>; MAX_NV]; K] {
    let mut out = [[Dual::from(0.0); MAX_NV]; K];
    for first in (0..n).step_by(CHUNK) {
        let found = part(first);
        for (out, x) in out.iter_mut().flatten().zip(found.iter().flatten()) {
            out.re = x.re;
            for k in first..n.min(first + CHUNK) {
                out.eps[place(k)] = x.eps[k - first];
            }
        }
    }
    out
}

/// [`in_parts`] of a joint: directions of its degrees of freedom, then as many of the others.
pub(super) fn in_both<T: Scalar, const K: usize>(
    joint: JointKind,
    part: impl Fn(usize) -> [Parts<T>; K],
) -> [JointTangent<T>; K] {
    let nv = joint.nv();
    let place = |k| if k < nv { k } else { MAX_NV + k - nv };
    in_parts(2 * nv, place, part)
}

/// The velocity of one joint after the step, along the axes of before it, with its derivatives in that of before it.
pub(super) fn stepped_velocity<T: Scalar>(
    body: &Body<f64>,
    state: &State<T>,
    a: &[T],
    dt: T,
) -> [Dual<T, MAX_NV>; MAX_NV] {
    let (own, nv) = (v_range(body), body.joint.nv());
    let (center, dt) = (body.center(), Dual::constant_of(dt));
    let rate: [Part<T>; MAX_NV + 1] = lifted(&a[own.clone()]);
    let [w] = in_parts(
        nv,
        |k| k,
        |first| {
            let v = variables(&state.v.as_slice()[own.clone()], 0, first);
            [kicked(body.joint, &center, &v, &rate, dt)]
        },
    );
    w
}

/// The first half of a step.
fn kicked<T: Scalar>(
    joint: JointKind,
    center: &Vector3<Part<T>>,
    v: &[Part<T>],
    a: &[Part<T>],
    dt: Part<T>,
) -> Parts<T> {
    let (nv, mut w) = (joint.nv(), [Dual::from(0.0); MAX_NV]);
    joint.step_velocity(center, &v[..nv], &a[..nv], dt, &mut w[..nv]);
    w
}

/// The second half: δq⁺ from where it is expected to end, and v⁺.
fn drifted<T: Scalar>(
    joint: JointKind,
    center: &Vector3<Part<T>>,
    start: &[Part<T>; MAX_NV + 1],
    mut v: Parts<T>,
    dt: Part<T>,
    expected: &[T],
) -> [Parts<T>; 2] {
    let (nq, nv) = (joint.nq(), joint.nv());
    let mut end = *start;
    joint.move_on(center, &start[..nq], dt, &mut end[..nq], &mut v[..nv]);
    [from_expected(joint, expected, &end), v]
}

/// The tangent from the expected position to another one.
fn from_expected<T: Scalar>(
    joint: JointKind,
    expected: &[T],
    end: &[Part<T>; MAX_NV + 1],
) -> Parts<T> {
    let expected: [Part<T>; MAX_NV + 1] = lifted(expected);
    let (nq, nv, mut out) = (joint.nq(), joint.nv(), [Dual::from(0.0); MAX_NV]);
    joint.difference(&expected[..nq], &end[..nq], &mut out[..nv]);
    out
}

/// δq⁺ and δv⁺ of one joint with their derivatives in δq and in the velocity with which it moves.
pub(super) fn joint_step<T: Scalar>(
    body: &Body<f64>,
    state: &State<T>,
    w: &[Dual<T, MAX_NV>; MAX_NV],
    next: &State<T>,
    dt: T,
) -> (JointTangent<T>, JointTangent<T>) {
    let (joint, own) = (body.joint, q_range(body));
    let (center, dt, w) = (body.center(), Dual::constant_of(dt), w.map_each(|w| w.re));
    let (start, end) = (&state.q.as_slice()[own.clone()], &next.q.as_slice()[own]);
    let nv = joint.nv();
    let [dq, dv] = in_both(joint, |first| {
        let start = moved_by_own_tangents(joint, start, first);
        drifted(
            joint,
            &center,
            &start,
            variables(&w[..nv], nv, first),
            dt,
            end,
        )
    });
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
    let (start, end) = (
        &state.q.as_slice()[own_q.clone()],
        &next.q.as_slice()[own_q],
    );
    let start: [Part<T>; MAX_NV + 1] = lifted(start);
    let v: [Part<T>; MAX_NV + 1] = lifted(&state.v.as_slice()[own_v.clone()]);
    let a: [Part<T>; MAX_NV + 1] = lifted(&a[own_v]);
    let center: Vector3<T> = body.center();
    let part = |x: OfNumbers<T>, first: usize| {
        let own = |k| x.eps.get(first + k).copied().unwrap_or(T::zero());
        Dual::new(x.re, from_each(own))
    };
    in_parts(
        TIMES + 3,
        |k| k,
        |first| {
            let center = Vector3::from_fn(|k, _| seeded(center[k], T::one(), TIMES + k, first));
            let w = kicked(joint, &center, &v, &a, part(kick, first));
            drifted(joint, &center, &start, w, part(drift, first), end)
        },
    )
}

/// The rate of a joint's offset with its derivatives in offset and velocity.
pub(super) fn tangent_rate<T: Scalar>(body: &Body<f64>, offset: &[T], v: &[T]) -> JointTangent<T> {
    let (joint, own, nv) = (body.joint, v_range(body), body.joint.nv());
    let [out] = in_both(joint, |first| {
        let u = variables(&offset[own.clone()], 0, first);
        let w = variables(&v[own.clone()], nv, first);
        let mut out = [Dual::from(0.0); MAX_NV];
        joint.tangent_rate(&u[..nv], &w[..nv], &mut out[..nv]);
        [out]
    });
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
    let (nq, nv) = (joint.nq(), joint.nv());
    let [out] = in_both(joint, |first| {
        let start: [Part<T>; MAX_NV + 1] = moved_by_own_tangents(joint, q, first);
        let (offset, mut moved_on) = (variables(offset, nv, first), start);
        joint.integrate(&start[..nq], &offset[..nv], &mut moved_on[..nq]);
        [from_expected(joint, end, &moved_on)]
    });
    out
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
