//! Gradient of a step of Euler: each joint's own step backwards, then that of its one acceleration.

use crate::joint::MAX_NV;
use crate::linalg::product::dot;
use crate::model::Body;
use crate::model::manifold::v_range;
use crate::scalar::Scalar;
use crate::sim::integrators::acceleration::AccelerationAdjoint;
use crate::sim::integrators::balance::AccelerationWeights;
use crate::sim::integrators::joint_tangents::{joint_step, joint_step_in_time, stepped_velocity};
use crate::sim::{AccelerationScratch, Moment, State, StepSlopes};

/// Adds the gradient of λᵀ x⁺ of the step from a moment to `next`, which has just been taken.
pub(in crate::sim::integrators) fn add_gradient<T: Scalar>(
    at: &Moment<'_, f64, T>,
    found: &mut AccelerationScratch<T>,
    next: &State<T>,
    adjoint: &[T],
    acceleration: &mut AccelerationAdjoint<T>,
    out: &mut StepSlopes<'_, T>,
) {
    let (nv, dt) = (at.model().nv(), at.dt());
    let (by_q, rest) = adjoint.split_at(nv);
    let (by_v, by_contact) = rest.split_at(nv);
    let mut weights = std::mem::take(&mut acceleration.weights);
    for body in at.model().independent() {
        if body.joint.nv() == 1 {
            // q⁺ = q + Δt v⁺,  v⁺ = v + Δt a
            let k = body.v;
            let by_next_v = by_v[k] + by_q[k] * dt;
            out.q[k] += by_q[k];
            out.v[k] += by_next_v;
            weights[k] = by_next_v * dt;
            out.add_time_step(by_next_v * found.a[k] + by_q[k] * next.v[k]);
        } else {
            let joint = Curved {
                at,
                a: &found.a,
                next,
            };
            joint.add(body, by_q, by_v, &mut weights, out);
        }
    }
    // m⁺ = m + (m⁺ − m)
    let contact = out.contact.iter_mut().zip(by_contact);
    contact.for_each(|(out, &x)| *out += x);
    let of_acceleration = AccelerationWeights {
        a: &weights,
        contact: by_contact,
        has_friction: out.has_parts,
    };
    acceleration.add(at, found, &of_acceleration, out);
    acceleration.weights = weights;
}

/// A step of joints whose configuration is not a vector:  (δq⁺, δv⁺) = D (δq, δw) with w the velocity after it along the axes of before it.
struct Curved<'a, T: Scalar> {
    at: &'a Moment<'a, f64, T>,
    a: &'a [T],
    next: &'a State<T>,
}

impl<T: Scalar> Curved<'_, T> {
    fn add(
        &self,
        body: &Body<f64>,
        by_q: &[T],
        by_v: &[T],
        weights: &mut [T],
        out: &mut StepSlopes<'_, T>,
    ) {
        let (state, dt, nv) = (self.at.state, self.at.dt(), body.joint.nv());
        let w = stepped_velocity(body, state, self.a, dt);
        let (dq, dv) = joint_step(body, state, &w, self.next, dt);
        let mut by_w = [T::zero(); MAX_NV];
        for k in 0..nv {
            let (x, y) = (by_q[body.v + k], by_v[body.v + k]);
            for l in 0..nv {
                out.q[body.v + l] += x * dq[k].eps[l] + y * dv[k].eps[l];
                by_w[l] += x * dq[k].eps[MAX_NV + l] + y * dv[k].eps[MAX_NV + l];
            }
        }
        for l in 0..nv {
            for (&x, w) in by_w.iter().zip(&w).take(nv) {
                out.v[body.v + l] += x * w.eps[l];
            }
            weights[body.v + l] = by_w[l] * dt;
        }
        if out.has_parts {
            let (dq, dv) = joint_step_in_time(body, state, self.a, self.next, dt);
            let own = v_range(body);
            let slope = dot(&by_q[own.clone()], &dq[..nv]) + dot(&by_v[own], &dv[..nv]);
            out.add_time_step(slope);
        }
    }
}
