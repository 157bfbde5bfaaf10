//! The Euler step, semi-implicit or linearly implicit: one acceleration, then the step of each joint with it.

mod impact;
mod pullback;
mod pushforward;
mod rows;

use super::AccelerationScratch;
use super::method::Step;
use crate::cone::Status;
use crate::scalar::{Over, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use impact::Impact;
pub(super) use pullback::{Adjoint, EvaluationAdjoint};
pub(super) use pushforward::Columns;

/// Memory in addition to that of its evaluation.
#[derive(Clone, Debug)]
pub(crate) struct Memory<T: Scalar> {
    /// Workspace of impacts at their time, if there can be any.
    impact: Option<Box<Impact<T>>>,
    /// Whether there was one in the last step.
    has_impact: bool,
}

impl<T: Scalar> Step<T> for Memory<T> {
    fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        Self {
            impact: simulator
                .may_bounce()
                .then(|| Box::new(Impact::new(simulator))),
            has_impact: false,
        }
    }

    #[inline]
    fn step<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        found: &mut AccelerationScratch<T>,
        next: &mut State<T>,
    ) where
        T: Over<P>,
    {
        let at = EvaluationPoint::of_step(simulator, state, u);
        simulator.accelerate(&at, found);
        self.has_impact = impact::lone(&at, found).is_some_and(|lone| {
            let impact = &mut self.impact;
            let impact = impact.get_or_insert_with(|| Box::new(Impact::new(simulator)));
            impact.step(&at, lone, found, next)
        });
        if !self.has_impact {
            advance(&at, found, next);
        }
    }

    fn status(&self, lane: usize) -> Status {
        let impact = self.impact.as_ref().filter(|_| self.has_impact);
        impact.map_or(Status::Converged, |impact| impact.status(lane))
    }
}

/// The step with an acceleration that has been found.
pub(super) fn advance<P: Scalar, T: Over<P>>(
    at: &EvaluationPoint<'_, P, T>,
    found: &AccelerationScratch<T>,
    next: &mut State<T>,
) {
    let dt = at.dt();
    // v⁺ = v + Δt v̇,  q⁺ = q ⊕ Δt v⁺
    at.model().advance_into(
        at.q(),
        at.v(),
        &found.a,
        dt,
        next.q.as_mut_slice(),
        next.v.as_mut_slice(),
    );
    // m⁺ = m + Δt ṁ, implicit in how bristles fall
    let contact = next.contact.iter_mut().zip(&at.state.contact);
    for ((next, &m), step) in contact.zip(found.terms.contact.steps(dt)) {
        *next = m + step;
    }
}
