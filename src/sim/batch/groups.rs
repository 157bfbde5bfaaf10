//! Many states in groups of lanes.

use super::group::Group;
use crate::scalar::Scalar;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;

/// Many states in groups of `N`; the last state fills up the last group.
#[derive(Clone, Debug)]
pub(super) struct Groups<T: Scalar, const N: usize> {
    /// Number of states.
    pub(super) len: usize,
    pub(super) all: Vec<Group<T, N>>,
    /// Steps taken so far.
    pub(super) steps: usize,
}

impl<T: Scalar, const N: usize> Groups<T, N> {
    /// # Panics
    /// If a state has the wrong length.
    pub(super) fn new(simulator: &Simulator, states: &[State]) -> Self {
        states.iter().for_each(|state| simulator.check(state));
        let len = states.len();
        let mut all = vec![Group::new(simulator); len.div_ceil(N)];
        for i in 0..all.len() * N {
            all[i / N].set(i % N, &states[i.min(len - 1)]);
        }
        Self { len, all, steps: 0 }
    }

    /// The group of a state, and its lane there.
    ///
    /// # Panics
    /// If there is no such state.
    pub(super) fn at(&self, i: usize) -> (&Group<T, N>, usize) {
        self.check(i);
        (&self.all[i / N], i % N)
    }

    /// Sets one state, which runs again if it had stopped.
    ///
    /// # Panics
    /// If there is no such state, or if it has the wrong length.
    pub(super) fn set(&mut self, i: usize, state: &State) {
        self.check(i);
        self.all[i / N].set(i % N, state);
    }

    fn check(&self, i: usize) {
        assert!(i < self.len, "there are {} states, got state {i}", self.len);
    }
}
