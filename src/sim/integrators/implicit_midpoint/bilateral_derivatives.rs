//! Derivatives of the momentum of a robot that constraints hold, and of the velocity across them, in the configuration.
//!
//! Those of the balance of forces, ID(a) − τ − Jᵀ f, and of its rows, J a + φ / T², are known at any acceleration a and forces f of rows. At rest, those at
//! a = v and f = −λ less those at a = 0 and f = 0 are derivatives of  M v + Jᵀ λ  and of  J v.

use nalgebra::DMatrix;

use crate::dynamics::{Blocks, Calls};
use crate::scalar::{BLOCK, Differentiable, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::AccelerationScratch;
use crate::sim::integrators::balance::BalanceColumns;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::{Acting, AllDerivatives, DerivativePoint, JacobianMemory};

/// Working memory, with ∂(J v)/∂q.
#[derive(Clone, Debug)]
pub(super) struct BilateralDerivatives<T: Differentiable> {
    pub(super) rate_by_q: DMatrix<T>,
    columns: BalanceColumns<T>,
    terms: AllDerivatives<T>,
    memory: JacobianMemory<T>,
    found: AccelerationScratch<T>,
    /// A configuration, at rest.
    state: State<T>,
    u: Vec<T>,
    rest: Vec<T>,
    /// Forces of rows, and none.
    forces: [Vec<T>; 2],
}

impl<T: Differentiable> BilateralDerivatives<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (nv, rows) = (simulator.model().nv(), simulator.bilateral_rows());
        let zeros = |n: usize| vec![T::zero(); n];
        Self {
            rate_by_q: DMatrix::zeros(rows, nv),
            columns: BalanceColumns::new(simulator, rows, Calls::Many),
            terms: AllDerivatives::new(simulator),
            memory: JacobianMemory::new(simulator),
            found: AccelerationScratch::new(simulator, Calls::Many),
            state: simulator.neutral_state(),
            u: zeros(simulator.nu()),
            rest: zeros(nv),
            forces: [zeros(rows), zeros(rows)],
        }
    }

    /// Finds ∂(J v)/∂q, and puts ∂(M v + Jᵀ λ)/∂q into `momentum_by_q`.
    ///
    /// * `jacobian` – J, row by row
    /// * `impulses` – λ of each row
    pub(super) fn find(
        &mut self,
        simulator: &Simulator,
        at: &State<T>,
        jacobian: &[T],
        impulses: impl Iterator<Item = T>,
        momentum_by_q: &mut DMatrix<T>,
    ) {
        self.state.q.copy_from(&at.q);
        let forces = self.forces[0].iter_mut().zip(impulses);
        forces.for_each(|(own, impulse)| *own = -impulse);
        let at_rest = EvaluationPoint::instant(simulator, &self.state, &self.u);
        simulator.apply_terms(&at_rest, &mut self.found);
        momentum_by_q.fill(T::zero());
        self.rate_by_q.fill(T::zero());
        let accelerations = [at.v.as_slice(), &self.rest];
        for ((a, forces), sign) in accelerations.iter().zip(&self.forces).zip([1.0, -1.0]) {
            let point = DerivativePoint {
                point: &at_rest,
                a,
                acting: Acting::Start(forces),
            };
            let (columns, terms) = (&mut self.columns, &mut self.terms);
            let found = &self.found.terms;
            columns.find(&point, Some(jacobian), found, terms, &mut self.memory);
            let (of_forces, of_rows) = (&columns.forces.acceleration.columns, &columns.rows);
            add_scaled(of_forces, sign, momentum_by_q);
            add_scaled(&of_rows.columns, sign, &mut self.rate_by_q);
        }
    }
}

/// Adds the first of some columns.
fn add_scaled<T: Scalar>(columns: &Blocks<T>, sign: f64, out: &mut DMatrix<T>) {
    let n = out.nrows().max(1);
    let mut outputs = out.as_mut_slice().chunks_exact_mut(n);
    for block in columns.blocks() {
        for (k, out) in (0..BLOCK).zip(outputs.by_ref()) {
            let entries = out.iter_mut().zip(block);
            entries.for_each(|(out, x)| *out += x.0[k] * sign);
        }
    }
}
