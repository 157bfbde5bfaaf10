//! Kinematic constraints: rows whose forces hold loops closed, rigidly, as springs, or with bounded forces.

use super::bilateral_row::BilateralRow;
use super::term::Term;
use crate::cone::Block;
use crate::constraint::{ConstraintRow, ConstraintRows};
use crate::scalar::{Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::forces::Forces;
use crate::sim::simulator::Simulator;

/// Constraints at an instant.
#[derive(Clone, Debug)]
pub(crate) struct Constraints<T> {
    rows: ConstraintRows<T>,
    /// The velocity with which the bias after the step is found.
    next_v: Vec<T>,
}

impl<T: Scalar> Constraints<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let (rows, nv) = (simulator.bilateral_rows(), simulator.model().nv());
        Self {
            rows: ConstraintRows::new(rows, nv),
            next_v: Vec::with_capacity(nv),
        }
    }

    /// J, row by row, and r and R of each with which  J a = r − R f  holds the rows along the velocity of the start of a step.
    pub(in crate::sim) fn along_start<D: Scalar>(
        &self,
        dt: D,
    ) -> (&[T], impl Iterator<Item = (T, T)>)
    where
        T: Over<D>,
    {
        let rows = self.rows.rows.iter();
        let wanted = rows.map(move |row| {
            let BilateralRow { rest, compliance } = BilateralRow::of(row, Some(row.bias), dt);
            // Rows that may yield do not hold this motion.
            let bounded = row.largest_force.map(|_| T::constant(f64::INFINITY));
            (-(rest + row.turning), bounded.unwrap_or(compliance))
        });
        (&self.rows.jacobian, wanted)
    }

    /// The rows at the state.
    pub(super) fn rows(&self) -> &[ConstraintRow<T>] {
        &self.rows.rows
    }

    /// The forces of all rows: of those that a solver has found, and of springs at an instant.
    pub(in crate::sim) fn forces<P: Scalar>(
        &self,
        at: &EvaluationPoint<'_, P, T>,
        solved: &[T],
    ) -> Vec<T>
    where
        T: Over<P>,
    {
        let spring = |row: &ConstraintRow<T>| row.spring_force().filter(|_| has_springs(at));
        let rows = self.rows().iter().zip(solved);
        rows.map(|(row, &f)| spring(row).unwrap_or(f)).collect()
    }

    /// Adds the forces of springs at the state.
    fn add_springs(&self, tau: &mut [T]) {
        let jacobian = self.rows.jacobian.chunks_exact(tau.len().max(1));
        for (row, jacobian) in self.rows().iter().zip(jacobian) {
            if let Some(force) = row.spring_force() {
                let entries = tau.iter_mut().zip(jacobian);
                entries.for_each(|(tau, &j)| *tau += j * force);
            }
        }
    }

    /// Finds the biases at the velocity after a step with the acceleration `a`, which the rows of that step contain.
    pub(in crate::sim) fn look_ahead<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>, a: &[T])
    where
        T: Over<P>,
    {
        let constraints = at.simulator.constraints();
        if constraints.is_empty() {
            return;
        }
        self.next_v.clear();
        self.next_v.resize(a.len(), T::zero());
        step_velocity_into(at, a, &mut self.next_v);
        let (rows, next_v) = (&mut self.rows, &self.next_v);
        rows.look_ahead(at.model(), constraints, at.q(), next_v);
    }
}

/// Whether forces of springs are those of the state, as at an instant; over a step a solver finds them.
pub(super) fn has_springs<P: Scalar, T: Over<P>>(at: &EvaluationPoint<'_, P, T>) -> bool {
    at.half_step.is_none()
}

/// The velocity after a step, along the axes of before it.
fn step_velocity_into<P: Scalar, T: Over<P>>(
    at: &EvaluationPoint<'_, P, T>,
    a: &[T],
    next_v: &mut [T],
) {
    for body in at.model().independent() {
        body.step_velocity(at.v(), a, at.dt(), next_v);
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for Constraints<T> {
    #[inline]
    fn add_forces(&mut self, at: &EvaluationPoint<'_, P, T>, forces: &mut Forces<T>) {
        let constraints = at.simulator.constraints();
        if !constraints.is_empty() {
            let rows = &mut self.rows;
            rows.evaluate(at.model(), constraints, at.q(), at.v(), at.dt().into());
            if has_springs(at) {
                self.add_springs(&mut forces.tau);
            }
        }
    }

    /// y = J ã − reference: at an instant, or over a step from the acceleration that would be without other rows.
    fn add_rows(&mut self, at: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
        let constraints = at.simulator.constraints();
        if constraints.is_empty() {
            return;
        }
        let dt = at.dt();
        let rows = &mut balance.rows;
        rows.push_dense(self.rows.rows.len(), &self.rows.jacobian);
        for (r, row) in self.rows.rows.iter().enumerate() {
            let after = at.half_step.map(|_| self.rows.bias_after(r));
            let held = BilateralRow::of(row, after, dt);
            rows.push_reference(-held.rest, held.compliance);
        }
        for constraint in constraints {
            match constraint.largest_force() {
                None => rows.push_block(Block::Free(constraint.rows()), T::zero()),
                Some(bound) => (0..constraint.rows())
                    .for_each(|_| rows.push_block(Block::Interval, bound.into())),
            }
        }
    }
}
