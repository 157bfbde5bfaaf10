//! Kinematic constraints: rows whose forces hold loops closed.

use super::local::OfCoordinate;
use super::term::Term;
use crate::cone::Block;
use crate::constraint::{ConstraintRow, ConstraintRows};
use crate::model::manifold::v_range;
use crate::scalar::{Over, Scalar};
use crate::sim::balance::{Balance, HeldStart};
use crate::sim::forces::Forces;
use crate::sim::moment::Moment;
use crate::sim::simulator::Simulator;

/// Constraints at a moment.
#[derive(Clone, Debug)]
pub(crate) struct Constraints<T> {
    rows: ConstraintRows<T>,
    /// The velocity with which the bias after the step is found.
    next_v: Vec<T>,
}

impl<T: Scalar> Constraints<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let (rows, nv) = (simulator.held_rows(), simulator.model().nv());
        Self {
            rows: ConstraintRows::new(rows, nv),
            next_v: Vec::with_capacity(nv),
        }
    }

    /// The rows along the velocity of the start of a step.
    pub(in crate::sim) fn held_along_start<D: Scalar>(
        &self,
        dt: D,
    ) -> HeldStart<'_, impl Iterator<Item = T>, T>
    where
        T: Over<D>,
    {
        let rows = self.rows.rows.iter();
        let wanted = rows.map(move |row| -(row.over_step(row.bias, dt) + row.turning));
        HeldStart {
            jacobian: &self.rows.jacobian,
            wanted,
        }
    }

    /// Hands each row at the state of the last evaluation, over numbers with a direction for the time step, to `each`.
    pub(super) fn each_constant_row(
        &self,
        mut each: impl FnMut(usize, &ConstraintRow<OfCoordinate<T>>),
    ) {
        for (index, row) in self.rows.rows.iter().enumerate() {
            each(index, &row.map(OfCoordinate::constant_of));
        }
    }

    /// Finds the biases at the velocity after a step with the acceleration `a`.
    fn look_ahead<P: Scalar>(&mut self, at: &Moment<'_, P, T>, a: &[T])
    where
        T: Over<P>,
    {
        self.next_v.clear();
        self.next_v.resize(a.len(), T::zero());
        step_velocity_into(at, a, &mut self.next_v);
        let constraints = at.simulator.constraints();
        let (rows, next_v) = (&mut self.rows, &self.next_v);
        rows.look_ahead(at.model(), constraints, at.q(), next_v);
    }
}

/// The velocity after a step, along the axes of before it.
fn step_velocity_into<P: Scalar, T: Over<P>>(at: &Moment<'_, P, T>, a: &[T], next_v: &mut [T]) {
    for body in at.model().independent() {
        let own = v_range(body);
        let (v, a) = (&at.v()[own.clone()], &a[own.clone()]);
        body.joint.step_velocity(v, a, at.dt(), &mut next_v[own]);
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for Constraints<T> {
    #[inline]
    fn add_forces(&mut self, at: &Moment<'_, P, T>, _: &mut Forces<T>) {
        let constraints = at.simulator.constraints();
        if !constraints.is_empty() {
            let rows = &mut self.rows;
            rows.evaluate(at.model(), constraints, at.q(), at.v());
        }
    }

    /// y = J ã − reference: at a moment, or over a step from the acceleration that would be without other rows.
    fn add_rows(&mut self, at: &Moment<'_, P, T>, balance: &mut Balance<T>) {
        let constraints = at.simulator.constraints();
        if constraints.is_empty() {
            return;
        }
        let dt = at.dt();
        let ahead = balance.gyroscopic().map(|gyroscopic| &gyroscopic.a[..]);
        if let Some(a) = ahead {
            self.look_ahead(at, a);
        }
        let over_step = ahead.is_some();
        let rows = &mut balance.rows;
        let own = rows.grow(self.rows.rows.len());
        own.copy_from_slice(&self.rows.jacobian);
        for (r, row) in self.rows.rows.iter().enumerate() {
            let bias = if over_step {
                row.over_step(self.rows.bias_after(r), dt)
            } else {
                row.at_moment(dt)
            };
            rows.push_reference(-bias, T::zero());
        }
        for constraint in constraints {
            rows.push_block(Block::Free(constraint.rows()), T::zero());
        }
    }
}
