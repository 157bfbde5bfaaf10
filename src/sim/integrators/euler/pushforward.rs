//! Jacobians of an Euler step, semi-implicit or linearly implicit: those of its one acceleration, and of each joint's own step.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::rows::ImpactRows;
use super::{advance, impact};
use crate::dynamics::{Blocks, Calls};
use crate::joint::MAX_NV;
use crate::model::Body;
use crate::model::manifold::v_range;
use crate::scalar::{BLOCK, Differentiable, Linear, Pack, Scalar, from_each, pairs};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::acceleration::{AccelerationColumns, AccelerationScratch};
use crate::sim::integrators::joint_tangents::{joint_step, stepped_velocity};
use crate::sim::integrators::method::{Pushforward, StepColumns, StepPoint};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// Working memory: the step, the Jacobian of its acceleration, and rows of Jacobians of steps with impacts.
#[derive(Clone, Debug)]
pub(crate) struct Columns<T: Differentiable> {
    found: AccelerationScratch<T>,
    next: State<T>,
    acceleration: AccelerationColumns<T>,
    /// Workspace of impacts at their time, if there can be any.
    rows: Option<Box<ImpactRows<T>>>,
}

impl<T: Differentiable> Pushforward<T> for Columns<T> {
    fn new(simulator: &Simulator, calls: Calls) -> Self {
        Self {
            found: AccelerationScratch::new(simulator, calls),
            next: simulator.neutral_state(),
            acceleration: AccelerationColumns::new(simulator, calls),
            rows: simulator
                .may_bounce()
                .then(|| Box::new(ImpactRows::new(simulator))),
        }
    }

    fn linearize(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        out: &mut StepColumns<'_, T>,
    ) {
        let (found, next, columns) = (&mut self.found, &mut self.next, &mut self.acceleration);
        let at = EvaluationPoint::of_step(simulator, at.state, at.u);
        simulator.accelerate(&at, found);
        if impact::lone(&at, found).is_some() {
            let new = || Box::new(ImpactRows::new(simulator));
            if self.rows.get_or_insert_with(new).linearize(&at, out) {
                return;
            }
        }
        advance(&at, found, next);
        columns.linearize(&at, found);
        velocity_rows(simulator, columns.minus_a(), out);
        curved_rows(&at, &found.a, next, columns.minus_a(), out);
        bristle_rows(simulator, columns.bristles(), out);
    }
}

/// δv⁺ = δv + Δt δa; above it, as if every joint were a vector space, δq⁺ = δq + Δt δv⁺.
fn velocity_rows<T: Scalar>(
    simulator: &Simulator,
    columns: &Blocks<T>,
    out: &mut StepColumns<'_, T>,
) {
    let (nv, dt) = (simulator.model().nv(), simulator.time_step());
    let n = simulator.n_motion();
    let (a, b) = (out.a.as_mut_slice(), out.b.as_mut_slice());
    let mut out_columns = a
        .chunks_exact_mut(n.max(1))
        .chain(b.chunks_exact_mut(n.max(1)));
    for block in columns.blocks() {
        for (k, out) in out_columns.by_ref().take(BLOCK).enumerate() {
            let (dq, dv) = out[..2 * nv].split_at_mut(nv);
            let block = &block[..nv];
            for i in 0..nv {
                dv[i] = -block[i].0[k] * dt;
                dq[i] = dv[i] * dt;
            }
        }
    }
    for k in 0..nv {
        let dv = out.a[(nv + k, nv + k)] + T::one();
        out.a[(nv + k, nv + k)] = dv;
        out.a[(k, nv + k)] = dv * dt;
        out.a[(k, k)] = out.a[(nv + k, k)].mul_add_real(dt, T::one());
    }
}

/// δm⁺ = δm + δ(m⁺ − m)
fn bristle_rows<T: Scalar>(
    simulator: &Simulator,
    columns: &Blocks<T>,
    out: &mut StepColumns<'_, T>,
) {
    let (first, n) = (2 * simulator.model().nv(), simulator.n_motion());
    if first == n {
        return;
    }
    let (a, b) = (out.a.as_mut_slice(), out.b.as_mut_slice());
    let out_columns = a.chunks_exact_mut(n).chain(b.chunks_exact_mut(n));
    let rows = out_columns.map(|out| &mut out[first..]);
    columns.copy_columns_to(rows, |x| x);
    for k in first..n {
        out.a[(k, k)] += T::one();
    }
}

/// The rows of joints whose configuration is not a vector:  (δq⁺, δv⁺) = D (δq, δv, δa).
fn curved_rows<T: Scalar>(
    at: &EvaluationPoint<'_, f64, T>,
    a: &[T],
    next: &State<T>,
    columns: &Blocks<T>,
    out: &mut StepColumns<'_, T>,
) {
    let (model, state, dt) = (at.model(), at.state, at.dt());
    let curved = model.independent().filter(|body| body.joint.nv() > 1);
    for body in curved {
        let w = stepped_velocity(body, state, a, T::constant(dt));
        let (dq, dv) = joint_step(body, state, &w, next, T::constant(dt));
        let nv = body.joint.nv();
        for (first, D) in [(body.v, dq), (model.nv() + body.v, dv)] {
            let by_a = from_each(|k| from_each(|l| D[k].eps[MAX_NV + l] * dt));
            write_rows(columns, body, &by_a, first, out);
            for (k, D) in D.iter().enumerate().take(nv) {
                let (by_q, by_w) = D.eps.split_at(MAX_NV);
                for l in 0..nv {
                    let products = pairs(by_w, &w);
                    let by_v = products.fold(T::zero(), |sum, (&by_w, w)| sum + by_w * w.eps[l]);
                    out.a[(first + k, body.v + l)] += by_q[l];
                    out.a[(first + k, model.nv() + body.v + l)] += by_v;
                }
            }
        }
    }
}

/// D δa over all columns, several at once: the rows of one joint from `first` on, which lie next to each other in every column.
fn write_rows<T: Scalar>(
    columns: &Blocks<T>,
    body: &Body<f64>,
    D: &[[T; MAX_NV]; MAX_NV],
    first: usize,
    out: &mut StepColumns<'_, T>,
) {
    let (n, nv) = (out.a.nrows(), body.joint.nv());
    let (a, b) = (out.a.as_mut_slice(), out.b.as_mut_slice());
    let mut out_columns = a.chunks_exact_mut(n).chain(b.chunks_exact_mut(n));
    let zero = Pack([T::zero(); BLOCK]);
    for block in columns.blocks() {
        let mut sums = [zero; MAX_NV];
        for (sum, D) in pairs(&mut sums, D).take(nv) {
            let rates = &block[v_range(body)];
            for l in 0..nv {
                *sum = rates[l].times_plus(-D[l], *sum);
            }
        }
        for (k, out) in pairs(0..BLOCK, out_columns.by_ref()) {
            for (out, sum) in pairs(&mut out[first..first + nv], &sums) {
                *out = sum.0[k];
            }
        }
    }
}
