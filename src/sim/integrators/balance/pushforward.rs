//! Derivatives of the balance and of the rows at fixed accelerations and forces of rows, column after column.

use crate::dynamics::{At, Calls};
use crate::scalar::Differentiable;
use crate::sim::simulator::Simulator;
use crate::sim::terms::{
    AllSlopes, ForceColumns, JacobianMemory, JacobianSink, RowColumns, SlopePoint, TermSlopes,
    Terms,
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
    /// * `jacobian` – J of the rows of the point, row after row; `None` where there are none
    /// * `found` – the terms as they have been evaluated
    pub(crate) fn find(
        &mut self,
        point: &SlopePoint<'_, T>,
        jacobian: Option<&[T]>,
        found: &Terms<T>,
        terms: &mut AllSlopes<T>,
        memory: &mut JacobianMemory<T>,
    ) {
        let (at, a, Self { forces, rows }) = (point.moment, point.a, self);
        let (model, q, v) = (at.model(), at.q(), at.v());
        forces.clear();
        if let Some(jacobian) = jacobian {
            let width = at.simulator.n_tangent() + at.simulator.nu();
            rows.start(model, v, a, jacobian, width);
        }
        let mut sink = JacobianSink::new(point, forces, rows, memory);
        terms.emit_forces(point, found, &mut sink);
        if jacobian.is_some() {
            terms.emit_rows(point, found, &mut sink);
        }
        let ForceColumns {
            acceleration,
            bodies,
            ..
        } = forces;
        acceleration.balance(model, &At { q, v, a }, bodies);
    }
}
