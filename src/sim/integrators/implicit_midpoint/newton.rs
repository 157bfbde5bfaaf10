//! The velocity of a step by Newton's method on plain numbers.
//!
//! The matrix is that of the first guess, the velocity before the step, while it converges: usually the residual decreases a hundredfold or more with
//! each evaluation. If it does not decrease tenfold the matrix is updated; a step with fast rotations in which it does not decrease fiftyfold is too
//! long (`parts.rs`).

use std::any::Any;

use super::parts::{Search, TURN, divided, each, is_finite};
use super::point::Midpoint;
use super::slopes::MidpointDerivatives;
use crate::cone::Status;
use crate::dynamics::Calls;
use crate::scalar::{Linear, Over, Scalar, is_more_than_values};
use crate::sim::integrators::AccelerationScratch;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// Part of the velocity, or of one with which joints turn too little to matter, that a change may have at the end.
const TOLERANCE: f64 = 1e-13;
/// Part that it may have where rounding does not let it get smaller.
const ACCEPTABLE: f64 = 1e-9;
/// Required reduction of a change relative to the previous one; otherwise the matrix is updated.
const CONTRACTION: f64 = 0.1;
/// Required reduction if the step is not too long.
const DIRECT: f64 = 0.02;
/// Most changes of ξ.
const ITERATIONS: usize = 40;

/// Working memory, with what was found.
#[derive(Clone, Debug)]
pub(super) struct Newton {
    pub(super) point: Midpoint<f64>,
    slopes: Box<MidpointDerivatives<f64>>,
    found: AccelerationScratch<f64>,
    /// Start of the step, and start and end of a part.
    whole: State<f64>,
    start: State<f64>,
    end: State<f64>,
    u: Vec<f64>,
}

