//! The velocity after a step with a₀, at which constraints state half of their bias.

use crate::scalar::Scalar;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// The configuration of the start of a step with v⁺ = v + Δt ã₀.
#[derive(Clone, Debug)]
pub(super) struct Ahead<T: Scalar> {
    state: State<T>,
}

impl<T: Scalar> Ahead<T> {
    /// Makes memory for a simulator.
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            state: simulator.neutral_state(),
        }
    }

    /// The point of evaluation there.
    ///
    /// * `seen` – ã₀
    pub(super) fn point<'a>(
        &'a mut self,
        at: &EvaluationPoint<'a, f64, T>,
        seen: &[T],
    ) -> EvaluationPoint<'a, f64, T> {
        self.state.q.copy_from(&at.state.q);
        let stepped = self.state.v.iter_mut().zip(at.v()).zip(seen);
        stepped.for_each(|((next, &v), &a)| *next = v + a * at.dt());
        EvaluationPoint::instant(at.simulator, &self.state, at.u)
    }
}
