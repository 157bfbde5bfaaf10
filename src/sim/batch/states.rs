//! The states of a batch.

use super::groups::Groups;
use super::{BATCH_WIDTH, BatchScalar};
use crate::model::Structure;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::status::{RolloutStatus, SolverFailure};

/// Many states, packed into lanes, each with its status. Made by [`BatchSimulator::states`](super::BatchSimulator::states).
#[derive(Clone, Debug)]
pub struct BatchStates {
    /// Structure of the robot that they are of.
    pub(super) robot: Structure,
    pub(super) groups: Groups<BatchScalar, BATCH_WIDTH>,
}

#[expect(
    clippy::len_without_is_empty,
    reason = "a count, none of which is rare"
)]
impl BatchStates {
    pub(super) fn new(simulator: &Simulator, states: &[State]) -> Self {
        Self {
            robot: simulator.model().structure(),
            groups: Groups::new(simulator, states),
        }
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.groups.len
    }

    /// A state: after the last step that did not diverge, see [`status`](Self::status). Allocates.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn state(&self, i: usize) -> State {
        let (group, lane) = self.groups.at(i);
        group.lane(lane)
    }

    /// All states, as [`state`](Self::state) gives them. Allocates.
    pub fn to_vec(&self) -> Vec<State> {
        (0..self.groups.len).map(|i| self.state(i)).collect()
    }

    /// Writes all states row by row, in the format of [`State::copy_to_slice`]: q, v and the contact state. Does not allocate.
    ///
    /// * `out` – output, length `len` × the length of a state
    ///
    /// # Panics
    /// If the output has the wrong length.
    pub fn copy_rows_to(&self, out: &mut [f64]) {
        let width = self.groups.all.first().map_or(0, |group| group.state.len());
        assert_eq!(out.len(), self.len() * width, "len × the length of a state");
        let rows = out.chunks_mut((width * BATCH_WIDTH).max(1));
        for (group, rows) in self.groups.all.iter().zip(rows) {
            for (k, x) in group.state.numbers().enumerate() {
                let column = rows[k..].iter_mut().step_by(width);
                column.zip(x.0).for_each(|(out, x)| *out = x);
            }
        }
    }

    /// `Completed` if all steps were taken; otherwise the reason and the step at which the state stopped, counted from 0 since the batch was made.
    /// Stopped states keep their values until they are [`set`](Self::set).
    ///
    /// # Panics
    /// If there is no such state.
    pub fn status(&self, i: usize) -> RolloutStatus {
        let (group, lane) = self.groups.at(i);
        group.status()[lane]
    }

    /// The first step of a state in which the solver of the forces of contact and constraints failed, counted as in
    /// [`status`](Self::status); `None` if it never did since the state was [`set`](Self::set).
    ///
    /// # Panics
    /// If there is no such state.
    pub fn solver_failure(&self, i: usize) -> Option<SolverFailure> {
        let (group, lane) = self.groups.at(i);
        group.solver_failures()[lane]
    }

    /// Sets one state, which runs again if it had stopped. Does not allocate.
    ///
    /// # Panics
    /// If there is no such state, or if it has the wrong length.
    pub fn set(&mut self, i: usize, state: &State) {
        self.groups.set(i, state);
    }

    /// The states of each group in lanes, for controllers over [`BatchScalar`]. Lanes past the last state repeat it.
    #[doc(hidden)]
    pub fn groups(&self) -> impl ExactSizeIterator<Item = &State<BatchScalar>> {
        self.groups.all.iter().map(|group| &group.state)
    }
}
