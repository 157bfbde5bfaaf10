//! One part of a step.

use super::newton::Newton;
use super::parts::Search;
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
        let search = self.newton.solve(simulator, state, u, point.part);
        let values = self.newton.point.xi.iter().map(|&x| T::constant(x));
        point.xi.iter_mut().zip(values).for_each(|(xi, x)| *xi = x);
        point.evaluate(simulator, state, u, found);
        // Each makes one more order of derivatives exact.
        let corrections = T::ORDER.max(usize::from(is_more_than_values::<T>()));
        for _ in 0..corrections {
            point.find_residual(simulator);
            self.newton.correct(&mut point.residual);
            point.move_by_residual();
            point.evaluate(simulator, state, u, found);
        }
        point.finish(simulator, state, next);
        search.with_energy_error(point.energy_error(state, next))
    }
}
