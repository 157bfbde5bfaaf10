//! Bounded forces together with forces of a solver.
//!
//! The pieces of their laws are changed in few rounds of the whole solution, with forces on their line added to M. Usually the first guess is
//! correct, and the problem of the solver is not larger than without them. Otherwise all become rows with a bounded force. They are rows from the
//! start while a step is recorded. Contact models that read the Delassus diagonal read that of M without the addition (`bare_mass.rs`).

use super::bounded_forces::BoundedForces;
use crate::cone::Block;
use crate::dynamics::{TreeMatrix, side_of};
use crate::scalar::{MapEach, Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;

/// Rounds in which pieces may change. Each costs a solution, as much as rows do.
const ROUNDS: usize = 3;

impl<T: Scalar> BoundedForces<T> {
    /// Whether they are rows of a solver, in the first lane.
    pub(super) fn are_rows(&self) -> bool {
        !self.in_rows.has_value() || self.in_rows.value(0) > 0.0
    }

    /// Adds rows, which have no force in lanes in which the forces are on pieces of their laws.
    pub(super) fn add_bounded_rows(&mut self, balance: &mut Balance<T>) {
        let (rows, in_rows) = (&mut balance.rows, self.in_rows);
        self.first = [rows.count(), rows.blocks()];
        let wanted = !in_rows.has_value() || (0..T::LANES).any(|lane| in_rows.value(lane) > 0.0);
        let absent = T::constant(f64::INFINITY);
        for (site, own) in self.all().filter(|_| wanted) {
            let (reference, compliance) = own.line.row();
            let compliance = T::zero().select_lt(in_rows, compliance, absent);
            rows.push_unit(site.coordinate, 1.0);
            rows.push_reference(reference, compliance);
            rows.push_block(Block::Interval, own.line.bound);
        }
    }

    /// Adds those on pieces of their laws to mass matrix and forces, before the first round.
    pub(in crate::sim) fn start<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        mass: &mut TreeMatrix<T>,
        forces: &mut [T],
    ) where
        T: Over<P>,
    {
        if !at.v().iter().all(T::has_value) {
            self.in_rows = T::one();
        }
        if self.is_empty() {
            return;
        }
        if !self.are_rows() {
            self.guess(mass, forces);
        }
        if let Some(beside) = self.beside.as_deref_mut() {
            beside.mass.copy_from_own(mass);
            beside.forces.copy_from_slice(forces);
            self.add_to(mass, forces);
        }
    }

    /// First takes friction to be what would stop each joint within the step if the others stood still and nothing touched.
    fn guess(&mut self, mass: &TreeMatrix<T>, forces: &[T]) {
        for (site, own) in self.all_mut().filter(|(site, _)| site.holds()) {
            let k = site.coordinate;
            own.piece = side_of(own.stop * mass[(k, k)] - forces[k], own.line.bound);
        }
    }

    /// The mass matrix without bounded forces; `None` where there are none.
    pub(in crate::sim) fn mass_beside(&self) -> Option<&TreeMatrix<T>> {
        let beside = self.beside.as_deref().filter(|_| !self.is_empty());
        beside.map(|beside| &beside.mass)
    }

    /// Writes mass matrix and forces with those on pieces of their laws.
    pub(in crate::sim) fn write(&self, mass: &mut TreeMatrix<T>, forces: &mut [T]) {
        if let Some(beside) = &self.beside {
            mass.copy_from_own(&beside.mass);
            forces.copy_from_slice(&beside.forces);
            self.add_to(mass, forces);
        }
    }

    fn add_to(&self, mass: &mut TreeMatrix<T>, forces: &mut [T]) {
        for (site, own) in self.all() {
            let k = site.coordinate;
            let parts = own.parts();
            let [push, resistance] =
                parts.map_each(|x| T::zero().select_lt(self.in_rows, T::zero(), x));
            forces[k] += push;
            mass[(k, k)] += resistance;
        }
    }

    /// Lets forces that break their law at the acceleration `a` go over to another piece of it, or become rows, after so many rounds. Returns whether there are
    /// any.
    pub(in crate::sim) fn revise_beside(
        &mut self,
        balance: &Balance<T>,
        a: &mut [T],
        round: usize,
    ) -> bool {
        let of_rows = |lane| self.in_rows.value(lane) > 0.0;
        if self.is_empty() || !self.in_rows.has_value() || (0..T::LANES).all(of_rows) {
            return false;
        }
        self.stop(a);
        self.find_needed_beside(balance, a);
        let changes = self.change(a, false);
        self.turn_round(a);
        if round >= ROUNDS {
            self.in_rows = T::zero().select_lt(changes, T::one(), self.in_rows);
        }
        (0..T::LANES).any(|lane| changes.value(lane) > 0.0)
    }

    /// Lets friction that drives a joint, and so goes over to holding it, act against the motion at once where it could not hold a joint that is as heavy as
    /// this one alone. Otherwise its direction would take two rounds.
    fn turn_round(&mut self, a: &[T]) {
        let Some(beside) = self.beside.take() else {
            return;
        };
        let (half, in_rows) = (T::constant(0.5), self.in_rows);
        for (site, own) in self.all_mut().filter(|(site, _)| site.holds()) {
            let k = site.coordinate;
            // Zero where it holds the joint.
            let slip = a[k] - own.stop;
            let against = slip.select_lt(T::zero(), T::one(), -T::one());
            let weight = slip.abs() * beside.mass[(k, k)];
            let turned = (own.line.bound * 2.0).select_lt(weight, against, own.piece);
            let next = half.select_lt(own.piece.abs(), own.piece, turned);
            own.piece = half.select_lt(in_rows, own.piece, next);
        }
        self.beside = Some(beside);
    }

    /// The joint forces that friction has to give for joints to stick, if some may.
    fn find_needed_beside(&mut self, balance: &Balance<T>, a: &[T]) {
        let Some(beside) = self.beside.as_deref().filter(|_| self.may_hold()) else {
            return;
        };
        let mut needed = std::mem::take(&mut self.needed);
        for (site, _) in self.all().filter(|(site, _)| site.holds()) {
            needed[site.coordinate] = beside.needed(site.coordinate, a, balance);
        }
        for (site, own) in self.all().filter(|(site, _)| !site.holds()) {
            let [push, resistance] = own.parts();
            needed[site.coordinate] += resistance * a[site.coordinate] - push;
        }
        self.needed = needed;
    }
}
