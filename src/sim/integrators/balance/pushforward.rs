//! Derivatives of the balance and of the rows at fixed accelerations and forces of rows, column by column.

use crate::dynamics::{At, Calls};
use crate::scalar::Differentiable;
use crate::sim::simulator::Simulator;
use crate::sim::terms::{
    AllDerivatives, DerivativePoint, ForceColumns, JacobianMemory, JacobianSink, RowColumns,
    TermDerivatives, Terms,
};

/// ∂(ID − τ − Jᵀ f) and ∂y.
#[derive(Clone, Debug)]
pub(crate) struct BalanceColumns<T: Differentiable> {
    pub(crate) forces: ForceColumns<T>,
    pub(crate) rows: RowColumns<T>,
}

impl<T: Differentiable> BalanceColumns<T> {
    /// Memory for a simulator, with so many rows at most.
    pub(crate) fn new(simulator: &Simulator, rows: usize, calls: Calls) -> Self {
        let columns = simulator.n_tangent() + simulator.nu();
        Self {
            forces: ForceColumns::new(simulator, calls),
            rows: RowColumns::new(simulator.model(), rows, columns),
        }
    }

    /// Finds them.
    ///
    /// * `jacobian` – J of the rows of the point, row by row; `None` where there are none
    /// * `found` – the terms as they have been evaluated
    pub(crate) fn find(
        &mut self,
        at: &DerivativePoint<'_, T>,
        jacobian: Option<&[T]>,
        found: &Terms<T>,
        terms: &mut AllDerivatives<T>,
        memory: &mut JacobianMemory<T>,
    ) {
        let (point, a, Self { forces, rows }) = (at.point, at.a, self);
        let (model, q, v) = (point.model(), point.q(), point.v());
        forces.clear();
        if let Some(jacobian) = jacobian {
            let width = point.simulator.n_tangent() + point.simulator.nu();
            rows.start(model, v, a, jacobian, width);
        }
        let mut sink = JacobianSink::new(at, forces, rows, memory);
        terms.emit_forces(at, found, &mut sink);
        if jacobian.is_some() {
            terms.emit_rows(at, found, &mut sink);
        }
        let ForceColumns {
            acceleration,
            bodies,
            ..
        } = forces;
        acceleration.balance(model, &At { q, v, a }, bodies);
    }
}
