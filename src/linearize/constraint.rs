//! What kinematic constraints add to the Jacobians of a step: their rows on dual numbers, some directions at a time.

use nalgebra::DVector;

use super::rows::RowColumns;
use crate::autodiff::{Blocks, CHUNK, Dual};
use crate::constraint::ConstraintRows;
use crate::scalar::Scalar;
use crate::sim::{Simulator, SolverRows, State};

type Local = Dual<CHUNK>;

/// Working memory for constraints.
#[derive(Clone, Debug)]
pub(super) struct ConstraintColumns {
    rows: ConstraintRows<Local>,
    start: Vec<Local>,
    tangent: Vec<Local>,
    q: DVector<Local>,
    v: Vec<Local>,
}

impl ConstraintColumns {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, zeros) = (simulator.model(), |n: usize| vec![Dual::from(0.0); n]);
        let constraints = simulator.constraints();
        Self {
            rows: ConstraintRows::new(constraints.iter().map(|c| c.rows()).sum(), model.nv()),
            start: zeros(model.nq()),
            tangent: zeros(model.nv()),
            q: DVector::zeros(model.nq()),
            v: zeros(model.nv()),
        }
    }

    /// Adds ∂y of y = J a + J̇ v − w, the first rows, and −∂Jᵀ f to the columns, at fixed forces and accelerations.
    pub(super) fn hold(
        &mut self,
        (simulator, state): (&Simulator, &State),
        (a, solved): (&[f64], &SolverRows<f64>),
        rows: &mut RowColumns,
        columns: &mut Blocks,
    ) {
        if simulator.constraints().is_empty() {
            return;
        }
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let start = self.start.iter_mut().zip(&state.q);
        start.for_each(|(out, &x)| *out = Dual::from(x));
        for first in (0..2 * nv).step_by(CHUNK) {
            let moved = |direction: usize, x: f64| match direction.checked_sub(first) {
                Some(own) if own < CHUNK => Dual::variable(x, own),
                _ => Dual::from(x),
            };
            for k in 0..nv {
                self.tangent[k] = moved(k, 0.0);
                self.v[k] = moved(nv + k, state.v[k]);
            }
            model.integrate_into(&self.start, &self.tangent, self.q.as_mut_slice());
            let at = (self.q.as_slice(), &self.v[..]);
            self.rows.evaluate(model, simulator.constraints(), at);
            let directions = first..(2 * nv).min(first + CHUNK);
            for (r, row) in self.rows.rows.iter().enumerate() {
                let jacobian = &self.rows.jacobian[nv * r..nv * (r + 1)];
                let along = jacobian.iter().zip(a);
                let y = along.fold(row.bias, |sum, (&j, &a)| j.mul_add_real(a, sum));
                let y = y - row.wanted(simulator.time_step());
                let force = solved.forces()[r];
                for (direction, own) in directions.clone().zip(0..) {
                    *rows.columns.at(r, direction) += y.eps[own];
                    for (k, j) in jacobian.iter().enumerate() {
                        *columns.at(k, direction) -= j.eps[own] * force;
                    }
                }
            }
        }
    }
}
