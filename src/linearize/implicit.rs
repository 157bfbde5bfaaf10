//! Jacobians of a step of Euler, semi-implicit or implicit in velocity: those of its one acceleration, and of each joint's own step.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::Linearization;
use super::constraint::ConstraintColumns;
use super::contact::{ContactColumns, Place};
use super::joints::JointColumns;
use super::rows::RowColumns;
use crate::autodiff::{
    AccelerationDerivatives, BLOCK, Blocks, Dual, lifted, moved_by_own_tangents,
};
use crate::joint::MAX_NV;
use crate::model::Body;
use crate::model::manifold::{q_range, v_range};
use crate::scalar::{Lanes, Scalar};
use crate::sim::{Integrator, ROWS, Simulator, Solution, State, StepScratch};

/// Working memory of [`linearize`].
#[derive(Clone, Debug)]
pub(super) struct ImplicitScratch {
    acceleration: AccelerationDerivatives,
    joints: JointColumns,
    constraints: ConstraintColumns,
    contact: ContactColumns,
    rows: RowColumns,
}

impl ImplicitScratch {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, further) = (simulator.model(), simulator.n_contact() + simulator.nu());
        let points = simulator.contacts().map_or(0, |c| c.points().len());
        let held: usize = simulator.constraints().iter().map(|c| c.rows()).sum();
        let rows = held + model.nv() + ROWS * points;
        let columns = 2 * model.nv() + further;
        Self {
            acceleration: AccelerationDerivatives::new(model, further),
            joints: JointColumns::new(simulator),
            constraints: ConstraintColumns::new(simulator),
            contact: ContactColumns::new(simulator),
            rows: RowColumns::new(model, rows, columns),
        }
    }
}

/// The Jacobians of the step from `state` to `next`, which has just been taken.
pub(super) fn linearize(
    simulator: &Simulator,
    (state, u): (&State, &[f64]),
    (step, next): (&mut StepScratch<f64>, &State),
    s: &mut ImplicitScratch,
    out: &mut Linearization,
) {
    let implicit = simulator.integrator() == Integrator::ImplicitVelocity;
    minus_acceleration(simulator, (state, u), (step.solution(), implicit), s);
    let columns = &s.acceleration.columns;
    velocity_rows(simulator, columns, out);
    curved_rows(simulator, (state, step.solution().a), next, columns, out);
    bristle_rows(simulator, &s.contact.bristles, out);
}

/// −∂a/∂(q, v, m, u) at the acceleration that has been found, for a step that may be implicit in velocity.
pub(super) fn minus_acceleration<'s>(
    simulator: &Simulator,
    (state, u): (&State, &[f64]),
    (solution, implicit): (Solution<'_, f64>, bool),
    s: &'s mut ImplicitScratch,
) -> &'s Blocks {
    let (model, a) = (simulator.model(), solution.a);
    let (q, v) = (state.q.as_slice(), state.v.as_slice());
    let (acceleration, rows) = (&mut s.acceleration, &mut s.rows);
    let columns = &mut acceleration.columns;
    s.joints
        .start(simulator, (state, u), implicit.then_some(a), columns);
    s.contact.clear();
    if let Some(constrained) = &solution.constrained {
        let solved = constrained.rows();
        let held = simulator.constraints().iter().map(|c| c.rows()).sum();
        let width = simulator.n_tangent() + simulator.nu();
        rows.start(model, (v, a), (solved, held), width);
        let columns = &mut acceleration.columns;
        s.constraints
            .hold((simulator, state), (a, solved), rows, columns);
        s.joints.stop(simulator, (constrained, held), rows);
    }
    if let Some(contacts) = simulator.contacts() {
        let place = Place {
            simulator,
            state,
            contacts,
            at: solution.contact,
        };
        let columns = &mut acceleration.columns;
        match &solution.constrained {
            Some(constrained) if implicit || !contacts.are_soft() => {
                let resistance = &s.joints.resistance;
                s.contact
                    .hold(&place, (constrained, resistance), rows, columns);
            }
            _ => s.contact.press(&place, columns),
        }
    }
    acceleration.balance(model, (q, v, a), &s.contact.external);
    match solution.constrained {
        None => acceleration.solve(),
        Some(constrained) => {
            rows.solve(constrained, &mut acceleration.columns);
            s.contact.settle(rows);
        }
    }
    &acceleration.columns
}