impl Newton {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        match plain(simulator) {
            Some(plain) => Self::of(plain),
            None => Self::of(&simulator.values(0)),
        }
    }

    fn of(simulator: &Simulator) -> Self {
        Self {
            point: Midpoint::new(simulator),
            slopes: Box::new(MidpointDerivatives::new(simulator)),
            found: AccelerationScratch::new(simulator, Calls::Many),
            whole: simulator.neutral_state(),
            start: simulator.neutral_state(),
            end: simulator.neutral_state(),
            u: vec![0.0; simulator.nu()],
        }
    }

    /// Finds ξ of the values, for a part of the time step. Does not allocate where the parameters of the robot are plain; otherwise a robot of their values is made.
    pub(super) fn solve<P: Scalar, T: Over<P>>(
        &mut self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        part: f64,
    ) -> Search {
        self.with_values(simulator, state, u, 0, |own, plain| {
            own.point.part = part;
            own.search::<T>(plain)
        })
    }

    /// The step of the values in a lane, which are all that there is.
    pub(super) fn step<P: Scalar, T: Over<P>>(
        &mut self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        lane: usize,
        next: &mut State<T>,
    ) -> Status {
        let status = self.with_values(simulator, state, u, lane, |own, plain| {
            own.whole.copy_from(&own.start);
            let is_finite = is_finite(&own.whole, &own.u);
            divided(is_finite, |parts| own.step_in(plain, parts)).1
        });
        let set = |out: &mut [T], x: &[f64]| {
            for (out, &x) in out.iter_mut().zip(x) {
                let known = *out;
                *out = T::from_values(|k| if k == lane { x } else { known.value(k) });
            }
        };
        set(next.q.as_mut_slice(), self.end.q.as_slice());
        set(next.v.as_mut_slice(), self.end.v.as_slice());
        status
    }

    /// The step of the values that were taken, in so many parts.
    fn step_in(&mut self, simulator: &Simulator, parts: usize) -> Search {
        self.point.part = 1.0 / parts as f64;
        self.start.copy_from(&self.whole);
        each(parts, |_| {
            let search = self.iterate(simulator);
            (self.point).finish(simulator, &self.start, &mut self.end);
            let error = self.point.energy_error(&self.start, &self.end);
            self.start.copy_from(&self.end);
            search.with_energy_error(error)
        })
    }

    fn with_values<P: Scalar, T: Over<P>, R>(
        &mut self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        lane: usize,
        work: impl FnOnce(&mut Self, &Simulator) -> R,
    ) -> R {
        if let Some(plain) = plain(simulator) {
            self.take(state, u, lane);
            return work(self, plain);
        }
        let values = simulator.values(lane);
        *self = Self::of(&values);
        self.take(state, u, lane);
        work(self, &values)
    }

    /// The values of state and input.
    fn take<T: Scalar>(&mut self, state: &State<T>, u: &[T], lane: usize) {
        let values = |own: &mut [f64], x: &[T]| {
            let both = own.iter_mut().zip(x);
            both.for_each(|(own, x)| *own = x.value(lane));
        };
        values(self.start.q.as_mut_slice(), state.q.as_slice());
        values(self.start.v.as_mut_slice(), state.v.as_slice());
        values(&mut self.u, u);
    }

    /// Converts residuals over numbers with derivatives into changes of ξ and of the impulses of constraints, with the matrix of the solution.
    pub(super) fn correct<T: Linear<f64>>(&self, residual: &mut [T], errors: &mut [T]) {
        self.slopes.saddle.solve(residual, errors);
    }

    /// [`solve`](Self::solve) from the values; for numbers with derivatives, with the matrix of the solution.
    fn search<T: Scalar>(&mut self, simulator: &Simulator) -> Search {
        let search = self.iterate(simulator);
        if is_more_than_values::<T>() {
            self.find_matrix(simulator);
        }
        search
    }

    fn iterate(&mut self, simulator: &Simulator) -> Search {
        self.point.start(simulator, &self.start);
        self.evaluate(simulator);
        self.find_matrix(simulator);
        // Motion that closes constraints is unrelated to the speed of joints.
        let closes = !self.point.held.is_closed();
        let time = simulator.time_step() * self.point.part;
        let (mut before, mut turn, mut is_direct) = (f64::INFINITY, 0.0, true);
        for _ in 0..ITERATIONS {
            let Midpoint { residual, held, .. } = &mut self.point;
            self.slopes.saddle.solve(residual, &mut held.errors);
            let size = largest(residual);
            if !size.is_finite() {
                return Search::failed(Status::NotFinite);
            }
            let velocity = largest(&self.point.xi).max(size).max(TURN / time);
            let change = size / velocity;
            let is_slow = change > CONTRACTION * before;
            if is_slow && change <= ACCEPTABLE {
                return Search::found(is_direct);
            }
            is_direct &= closes || turn <= TURN || change <= DIRECT * before;
            self.point.move_by_residual();
            self.evaluate(simulator);
            if change <= TOLERANCE {
                return Search::found(is_direct);
            }
            if is_slow {
                self.find_matrix(simulator);
            }
            (before, turn) = (change, size * time);
        }
        Search::failed(Status::IterationLimit)
    }

    fn evaluate(&mut self, simulator: &Simulator) {
        let (point, found) = (&mut self.point, &mut self.found);
        point.evaluate(simulator, &self.start, &self.u, found);
        point.find_residual(simulator, &self.start);
    }

    fn find_matrix(&mut self, simulator: &Simulator) {
        let (point, found) = (&self.point, &self.found);
        self.slopes
            .find(simulator, &self.start, &self.u, point, found);
    }
}

/// The simulator itself, if its parameters are plain numbers.
fn plain<P: Scalar>(simulator: &Simulator<P>) -> Option<&Simulator> {
    (simulator as &dyn Any).downcast_ref()
}

/// The largest number by magnitude; NaN if one is not.
fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| match most >= x.abs() {
        true => most,
        false if most.is_nan() => most,
        false => x.abs(),
    })
}
