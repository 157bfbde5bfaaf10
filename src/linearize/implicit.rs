//! Jacobians of a semi-implicit Euler step: those of its one acceleration, and of each joint's own step.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::Linearization;
use super::contact::ContactColumns;
use crate::autodiff::{
    AccelerationDerivatives, BLOCK, Blocks, Dual, Entries, lifted, moved_by_own_tangents,
};
use crate::joint::MAX_NV;
use crate::model::Body;
use crate::model::manifold::{q_range, v_range};
use crate::scalar::{Lanes, Scalar};
use crate::sim::{Simulator, Solution, State, StepScratch};

/// Working memory of [`linearize`].
#[derive(Clone, Debug)]
pub(super) struct ImplicitScratch {
    acceleration: AccelerationDerivatives,
    forces: JointForces,
    contact: ContactColumns,
}

impl ImplicitScratch {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        Self {
            acceleration: AccelerationDerivatives::new(model, simulator.nu()),
            forces: JointForces::new(simulator),
            contact: ContactColumns::new(simulator),
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
    let (a, solution) = step.solution();
    let columns = minus_acceleration(simulator, (state, u), (a, solution), s);
    velocity_rows(simulator, columns, out);
    curved_rows(simulator, (state, a), next, columns, out);
}

/// −∂a/∂(q, v, u) at the acceleration `a`, with forces of contact where a solver found them.
pub(super) fn minus_acceleration<'s>(
    simulator: &Simulator,
    (state, u): (&State, &[f64]),
    (a, solution): (&[f64], Option<Solution<'_, f64>>),
    s: &'s mut ImplicitScratch,
) -> &'s Blocks {
    let (q, v) = (state.q.as_slice(), state.v.as_slice());
    start_from_forces(simulator, state, u, s);
    let (acceleration, contact) = (&mut s.acceleration, &mut s.contact);
    match solution {
        None => {
            acceleration.balance(simulator.model(), (q, v, a), &[]);
            acceleration.solve();
        }
        Some(solution) => {
            let columns = &mut acceleration.columns;
            let external = contact.press(simulator, (v, a), &solution, columns);
            acceleration.balance(simulator.model(), (q, v, a), external);
            contact.solve(solution, acceleration);
        }
    }
    &acceleration.columns
}

/// −∂τ/∂x, and −∂τ/∂u.
fn start_from_forces(simulator: &Simulator, state: &State, u: &[f64], s: &mut ImplicitScratch) {
    let nv = simulator.model().nv();
    let columns = &mut s.acceleration.columns;
    columns.clear();
    let forces = s.forces.derivatives(simulator, state, u);
    for (k, tau) in forces.iter().enumerate() {
        columns.add(k, k, -tau.eps[0], -tau.eps[1]);
    }
    for (column, &row) in simulator.actuated().iter().enumerate() {
        *columns.at(row, 2 * nv + column) = -forces[row].eps[2];
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

/// Forces along the joints on dual numbers with three directions: all positions, all velocities, all inputs. Each acts on its own
/// coordinate only, so one evaluation gives all their derivatives.
#[derive(Clone, Debug)]
struct JointForces {
    q: Vec<Dual<3>>,
    v: Vec<Dual<3>>,
    u: Vec<Dual<3>>,
    tau: Vec<Dual<3>>,
}

impl JointForces {
    fn new(simulator: &Simulator) -> Self {
        let (model, zeros) = (simulator.model(), |n: usize| vec![Dual::from(0.0); n]);
        Self {
            q: zeros(model.nq()),
            v: zeros(model.nv()),
            u: zeros(simulator.nu()),
            tau: zeros(model.nv()),
        }
    }

    fn derivatives(&mut self, simulator: &Simulator, state: &State, u: &[f64]) -> &[Dual<3>] {
        let seed = |out: &mut [Dual<3>], x: &[f64], direction: usize| {
            let moved = out.iter_mut().zip(x);
            moved.for_each(|(out, &x)| *out = Dual::variable(x, direction));
        };
        seed(&mut self.q, state.q.as_slice(), 0);
        seed(&mut self.v, state.v.as_slice(), 1);
        seed(&mut self.u, u, 2);
        simulator.joint_forces_into(&self.q, &self.v, &self.u, &mut self.tau);
        &self.tau
    }
}