/// δv⁺ = δv + Δt δa; above it, as if every joint were a vector space, δq⁺ = δq + Δt δv⁺.
fn velocity_rows(simulator: &Simulator, columns: &Blocks, out: &mut Linearization) {
    let (nv, dt) = (simulator.model().nv(), simulator.time_step());
    let n = simulator.n_tangent();
    let (a, b) = (out.a.as_mut_slice(), out.b.as_mut_slice());
    let out_columns = a
        .chunks_exact_mut(n.max(1))
        .chain(b.chunks_exact_mut(n.max(1)));
    for (k, out) in out_columns.enumerate() {
        let (dq, dv) = out[..2 * nv].split_at_mut(nv);
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

/// δm⁺ = δm + δ(m⁺ − m)
fn bristle_rows(simulator: &Simulator, columns: &Blocks, out: &mut Linearization) {
    let (first, n) = (2 * simulator.model().nv(), simulator.n_tangent());
    if first == n {
        return;
    }
    let (a, b) = (out.a.as_mut_slice(), out.b.as_mut_slice());
    let out_columns = a.chunks_exact_mut(n).chain(b.chunks_exact_mut(n));
    for (k, out) in out_columns.enumerate() {
        let rows = out[first..].iter_mut().zip(columns.column(k));
        rows.for_each(|(out, x)| *out = x);
    }
    for k in first..n {
        out.a[(k, k)] += 1.0;
    }
}

/// The rows of joints whose configuration is not a vector:  (δq⁺, δv⁺) = D (δq, δv, δa).
fn curved_rows(
    simulator: &Simulator,
    (state, a): (&State, &[f64]),
    next: &State,
    columns: &Blocks,
    out: &mut Linearization,
) {
    let (model, dt) = (simulator.model(), simulator.time_step());
    let curved = model.independent().filter(|body| body.joint.nv() > 1);
    for body in curved {
        let (dq, dv) = joint_step(body, (state, a), next, dt);
        let nv = body.joint.nv();
        for (first, D) in [(body.v, dq), (model.nv() + body.v, dv)] {
            for (k, D) in D.iter().enumerate().take(nv) {
                let (by_state, by_a) = D.eps.split_at(2 * MAX_NV);
                write_row(columns, body, by_a, first + k, out);
                for l in 0..nv {
                    out.a[(first + k, body.v + l)] += by_state[l];
                    out.a[(first + k, model.nv() + body.v + l)] += by_state[MAX_NV + l];
                }
            }
        }
    }
}

/// D δa over all columns, several at once.
fn write_row(columns: &Blocks, body: &Body<f64>, D: &[f64], row: usize, out: &mut Linearization) {
    let n = out.a.nrows();
    let (a, b) = (out.a.as_mut_slice(), out.b.as_mut_slice());
    let rest = row.min(b.len());
    let mut entries = a[row..]
        .iter_mut()
        .step_by(n)
        .chain(b[rest..].iter_mut().step_by(n));
    for block in columns.blocks() {
        let rates = block[v_range(body)].iter().zip(D);
        let zero = Lanes([0.0; BLOCK]);
        let sum = rates.fold(zero, |sum, (&minus_a, &D)| minus_a.mul_add_real(-D, sum));
        for (x, entry) in sum.0.into_iter().zip(entries.by_ref()) {
            *entry = x;
        }
    }
}

/// Directions of a joint's own step: its position, its velocity, its acceleration.
const JOINT_DIRECTIONS: usize = 3 * MAX_NV;

/// What a joint's own step gives, along its coordinates.
type JointStep = [Dual<JOINT_DIRECTIONS>; MAX_NV];

/// δq⁺ and δv⁺ of one joint with their derivatives in δq, δv and δa.
fn joint_step(
    body: &Body<f64>,
    (state, a): (&State, &[f64]),
    next: &State,
    dt: f64,
) -> (JointStep, JointStep) {
    let (joint, nq, nv) = (body.joint, body.joint.nq(), body.joint.nv());
    let start = moved_by_own_tangents(joint, &state.q.as_slice()[q_range(body)]);
    let expected = lifted(&next.q.as_slice()[q_range(body)]);
    let zero: JointStep = [Dual::from(0.0); MAX_NV];
    let (mut v, mut rate) = (zero, zero);
    for k in 0..nv {
        v[k] = Dual::variable(state.v[body.v + k], MAX_NV + k);
        rate[k] = Dual::variable(a[body.v + k], 2 * MAX_NV + k);
    }
    let (mut end, mut dq, mut dv) = (start, zero, zero);
    let now = (&start[..nq], &v[..nv], &rate[..nv]);
    joint.advance(now, dt, (&mut end[..nq], &mut dv[..nv]));
    joint.difference(&expected[..nq], &end[..nq], &mut dq[..nv]);
    (dq, dv)
}
