//! The functions that are measured, each with its working memory made, ready to be called on one point after the other.
//!
//! Results go through `black_box`, so that they count as used.

#![expect(non_snake_case, reason = "M is the mass matrix, see the conventions")]

use std::hint::black_box;

use dualbody::autodiff::{CHUNK, Dual, JacobianScratch, jacobian_into};
use dualbody::dynamics::{
    AbaScratch, CrbaScratch, ForwardDynamicsDerivatives, ForwardDynamicsDerivativesScratch,
    InverseDynamicsDerivatives, InverseDynamicsDerivativesScratch, Kinematics, MassMatrixFactor,
    RneaScratch, bias_forces_into, forward_dynamics_derivatives_into, forward_dynamics_into,
    forward_kinematics_into, frame_jacobian_into, inverse_dynamics_derivatives_into,
    inverse_dynamics_into, mass_matrix, mass_matrix_into,
};
use dualbody::linearize::LinearizeScratch;
use dualbody::model::{FrameId, Model};
use dualbody::sim::{SensorScratch, Sensors, StepScratch};
use dualbody::spatial::Representation;
use dualbody::{Linearization, Over, Simulator, State};
use nalgebra::DMatrix;

use super::points::Point;

pub(crate) fn rnea<T: Over<f64>>(simulator: &Simulator) -> impl FnMut(&Point<T>) {
    let model = simulator.model();
    let (mut scratch, mut tau) = (RneaScratch::new(model), vec![T::zero(); model.nv()]);
    move |p| {
        let (q, v) = coordinates(p);
        inverse_dynamics_into(model, q, v, &p.a, &[], &mut scratch, black_box(&mut tau));
    }
}

pub(crate) fn bias<T: Over<f64>>(simulator: &Simulator) -> impl FnMut(&Point<T>) {
    let model = simulator.model();
    let (mut scratch, mut h) = (RneaScratch::new(model), vec![T::zero(); model.nv()]);
    move |p| {
        let (q, v) = coordinates(p);
        bias_forces_into(model, q, v, &[], &mut scratch, black_box(&mut h));
    }
}

pub(crate) fn crba<T: Over<f64>>(simulator: &Simulator) -> impl FnMut(&Point<T>) {
    let model = simulator.model();
    let (mut scratch, mut M) = (CrbaScratch::new(model), square(model));
    move |p| mass_matrix_into(model, coordinates(p).0, &mut scratch, black_box(&mut M))
}

pub(crate) fn aba<T: Over<f64>>(simulator: &Simulator) -> impl FnMut(&Point<T>) {
    let model = simulator.model();
    let (mut scratch, mut a) = (AbaScratch::new(model), vec![T::zero(); model.nv()]);
    move |p| {
        let (q, v) = coordinates(p);
        forward_dynamics_into(model, q, v, &p.tau, &[], &mut scratch, black_box(&mut a));
    }
}

pub(crate) fn kinematics<T: Over<f64>>(simulator: &Simulator) -> impl FnMut(&Point<T>) {
    let model = simulator.model();
    let mut out = Kinematics::new(model);
    move |p| {
        let (q, v) = coordinates(p);
        forward_kinematics_into(model, q, v, black_box(&mut out));
    }
}

/// Of the last frame, which is on the last link, in mixed representation.
pub(crate) fn jacobian<T: Over<f64>>(simulator: &Simulator) -> impl FnMut(&Point<T>) {
    let model = simulator.model();
    let mut out = DMatrix::zeros(6, model.nv());
    let frame = last_frame(model);
    move |p| {
        let q = coordinates(p).0;
        frame_jacobian_into(model, q, frame, Representation::Mixed, black_box(&mut out));
    }
}

/// Factorises a mass matrix and solves for one right-hand side.
pub(crate) fn factor_and_solve(simulator: &Simulator) -> impl FnMut(&Point<f64>) {
    let model = simulator.model();
    let M = mass_matrix(model, model.neutral().as_slice());
    let (mut factor, mut x) = (MassMatrixFactor::new(model, &M), vec![0.0; model.nv()]);
    move |p| {
        factor.refactor(black_box(&M));
        x.copy_from_slice(&p.tau);
        factor.solve(black_box(&mut x));
    }
}

