//! Jacobians of a semi-implicit Euler step by the implicit function theorem.
//!
//! The acceleration of the step solves  ID(q, v, a) = τ(q, v, u). So  M δa = ∂τ/∂x δx + S δu − ∂ID/∂x δx: the derivatives of inverse
//! dynamics and one factorisation of M, which is among them, replace a sweep through forward dynamics for each direction.

use nalgebra::DMatrix;

use super::Linearization;
use crate::autodiff::Dual;
use crate::autodiff::dynamics::{
    InverseDynamicsDerivatives, InverseDynamicsDerivativesScratch,
    inverse_dynamics_derivatives_into,
};
use crate::dynamics::{MassMatrixFactor, SolveScratch, passive_forces_into};
use crate::joint::MAX_NV;
use crate::model::manifold::{q_range, v_range};
use crate::model::{Body, Model};
use crate::sim::{Simulator, State};

/// Working memory of [`linearize`].
#[derive(Clone, Debug)]
pub(super) struct ImplicitScratch {
    inverse: InverseDynamicsDerivativesScratch,
    /// Derivatives of ID, then of the acceleration.
    derivatives: InverseDynamicsDerivatives,
    /// Derivatives of the acceleration in the input.
    by_input: DMatrix<f64>,
    factor: MassMatrixFactor<f64>,
    solve: SolveScratch,
    passive: PassiveScratch,
}

impl ImplicitScratch {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        Self {
            inverse: InverseDynamicsDerivativesScratch::new(model),
            derivatives: InverseDynamicsDerivatives::zeros(model),
            by_input: DMatrix::zeros(nv, simulator.nu()),
            factor: MassMatrixFactor::new(model, &DMatrix::identity(nv, nv)),
            solve: SolveScratch::new(model),
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
    let (model, q, v) = (simulator.model(), state.q.as_slice(), state.v.as_slice());
    inverse_dynamics_derivatives_into(model, q, v, a, &[], &mut s.inverse, &mut s.derivatives);
    right_sides(simulator, state, s);
    s.factor.refactor(&s.derivatives.da);
    for columns in [
        &mut s.derivatives.dq,
        &mut s.derivatives.dv,
        &mut s.by_input,
    ] {
        s.factor.solve_columns(&mut s.solve, columns);
    }
    velocity_rows(simulator, s, out);
    configuration_rows(simulator, state, next, out);
}

/// ∂τ/∂x − ∂ID/∂x, and S.
fn right_sides(simulator: &Simulator, state: &State, s: &mut ImplicitScratch) {
    let passive = s.passive.derivatives(simulator.model(), state);
    for (m, direction) in [(&mut s.derivatives.dq, 0), (&mut s.derivatives.dv, 1)] {
        m.as_mut_slice().iter_mut().for_each(|x| *x = -*x);
        let diagonal = m.as_mut_slice().iter_mut().step_by(passive.len() + 1);
        for (x, tau) in diagonal.zip(passive) {
            *x += tau.eps[direction];
        }
    }
    s.by_input.as_mut_slice().fill(0.0);
    for (column, &row) in simulator.actuated().iter().enumerate() {
        s.by_input[(row, column)] = 1.0;
    }
}

/// δv⁺ = δv + Δt δa; below, as if every joint were a vector space, δq⁺ = δq + Δt δv⁺.
fn velocity_rows(simulator: &Simulator, s: &ImplicitScratch, out: &mut Linearization) {
    let (nv, dt) = (simulator.model().nv(), simulator.time_step());
    let (a, b) = (out.a.as_mut_slice(), out.b.as_mut_slice());
    let (by_q, by_v) = a.split_at_mut(2 * nv * nv);
    for (out, accelerations) in [
        (by_q, &s.derivatives.dq),
        (by_v, &s.derivatives.dv),
        (b, &s.by_input),
    ] {
        let columns = out.chunks_exact_mut(2 * nv.max(1));
        for (out, a) in columns.zip(accelerations.as_slice().chunks_exact(nv.max(1))) {
            let (dq, dv) = out.split_at_mut(nv);
            for ((dq, dv), &a) in dq.iter_mut().zip(dv).zip(a) {
                *dv = a * dt;
                *dq = *dv * dt;
            }
        }
    }
    for k in 0..nv {
        out.a[(nv + k, nv + k)] += 1.0;
        out.a[(k, k)] += 1.0;
        out.a[(k, nv + k)] += dt;
    }
}

/// q⁺ = q ⊕ Δt v⁺ for joints whose configuration is not a vector.
fn configuration_rows(simulator: &Simulator, state: &State, next: &State, out: &mut Linearization) {
    let nv = simulator.model().nv();
    let curved = simulator
        .model()
        .independent()
        .filter(|body| body.joint.nv() > 1);
    for body in curved {
        let rows = joint_step(body, state, next, simulator.time_step());
        let (first, n) = (body.v, body.joint.nv());
        for m in [&mut out.a, &mut out.b] {
            for mut column in m.column_iter_mut() {
                for k in 0..n {
                    let by_v = (0..n).map(|l| rows[k].eps[MAX_NV + l] * column[nv + first + l]);
                    column[first + k] = by_v.sum();
                }
            }
        }
        for k in 0..n {
            for l in 0..n {
                out.a[(first + k, first + l)] += rows[k].eps[l];
            }
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
    let lift = |x: &[f64]| {
        let mut out = [Dual::from(0.0); MAX_NV + 1];
        out.iter_mut().zip(x).for_each(|(out, &x)| *out = x.into());
        out
    };
    let start = lift(&state.q.as_slice()[q_range(body)]);
    let end = lift(&next.q.as_slice()[q_range(body)]);
    let v = &next.v.as_slice()[v_range(body)];
    let mut moved = start;
    let mut out = [Dual::from(0.0); MAX_NV];
    let (mut dq, mut step) = (out, out);
    for k in 0..nv {
        dq[k] = Dual::variable(0.0, k);
        step[k] = Dual::variable(v[k], MAX_NV + k) * dt;
    }
    joint.integrate(&start[..nq], &dq[..nv], &mut moved[..nq]);
    let from = moved;
    joint.integrate(&from[..nq], &step[..nv], &mut moved[..nq]);
    joint.difference(&end[..nq], &moved[..nq], &mut out[..nv]);
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
