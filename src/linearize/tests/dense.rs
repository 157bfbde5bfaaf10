//! Jacobians of any step as the step on dual numbers, some directions at a time: what those of the library are compared with.

use nalgebra::DMatrix;

use crate::autodiff::{CHUNK, JacobianScratch, jacobian_into};
use crate::linearize::Linearization;
use crate::linearize::differences::{Point, TangentScratch, tangent_step};
use crate::scalar::Dual;
use crate::sim::{Simulator, State};

/// Working memory of [`linearize`].
#[derive(Clone, Debug)]
pub(super) struct DenseScratch {
    tangent: TangentScratch<Dual<f64, CHUNK>>,
    jacobian: JacobianScratch<CHUNK>,
    zeros: Vec<f64>,
    /// (A, B) side by side.
    out: DMatrix<f64>,
}

impl DenseScratch {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let n = simulator.n_tangent();
        let inputs = n + simulator.nu();
        Self {
            tangent: TangentScratch::new(simulator),
            jacobian: JacobianScratch::new(inputs, n),
            zeros: vec![0.0; inputs],
            out: DMatrix::zeros(n, inputs),
        }
    }
}

/// The Jacobians of the step from `state` to `next`.
pub(super) fn linearize(
    simulator: &Simulator,
    state: &State,
    u: &[f64],
    next: &State,
    s: &mut DenseScratch,
    out: &mut Linearization,
) {
    let tangent = &mut s.tangent;
    let step = |dx: &[_], dy: &mut [_]| {
        tangent_step(simulator, &Point { state, u, next }, dx, tangent, dy);
    };
    jacobian_into(&s.zeros, step, &mut s.jacobian, &mut s.out);
    let n = out.a.nrows();
    out.a.copy_from(&s.out.columns(0, n));
    out.b.copy_from(&s.out.columns(n, u.len()));
}
