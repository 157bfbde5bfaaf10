//! Constraints over a step.
//!
//! Impulses λ along the rows of its start make the velocity ξ close them at its end, φ(q⁺) = 0; impulses along the rows of the end take what is left of the
//! velocity across them, J(q⁺) v⁺ = 0. Both together are the variational integrator of a constrained system: in coordinates of particles, the method
//! called RATTLE.
//!
//! # References
//! [Ryckaert, Ciccotti, Berendsen 1977]; [Andersen 1983]; [Hairer, Lubich, Wanner 2006, section VII.1].

use crate::constraint::ConstraintRows;
use crate::linalg::product::add_scaled;
use crate::scalar::{Over, Scalar};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// Allowed error of a row at the start of a step, m or rad, and per second. A larger error is closed at once, with a velocity that is unrelated to
/// the motion of the joints.
const CLOSED: f64 = 1e-7;

/// Rows of constraints at start and end of a step, with the impulses along them.
#[derive(Clone, Debug)]
pub(super) struct Held<T> {
    pub(super) start: ConstraintRows<T>,
    pub(super) end: ConstraintRows<T>,
    /// λ of the start and of the end, N·s or N·m·s.
    pub(super) impulses: [Vec<T>; 2],
    /// Errors of the end, or changes of λ of the start.
    pub(super) errors: Vec<T>,
}

impl<T: Scalar> Held<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let (n, nv) = (simulator.bilateral_rows(), simulator.model().nv());
        let zeros = || vec![T::zero(); n];
        Self {
            start: ConstraintRows::new(n, nv),
            end: ConstraintRows::new(n, nv),
            impulses: [zeros(), zeros()],
            errors: zeros(),
        }
    }

    /// Takes the rows of the start, without impulses.
    pub(super) fn find_start<P: Scalar>(&mut self, simulator: &Simulator<P>, state: &State<T>)
    where
        T: Over<P>,
    {
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        let constraints = simulator.constraints();
        let dt = T::from(simulator.time_step());
        self.start
            .evaluate(simulator.model(), constraints, q, v, dt);
        self.impulses[0].fill(T::zero());
    }

    /// Takes the rows of the end, and their errors.
    pub(super) fn find_end<P: Scalar>(&mut self, simulator: &Simulator<P>, q: &[T], v: &[T])
    where
        T: Over<P>,
    {
        let constraints = simulator.constraints();
        let dt = T::from(simulator.time_step());
        self.end.evaluate(simulator.model(), constraints, q, v, dt);
        let errors = self.errors.iter_mut().zip(&self.end.rows);
        errors.for_each(|(out, row)| *out = row.error);
    }

    /// Adds the impulses of the start to a momentum: Jᵀ λ.
    pub(super) fn push(&self, momentum: &mut [T]) {
        add_rows(&self.start, &self.impulses[0], momentum);
    }

    /// Whether the start obeys the constraints.
    pub(super) fn is_closed(&self) -> bool {
        let sizes = self.start.rows.iter().map(|row| [row.error, row.rate]);
        (sizes.flatten()).all(|x| x.value(0).abs() <= CLOSED)
    }
}

/// out += Jᵀ x
pub(super) fn add_rows<T: Scalar>(rows: &ConstraintRows<T>, x: &[T], out: &mut [T]) {
    let jacobian = rows.jacobian.chunks_exact(out.len().max(1));
    for (row, &x) in jacobian.zip(x) {
        add_scaled(out, row, x);
    }
}
