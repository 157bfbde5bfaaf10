//! Division of a step that is too long for how fast joints turn in it.
//!
//! Where axes of joints come into line, as those of a hip of three joints do, coordinates turn by radians within a moment, however slowly bodies move. A
//! longer step has no solution there, or several, of which the first that is found may be far from the motion.

use super::newton::{Newton, Search, TURN};
use super::point::Midpoint;
use crate::cone::Status;
use crate::scalar::{Over, Scalar, is_more_than_values};
use crate::sim::integrators::AccelerationScratch;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// Most parts of a step.
const MOST: usize = 1024;

/// How much more the velocity may change after the middle of a step than before it.
const UNEVEN: f64 = 2.0;

/// Takes a step whole, or in 2, 4, … equal parts: the fewest of which each is found directly, or the most that there may be. Their number, and the worst
/// status.
///
/// * `step` – takes it in so many parts
pub(super) fn divided(mut step: impl FnMut(usize) -> Search) -> (usize, Status) {
    let mut parts = 1;
    loop {
        let search = step(parts);
        if search.is_direct || parts == MOST {
            return (parts, search.status);
        }
        parts *= 2;
    }
}

/// Takes parts one after the other, up to one that is not found directly where there may be more parts.
pub(super) fn each(parts: usize, mut take: impl FnMut(usize) -> Search) -> Search {
    let mut all = take(0);
    for k in 1..parts {
        if !all.is_direct && parts < MOST {
            break;
        }
        let search = take(k);
        all.status = all.status.max(search.status);
        all.is_direct &= search.is_direct;
    }
    all
}

/// Whether the velocity changes about as much after the middle of a step as before it. It does not where the end has light axes in line.
pub(super) fn is_even<T: Scalar>(start: &State<T>, xi: &[T], end: &State<T>, time: f64) -> bool {
    let most = |v: &State<T>| {
        let changes = v.v.iter().zip(xi).map(|(&v, &xi)| (v - xi).value(0).abs());
        time * changes.fold(0.0, f64::max)
    };
    most(end) <= TURN.max(UNEVEN * most(start))
}

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
        let time = simulator.time_step().value(0) * point.part;
        search.is_direct &= is_even(state, &point.xi, next, time);
        search
    }
}
