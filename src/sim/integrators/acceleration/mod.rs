//! The acceleration at which all terms balance.

mod apart;
mod known;
mod pullback;
mod pushforward;
mod rows;

use super::half_step::HalfStep;
use crate::dynamics::{AbaScratch, Calls, Motions, forward_dynamics_into};
use crate::scalar::{Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::forces::Forces;
use crate::sim::placed::add_diagonal;
use crate::sim::simulator::Simulator;
use crate::sim::terms::{Term, Terms};
use crate::spatial::{Motion, Transform};
pub(crate) use known::KnownAcceleration;
pub(super) use pullback::AccelerationAdjoint;
pub(crate) use pushforward::AccelerationColumns;
pub(super) use rows::AccelerationWeights;

/// Working memory and result of [`Simulator::accelerate`].
#[derive(Clone, Debug)]
pub(crate) struct AccelerationScratch<T: Scalar> {
    pub(crate) terms: Terms<T>,
    forces: Forces<T>,
    /// For robots without rows.
    aba: AbaScratch<T>,
    /// With semi-implicit Euler allocated at the first step with fast rotation.
    half_step: Option<Box<HalfStep<T>>>,
    /// For robots with rows.
    pub(crate) balance: Option<Box<Balance<T>>>,
    /// Whether the last point has no rows, since nothing touches.
    are_apart: bool,
    /// v̇ without rows.
    apart: Vec<T>,
    /// v̇, rad/s² or m/s².
    pub(crate) a: Vec<T>,
}

/// Why there is a balance.
const SAME_PARTS: &str = "scratch of a simulator with the same parts";

/// Motions of bodies that an acceleration has left.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FoundMotions<'a, T> {
    Nothing,
    /// Pose of each body in its parent, and its velocity in its own frame.
    Velocities((&'a [Transform<T>], &'a [Motion<T>])),
    Accelerations(Motions<'a, T>),
    /// All of that, in the lanes of a packed tree.
    Packed(&'a AbaScratch<T>),
}

impl<T: Scalar> AccelerationScratch<T> {
    pub(crate) fn new<P: Scalar>(simulator: &Simulator<P>, calls: Calls) -> Self {
        let (model, solved) = (simulator.model(), simulator.needs_solver());
        let at_middle = simulator.always_in_the_middle();
        Self {
            terms: Terms::new(simulator),
            forces: Forces::new(simulator),
            aba: AbaScratch::for_calls(model, calls),
            half_step: at_middle.then(|| HalfStep::new(simulator)),
            balance: solved.then(|| Box::new(Balance::new(simulator))),
            are_apart: false,
            apart: Vec::with_capacity(model.nv()),
            a: vec![T::zero(); model.nv()],
        }
    }

    /// Velocity forces of the middle of the last step; `None` where they are those of the state.
    pub(super) fn half_step<P: Scalar>(
        &self,
        at: &EvaluationPoint<'_, P, T>,
    ) -> Option<&HalfStep<T>> {
        at.half_step.filter(|_| !self.are_apart)?;
        self.half_step.as_deref()
    }

    /// Whether the last point has rows.
    pub(super) fn has_rows<P: Scalar>(&self, at: &EvaluationPoint<'_, P, T>) -> bool
    where
        T: Over<P>,
    {
        at.may_have_rows() && !self.are_apart
    }

    /// Implicit damping diagonal at the last point, without rows; empty for none.
    pub(crate) fn resistance<P: Scalar>(&self, at: &EvaluationPoint<'_, P, T>) -> &[T]
    where
        T: Over<P>,
    {
        if at.is_explicit() {
            &[]
        } else if !self.terms.bounded_forces.is_empty() {
            self.terms.bounded_forces.resistance()
        } else if self.terms.stops.ends().is_empty() {
            &self.forces.resistance
        } else {
            self.terms.stops.resistance()
        }
    }

    /// Poses of the bodies in their parents, and their velocities, at the last point, where they have been left; with accelerations if forward
    /// dynamics left these too.
    pub(crate) fn motions<P: Scalar>(&self, at: &EvaluationPoint<'_, P, T>) -> FoundMotions<'_, T>
    where
        T: Over<P>,
    {
        // In all lanes and states the same, so that readings are the same bits.
        if at.may_have_rows() {
            let balance = self.balance.as_deref();
            return balance.map_or(FoundMotions::Nothing, |own| {
                FoundMotions::Velocities(own.motions())
            });
        }
        match self.aba.motions() {
            // Coordinates that dry friction holds stop but for rounding.
            Some(motions) => FoundMotions::Accelerations(motions),
            None if self.aba.has_packed_motions() => FoundMotions::Packed(&self.aba),
            None => FoundMotions::Nothing,
        }
    }

    /// v̇ under the forces that are there.
    #[inline]
    fn solve<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>)
    where
        T: Over<P>,
    {
        self.are_apart = false;
        if at.may_have_rows() {
            self.solve_with_rows_if_any(at);
        } else {
            self.solve_without_rows(at);
        }
    }

    /// Forward dynamics, with joint limits that may be released and velocity forces of the middle of the step.
    fn solve_without_rows<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>)
    where
        T: Over<P>,
    {
        let (forces, aba, a) = (&mut self.forces, &mut self.aba, &mut self.a);
        let (model, has_pieces) = (at.model(), self.terms.have_pieces());
        if at.is_explicit() {
            let (tau, bodies) = (&forces.tau, &forces.bodies);
            return forward_dynamics_into(model, at.q(), at.v(), tau, bodies, aba, a);
        }
        if at.half_step.is_some() {
            let new = || HalfStep::new(at.simulator);
            let half_step = self.half_step.get_or_insert_with(new);
            half_step.correct(at, forces);
            if at.simulator.always_in_the_middle() && !has_pieces {
                return a.copy_from_slice(&half_step.gyroscopic.a);
            }
        }
        let Terms {
            stops,
            bounded_forces,
            ..
        } = &mut self.terms;
        stops.accelerate(at, forces, bounded_forces, aba, a);
    }

    /// The forces of rows by a solver, and those of bounded ones on the pieces of their laws that hold.
    fn solve_with_rows<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>)
    where
        T: Over<P>,
    {
        let (terms, forces, a) = (&mut self.terms, &self.forces, &mut self.a);
        let balance = self.balance.as_deref_mut();
        let balance = balance.expect(SAME_PARTS);
        balance.load(at, forces);
        let resistance = match at.at_end.has_joints() {
            true => &forces.resistance[..],
            false => &[],
        };
        let new = || HalfStep::new(at.simulator);
        let half_step = (at.half_step).map(|_| self.half_step.get_or_insert_with(new));
        let mut gyroscopic = half_step.map(|half_step| &mut half_step.gyroscopic);
        balance.find_mass(at.model(), |mass, forces| {
            match &mut gyroscopic {
                None => add_diagonal(mass, resistance),
                Some(gyroscopic) => {
                    let held = terms.constraints.along_start(at.dt());
                    gyroscopic.correct(at, resistance, mass, forces, held);
                }
            }
            terms.bounded_forces.start(at, mass, forces);
        });
        balance.find_bare_mass(terms.bounded_forces.mass_beside());
        if let Some(gyroscopic) = gyroscopic {
            terms.constraints.look_ahead(at, &gyroscopic.a);
        }
        for round in 1.. {
            solve_rows(at, terms, balance, a);
            if !terms.bounded_forces.revise_beside(balance, a, round) {
                break;
            }
            balance.change_mass(|mass, forces| terms.bounded_forces.write(mass, forces));
        }
        terms.accept(at, balance);
        balance.retain_status();
    }
}

/// Finds v̇ and the forces of all rows that finally take part.
fn solve_rows<P: Scalar, T: Over<P>>(
    at: &EvaluationPoint<'_, P, T>,
    terms: &mut Terms<T>,
    balance: &mut Balance<T>,
    a: &mut [T],
) {
    balance.rows.clear();
    terms.add_rows(at, balance);
    loop {
        balance.form_delassus();
        terms.add_references(at, balance);
        balance.solve(at, a);
        if !terms.add_violated(at, balance, a) {
            return;
        }
    }
}

impl<P: Scalar> Simulator<P> {
    /// Finds v̇ and the rates of contact, and leaves them in the scratch.
    pub(crate) fn accelerate<T: Over<P>>(
        &self,
        at: &EvaluationPoint<'_, P, T>,
        s: &mut AccelerationScratch<T>,
    ) {
        self.apply_terms(at, s);
        s.solve(at);
    }

    /// The forces of all terms at an instant.
    pub(super) fn apply_terms<'s, T: Over<P>>(
        &self,
        at: &EvaluationPoint<'_, P, T>,
        s: &'s mut AccelerationScratch<T>,
    ) -> &'s Forces<T> {
        s.forces.clear();
        s.aba.forget();
        s.terms.add_forces(at, &mut s.forces);
        &s.forces
    }

    /// [`accelerate`](Self::accelerate) where v̇ has been found before: only what else it leaves is found, unless it comes with more.
    pub(crate) fn accelerate_again<T: Over<P>>(
        &self,
        at: &EvaluationPoint<'_, P, T>,
        a: &[T],
        s: &mut AccelerationScratch<T>,
    ) {
        self.apply_terms(at, s);
        if at.may_have_rows() || at.half_step.is_some() || s.terms.have_pieces() {
            s.solve(at);
        } else {
            s.a.copy_from_slice(a);
        }
    }
}
