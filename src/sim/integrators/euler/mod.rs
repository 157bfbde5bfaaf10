//! The step of Euler, semi-implicit or implicit in velocity: one acceleration, then each joint's own step with it.

mod pullback;
mod pushforward;

use std::marker::PhantomData;

use super::AccelerationScratch;
use super::method::Step;
use crate::scalar::{Over, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
pub(super) use pullback::Adjoint;
pub(super) use pushforward::Columns;

/// The step needs no memory beside that of its evaluation.
#[derive(Clone, Debug)]
pub(crate) struct Memory<T>(PhantomData<T>);

impl<T: Scalar> Step<T> for Memory<T> {
    fn new<P: Scalar>(_: &Simulator<P>) -> Self {
        Self(PhantomData)
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
        simulator.accelerate(&EvaluationPoint::of_step(simulator, state, u), found);
        advance(simulator, state, found, next);
    }
}

/// The step with an acceleration that has been found.
fn advance<P: Scalar, T: Over<P>>(
    simulator: &Simulator<P>,
    state: &State<T>,
    found: &AccelerationScratch<T>,
    next: &mut State<T>,
) {
    let dt = simulator.time_step();
    // v⁺ = v + Δt v̇,  q⁺ = q ⊕ Δt v⁺
    simulator.model().advance_into(
        state.q.as_slice(),
        state.v.as_slice(),
        &found.a,
        dt,
        next.q.as_mut_slice(),
        next.v.as_mut_slice(),
    );
    // m⁺ = m + Δt ṁ, implicit in how bristles fall
    let contact = next.contact.iter_mut().zip(&state.contact);
    for ((next, &m), step) in contact.zip(found.terms.contact.steps(dt)) {
        *next = m + step;
    }
}
