//! States side by side in the lanes of one scalar.

use std::ops::Range;

use nalgebra::DVector;

use crate::cone::Status;
use crate::scalar::{MapEach, Scalar, from_each};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::status::{RolloutStatus, SolverFailure};

/// The states in the lanes of one scalar, of which there are `N`, each with its status.
#[derive(Clone, Debug)]
pub(super) struct Group<T: Scalar, const N: usize> {
    pub(super) state: State<T>,
    status: [RolloutStatus; N],
    solver_failures: [Option<SolverFailure>; N],
    all_run: bool,
}

impl<T: Scalar, const N: usize> Group<T, N> {
    #[inline]
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            state: simulator.neutral_state(),
            status: [RolloutStatus::Completed; N],
            solver_failures: [None; N],
            all_run: true,
        }
    }

    pub(super) fn set(&mut self, lane: usize, state: &State) {
        let (own, given) = (&mut self.state, state);
        assert_eq!(
            [&own.q, &own.v, &own.contact, &own.activation].map_each(DVector::len),
            [&given.q, &given.v, &given.contact, &given.activation].map_each(DVector::len),
            "nq, nv and the lengths of the state of contact and of activations"
        );
        // A state that does not say what sleeps is awake.
        let numbers = given.numbers().chain(std::iter::repeat(&0.0));
        for (own, &given) in own.numbers_mut().zip(numbers) {
            *own = T::from_values(|k| if k == lane { given } else { own.value(k) });
        }
        self.status[lane] = RolloutStatus::Completed;
        self.solver_failures[lane] = None;
        self.all_run = self.status.iter().all(is_running);
    }

    pub(super) fn lane(&self, lane: usize) -> State {
        State {
            q: self.state.q.map(|x| x.value(lane)),
            v: self.state.v.map(|x| x.value(lane)),
            contact: self.state.contact.map(|x| x.value(lane)),
            activation: self.state.activation.map(|x| x.value(lane)),
            sleep: self.state.sleep.map(|x| x.value(lane)),
        }
    }

    pub(super) fn all_stopped(&self) -> bool {
        !self.all_run && !self.status.iter().any(is_running)
    }

    /// Stops all lanes.
    pub(super) fn stop(&mut self, status: RolloutStatus) {
        self.status = [status; N];
        self.all_run = false;
    }

    pub(super) fn status(&self) -> &[RolloutStatus; N] {
        &self.status
    }

    /// Whether the state of each lane runs.
    #[inline]
    pub(super) fn runs(&self) -> [bool; N] {
        match self.all_run {
            true => [true; N],
            false => from_each(|lane| is_running(&self.status[lane])),
        }
    }

    pub(super) fn solver_failures(&self) -> &[Option<SolverFailure>; N] {
        &self.solver_failures
    }

    /// Notes where a solver has failed for the first time in a step that has just been taken.
    ///
    /// * `solver_status` – that of the step in a lane
    #[inline]
    pub(super) fn watch_solver(&mut self, step: usize, solver_status: impl Fn(usize) -> Status) {
        let worst = (0..N).map(&solver_status).max();
        if worst <= Some(Status::Acceptable) {
            return;
        }
        for (lane, failure) in self.solver_failures.iter_mut().enumerate() {
            if is_running(&self.status[lane]) {
                SolverFailure::note(failure, step, solver_status(lane));
            }
        }
    }

    /// Takes over the lanes of the next state; a lane that came of an input that is not finite, or is not finite itself or faster than the
    /// bound, stops where it is.
    #[inline]
    pub(super) fn accept(&mut self, step: usize, u: &[T], next: &mut State<T>, bound: f64) {
        if self.all_run && end_of(step, u, next, bound, 0..N).is_none() {
            std::mem::swap(&mut self.state, next);
        } else {
            self.accept_some(step, u, next, bound);
        }
    }

    #[cold]
    fn accept_some(&mut self, step: usize, u: &[T], next: &State<T>, bound: f64) {
        for (lane, status) in self.status.iter_mut().enumerate() {
            if is_running(status) {
                *status = end_of(step, u, next, bound, lane..lane + 1).unwrap_or(*status);
            }
        }
        let runs = |lane: usize| is_running(&self.status[lane]);
        for (own, next) in self.state.numbers_mut().zip(next.numbers()) {
            *own = T::from_values(|lane| if runs(lane) { next } else { &*own }.value(lane));
        }
        self.all_run = self.status.iter().all(is_running);
    }
}

fn is_running(status: &RolloutStatus) -> bool {
    *status == RolloutStatus::Completed
}

/// Status of a trajectory that a step ends in some lanes.
#[inline]
fn end_of<T: Scalar>(
    step: usize,
    u: &[T],
    next: &State<T>,
    bound: f64,
    lanes: Range<usize>,
) -> Option<RolloutStatus> {
    match RolloutStatus::before(step, u, lanes.clone()) {
        None => RolloutStatus::after(step, next, bound, lanes),
        ended => ended,
    }
}
