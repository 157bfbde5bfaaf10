//! Jacobians of a semi-implicit Euler step: those of its one acceleration, and of each joint's own step.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::Linearization;
use crate::autodiff::{
    AccelerationDerivatives, BLOCK, Blocks, Dual, Entries, lifted, moved_by_own_tangents,
};
use crate::dynamics::passive_forces_into;
use crate::joint::MAX_NV;
use crate::model::manifold::{q_range, v_range};
use crate::model::{Body, Model};
use crate::scalar::{Lanes, Scalar};
use crate::sim::{Simulator, State};

/// Working memory of [`linearize`].
#[derive(Clone, Debug)]
pub(super) struct ImplicitScratch {
    acceleration: AccelerationDerivatives,
    passive: PassiveScratch,
}

impl ImplicitScratch {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        Self {
            acceleration: AccelerationDerivatives::new(model, simulator.nu()),
            passive: PassiveScratch::new(model),
        }
    }
}

/// The Jacobians of the step from `state` to `next` with the acceleration `a`.
pub(super) fn linearize(
    simulator: &Simulator,
    (state, a, next): (&State, &[f64], &State),
    s: &mut ImplicitScratch,
    out: &mut Linearization,
) {
    let columns = minus_acceleration(simulator, (state, a), s);
    velocity_rows(simulator, columns, out);
    configuration_rows(simulator, (state, next), columns, out);
}

/// −∂a/∂(q, v, u) at the acceleration `a`.
pub(super) fn minus_acceleration<'s>(
    simulator: &Simulator,
    (state, a): (&State, &[f64]),
    s: &'s mut ImplicitScratch,
) -> &'s Blocks {
    let motion = (state.q.as_slice(), state.v.as_slice(), a);
    start_from_forces(simulator, state, s);
    s.acceleration.solve(simulator.model(), motion, &[]);
    &s.acceleration.columns
}

/// −∂τ/∂x, and −S.
fn start_from_forces(simulator: &Simulator, state: &State, s: &mut ImplicitScratch) {
    let nv = simulator.model().nv();
    let columns = &mut s.acceleration.columns;
    columns.clear();
    let passive = s.passive.derivatives(simulator.model(), state);
    for (k, tau) in passive.iter().enumerate() {
        columns.add(k, k, -tau.eps[0], -tau.eps[1]);
    }
    for (column, &row) in simulator.actuated().iter().enumerate() {
        *columns.at(row, 2 * nv + column) = -1.0;
    }
}

/// δv⁺ = δv + Δt δa; above it, as if every joint were a vector space, δq⁺ = δq + Δt δv⁺.
fn velocity_rows(simulator: &Simulator, columns: &Blocks, out: &mut Linearization) {
    let (nv, dt) = (simulator.model().nv(), simulator.time_step());
    let (a, b) = (out.a.as_mut_slice(), out.b.as_mut_slice());
    let n = 2 * nv.max(1);
    let out_columns = a.chunks_exact_mut(n).chain(b.chunks_exact_mut(n));
    for (k, out) in out_columns.enumerate() {
        let (dq, dv) = out.split_at_mut(nv);
        for ((dq, dv), minus_a) in dq.iter_mut().zip(dv).zip(columns.column(k)) {
            *dv = -minus_a * dt;
            *dq = *dv * dt;
        }
    }
    for k in 0..nv {
        out.a[(nv + k, nv + k)] += 1.0;
        out.a[(k, k)] += 1.0;
        out.a[(k, nv + k)] += dt;
    }
}

/// q⁺ = q ⊕ Δt v⁺ for joints whose configuration is not a vector:  δq⁺ = D₁ δq + D₂ δv⁺.
fn configuration_rows(
    simulator: &Simulator,
    (state, next): (&State, &State),
    columns: &Blocks,
    out: &mut Linearization,
) {
    let (model, dt) = (simulator.model(), simulator.time_step());
    let curved = model.independent().filter(|body| body.joint.nv() > 1);
    for body in curved {
        let D = joint_step(body, state, next, dt);
        for (k, D) in D.iter().enumerate().take(body.joint.nv()) {
            let (D_1, D_2) = D.eps.split_at(MAX_NV);
            write_row(columns, body, D_2, dt, body.v + k, out);
            for l in 0..body.joint.nv() {
                out.a[(body.v + k, body.v + l)] += D_1[l];
                out.a[(body.v + k, model.nv() + body.v + l)] += D_2[l];
            }
        }
    }
}

/// D₂ Δt δa over all columns, several at once.
fn write_row(
    columns: &Blocks,
    body: &Body<f64>,
    D_2: &[f64],
    dt: f64,
    row: usize,
    out: &mut Linearization,
) {
    let n = out.a.nrows();
    let (a, b) = (out.a.as_mut_slice(), out.b.as_mut_slice());
    let rest = row.min(b.len());
    let mut entries = a[row..]
        .iter_mut()
        .step_by(n)
        .chain(b[rest..].iter_mut().step_by(n));
    for block in columns.blocks() {
        let rates = block[v_range(body)].iter().zip(D_2);
        let zero = Lanes([0.0; BLOCK]);
        let sum = rates.fold(zero, |sum, (&minus_a, &D)| {
            minus_a.mul_add_real(-D * dt, sum)
        });
        for (x, entry) in sum.0.into_iter().zip(entries.by_ref()) {
            *entry = x;
        }
    }
}

/// Directions of a joint's own step: its position, then its velocity.
const JOINT_DIRECTIONS: usize = 2 * MAX_NV;

/// δq⁺ of one joint with its derivatives in δq and δv⁺.
fn joint_step(
    body: &Body<f64>,
    state: &State,
    next: &State,
    dt: f64,
) -> [Dual<JOINT_DIRECTIONS>; MAX_NV] {
    let (joint, nq, nv) = (body.joint, body.joint.nq(), body.joint.nv());
    let start = moved_by_own_tangents(joint, &state.q.as_slice()[q_range(body)]);
    let expected = lifted(&next.q.as_slice()[q_range(body)]);
    let v = &next.v.as_slice()[v_range(body)];
    let (mut step, mut end) = (lifted(&[]), start);
    for k in 0..nv {
        step[k] = Dual::variable(v[k], MAX_NV + k) * dt;
    }
    joint.integrate(&start[..nq], &step[..nv], &mut end[..nq]);
    let mut out = [Dual::from(0.0); MAX_NV];
    joint.difference(&expected[..nq], &end[..nq], &mut out[..nv]);
    out
}

/// Springs and damping on dual numbers with two directions: all positions, all velocities. Each acts on its own coordinate only, so
/// one evaluation gives all their derivatives.
#[derive(Clone, Debug)]
struct PassiveScratch {
    q: Vec<Dual<2>>,
    v: Vec<Dual<2>>,
    tau: Vec<Dual<2>>,
}

impl PassiveScratch {
    fn new(model: &Model) -> Self {
        let zeros = |n: usize| vec![Dual::from(0.0); n];
        Self {
            q: zeros(model.nq()),
            v: zeros(model.nv()),
            tau: zeros(model.nv()),
        }
    }

    fn derivatives(&mut self, model: &Model, state: &State) -> &[Dual<2>] {
        let seed = |out: &mut [Dual<2>], x: &[f64], direction: usize| {
            let moved = out.iter_mut().zip(x);
            moved.for_each(|(out, &x)| *out = Dual::variable(x, direction));
        };
        seed(&mut self.q, state.q.as_slice(), 0);
        seed(&mut self.v, state.v.as_slice(), 1);
        passive_forces_into(model, &self.q, &self.v, &mut self.tau);
        &self.tau
    }
}
