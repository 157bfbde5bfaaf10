//! One part of a step.

use super::newton::Newton;
use super::parts::{Search, is_even};
use super::point::Midpoint;
use crate::scalar::{Over, Scalar, is_more_than_values};
use crate::sim::integrators::AccelerationScratch;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// Working memory for one part of a step: its middle, and the search for it on plain numbers.
#[derive(Clone, Debug)]
pub(super) struct Part<T: Scalar> {
    pub(super) point: Midpoint<T>,
    pub(super) newton: Newton,
}

impl<T: Scalar> Part<T> {
    /// Takes one of so many equal parts of a step.
    pub(super) fn take<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        parts: usize,
        found: &mut AccelerationScratch<T>,
        next: &mut State<T>,
    ) -> Search
    where
        T: Over<P>,
    {
        let point = &mut self.point;
        point.part = 1.0 / parts as f64;
        point.start(simulator, state);
        let mut search = self.newton.solve(simulator, state, u, point.part);
        point.take_values(&self.newton.point);
        point.evaluate(simulator, state, u, found);
        // Each makes one more order of derivatives exact.
        let corrections = T::ORDER.max(usize::from(is_more_than_values::<T>()));
        for _ in 0..corrections {
            point.find_residual(simulator, state);
            (self.newton).correct(&mut point.residual, &mut point.held.errors);
            point.move_by_residual();
            point.evaluate(simulator, state, u, found);
        }
        point.finish(simulator, state, next);
        let time = simulator.time_step().value(0) * point.part;
        search.is_direct &= !point.held.is_closed() || is_even(state, &point.xi, next, time);
        search
    }
}
