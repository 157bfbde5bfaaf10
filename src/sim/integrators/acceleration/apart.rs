//! The acceleration of a robot with contacts in a state in which nothing touches. There are no rows then, and forward dynamics is much faster than a mass
//! matrix with its factors.
//!
//! Joint limits obey the same law both ways.
//!
//! Lanes that differ are computed both ways, so that a state has the same bits in all lanes and alone. While a step is recorded, all rows are there.

use super::{AccelerationScratch, SAME_PARTS};
use crate::scalar::{Over, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::terms::Term as _;

impl<T: Scalar> AccelerationScratch<T> {
    /// v̇ under the forces of all terms, with those of rows in states that have rows.
    pub(super) fn solve_with_rows_if_any<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>)
    where
        T: Over<P>,
    {
        let balance = self.balance.as_deref_mut().expect(SAME_PARTS);
        balance.place(at);
        self.terms.contact.find_candidates(at, balance);
        let may = self.may_be_apart(at);
        if lanes(may) == 0 {
            return self.solve_with_rows(at);
        }
        self.solve_apart(at);
        match lanes(may) {
            n if n == T::LANES => self.rest(at),
            _ => self.solve_again(at, may),
        }
    }

    /// 1 in lanes in which there may be no rows, 0 in others.
    fn may_be_apart<P: Scalar>(&self, at: &EvaluationPoint<'_, P, T>) -> T
    where
        T: Over<P>,
    {
        let (zero, one) = (T::zero(), T::one());
        if const { !T::HAS_VALUES } || !at.may_lose_rows() {
            return zero;
        }
        // Where nothing rotates fast there is no half step.
        let half_step = at.half_step.unwrap_or(zero);
        zero.select_lt(half_step, zero, one) * self.terms.contact.are_apart(at)
    }

    /// v̇ without rows.
    fn solve_apart<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>)
    where
        T: Over<P>,
    {
        if !at.is_explicit() {
            self.terms.stops.detect(at);
        }
        let half_step = None;
        self.solve_without_rows(&EvaluationPoint { half_step, ..*at });
    }

    /// Records that this state has no rows.
    pub(super) fn rest<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>)
    where
        T: Over<P>,
    {
        self.are_apart = true;
        let balance = self.balance.as_deref_mut().expect(SAME_PARTS);
        balance.clear_rows();
        if let Some(contacts) = at.solved_contacts() {
            self.terms.contact.rest(contacts);
        }
    }

    /// v̇ with rows; in the lanes of `apart` that without rows.
    fn solve_again<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>, apart: T)
    where
        T: Over<P>,
    {
        self.terms.stops.clear();
        self.terms.bounded_forces.add_forces(at, &mut self.forces);
        self.apart.clone_from(&self.a);
        self.solve_with_rows(at);
        for (a, &own) in self.a.iter_mut().zip(&self.apart) {
            *a = T::zero().select_lt(apart, own, *a);
        }
    }
}

/// The number of lanes in which a number is positive; none where it is not known.
fn lanes<T: Scalar>(x: T) -> usize {
    let has = |lane: &usize| x.has_value() && x.value(*lane) > 0.0;
    (0..T::LANES).filter(has).count()
}