pub(crate) fn step<T: Over<f64>>(simulator: &Simulator) -> impl FnMut(&Point<T>) {
    let mut scratch = StepScratch::new(simulator);
    let mut next = State::neutral(simulator.model());
    move |p| simulator.step_into(&p.state, &p.u, &mut scratch, black_box(&mut next))
}

/// A step with the readings of some sensors: what these cost is the difference to [`step`].
pub(crate) fn step_and_read(simulator: &Simulator, sensors: Sensors) -> impl FnMut(&Point<f64>) {
    let (mut memory, mut scratch) = (StepScratch::new(simulator), SensorScratch::new(simulator));
    let (mut next, mut y) = (State::neutral(simulator.model()), vec![0.0; sensors.len()]);
    move |p| {
        simulator.step_into(&p.state, &p.u, &mut memory, black_box(&mut next));
        let y = black_box(&mut y);
        sensors.read_step_into(simulator, &p.state, &p.u, &memory, &mut scratch, y);
    }
}

pub(crate) fn inverse_derivatives(simulator: &Simulator) -> impl FnMut(&Point<f64>) {
    let model = simulator.model();
    let mut scratch = InverseDynamicsDerivativesScratch::new(model);
    let mut out = InverseDynamicsDerivatives::zeros(model);
    move |p| {
        let ((q, v), out) = (coordinates(p), black_box(&mut out));
        inverse_dynamics_derivatives_into(model, q, v, &p.a, &[], &mut scratch, out);
    }
}

/// The Jacobian of inverse dynamics by dual numbers through the whole tree, `CHUNK` directions at a time: the baseline that the derivatives
/// along the tree are to be compared with. In q as numbers, so for robots without quaternions.
pub(crate) fn inverse_derivatives_dense(simulator: &Simulator) -> impl FnMut(&Point<f64>) {
    type Chunk = Dual<f64, CHUNK>;
    let model = simulator.model();
    let (nq, nv) = (model.nq(), model.nv());
    let mut rnea = RneaScratch::<Chunk>::new(model);
    let mut chunks = JacobianScratch::<CHUNK>::new(nq + 2 * nv, nv);
    let (mut x, mut out) = (vec![0.0; nq + 2 * nv], DMatrix::zeros(nv, nq + 2 * nv));
    move |p| {
        let (q, v) = coordinates(p);
        x[..nq].copy_from_slice(q);
        x[nq..nq + nv].copy_from_slice(v);
        x[nq + nv..].copy_from_slice(&p.a);
        let evaluate = |x: &[Chunk], tau: &mut [Chunk]| {
            let (q, rest) = x.split_at(nq);
            let (v, a) = rest.split_at(nv);
            inverse_dynamics_into(model, q, v, a, &[], &mut rnea, tau);
        };
        jacobian_into(&x, evaluate, &mut chunks, black_box(&mut out));
    }
}

pub(crate) fn forward_derivatives(simulator: &Simulator) -> impl FnMut(&Point<f64>) {
    let model = simulator.model();
    let mut scratch = ForwardDynamicsDerivativesScratch::new(model);
    let mut out = ForwardDynamicsDerivatives::zeros(model);
    move |p| {
        let ((q, v), out) = (coordinates(p), black_box(&mut out));
        forward_dynamics_derivatives_into(model, q, v, &p.tau, &[], &mut scratch, out);
    }
}

pub(crate) fn linearize(simulator: &Simulator) -> impl FnMut(&Point<f64>) {
    let mut scratch = LinearizeScratch::new(simulator);
    let mut out = Linearization::zeros(simulator);
    move |p| simulator.linearize_into(&p.state, &p.u, &mut scratch, black_box(&mut out))
}

fn coordinates<T: Over<f64>>(point: &Point<T>) -> (&[T], &[T]) {
    (point.state.q.as_slice(), point.state.v.as_slice())
}

fn square<T: Over<f64>>(model: &Model) -> DMatrix<T> {
    DMatrix::zeros(model.nv(), model.nv())
}

fn last_frame(model: &Model) -> FrameId {
    let name = model.frame_names().last().copied();
    name.and_then(|name| model.frame(name))
        .expect("a robot has links")
}
