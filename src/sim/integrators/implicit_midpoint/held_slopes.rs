//! Derivatives of what constraints add to a momentum, and of the velocity across them, in the configuration.

use nalgebra::DMatrix;

use crate::autodiff::TangentPoint;
use crate::constraint::ConstraintRows;
use crate::scalar::{CHUNK, Differentiable, Dual};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// A number with derivatives in some directions of the configuration.
type Moved<T> = Dual<T, CHUNK>;

/// Working memory, with ∂(J v)/∂q.
#[derive(Clone, Debug)]
pub(super) struct HeldSlopes<T: Differentiable> {
    pub(super) rate_by_q: DMatrix<T>,
    point: TangentPoint<Moved<T>>,
    v: Vec<Moved<T>>,
    rows: ConstraintRows<Moved<T>>,
}

impl<T: Differentiable> HeldSlopes<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, n) = (simulator.model(), simulator.held_rows());
        Self {
            rate_by_q: DMatrix::zeros(n, model.nv()),
            point: TangentPoint::new(model.nq(), model.nv(), 0),
            v: vec![Moved::from(0.0); model.nv()],
            rows: ConstraintRows::new(n, model.nv()),
        }
    }

    /// Finds ∂(J v)/∂q, and adds ∂(Jᵀ λ)/∂q to `out`.
    ///
    /// * `impulses` – λ of each row
    pub(super) fn find(
        &mut self,
        simulator: &Simulator,
        at: &State<T>,
        impulses: impl Iterator<Item = T> + Clone,
        out: &mut DMatrix<T>,
    ) {
        let (model, constraints) = (simulator.model(), simulator.constraints());
        if constraints.is_empty() {
            return;
        }
        let Self {
            rate_by_q,
            point,
            v,
            rows,
        } = self;
        let zeros = std::iter::repeat_n(Moved::from(0.0), model.nv());
        point.set_to(at.q.iter().map(|&x| Moved::constant_of(x)), zeros);
        let lifted = v.iter_mut().zip(&at.v);
        lifted.for_each(|(own, &v)| *own = Moved::constant_of(v));
        point.each(
            0..model.nv(),
            |q, dq, out| model.integrate_into(q, dq, out),
            |q, _, seeded| {
                rows.evaluate(model, constraints, q, v);
                let jacobian = rows.jacobian.chunks_exact(model.nv());
                let each = rows.rows.iter().zip(jacobian).zip(impulses.clone());
                for (row, ((held, entries), impulse)) in each.enumerate() {
                    for (k, column) in seeded.clone().enumerate() {
                        rate_by_q[(row, column)] = held.rate.eps[k];
                        for (i, entry) in entries.iter().enumerate() {
                            out[(i, column)] += entry.eps[k] * impulse;
                        }
                    }
                }
            },
        );
    }
}
