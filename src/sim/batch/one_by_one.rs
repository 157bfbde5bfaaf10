//! The states of a group one by one, for CPUs without registers for lanes.

use super::group::Group;
use super::readout::{Readout, SensorMemory};
use super::{BATCH_WIDTH, BatchScalar};
use crate::cone::Status;
use crate::dynamics::Calls;
use crate::scalar::Lanes;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::step::StepScratch;

/// Working memory of a thread that steps the states of a group one by one.
#[derive(Debug)]
pub(super) struct OneByOne {
    scratch: StepScratch<f64>,
    state: State,
    next: State,
    /// Those of the group.
    next_group: State<BatchScalar>,
    u: Vec<BatchScalar>,
    u_lane: Vec<f64>,
    /// From the first reading of sensors on.
    sensors: Option<Box<SensorMemory<f64>>>,
}

impl OneByOne {
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            // Not bound to the numbers of one model: variants use it in turn.
            scratch: StepScratch::for_calls(simulator, Calls::One),
            state: simulator.neutral_state(),
            next: simulator.neutral_state(),
            next_group: simulator.neutral_state(),
            u: vec![Lanes([0.0; BATCH_WIDTH]); simulator.nu()],
            u_lane: Vec::with_capacity(simulator.nu()),
            sensors: None,
        }
    }

    /// Lets `control` set the input of a group, which starts at zero.
    #[inline]
    pub(super) fn set_input(
        &mut self,
        group: &Group<BatchScalar, BATCH_WIDTH>,
        control: impl FnOnce(&State<BatchScalar>, &mut [BatchScalar]),
    ) {
        self.u.fill(Lanes([0.0; BATCH_WIDTH]));
        control(&group.state, &mut self.u);
    }

    /// Takes a step of a group with the input that was set.
    ///
    /// * `simulator` – that of a lane
    pub(super) fn step<'a>(
        &mut self,
        simulator: impl Fn(usize) -> &'a Simulator,
        step: usize,
        group: &mut Group<BatchScalar, BATCH_WIDTH>,
    ) {
        self.step_with(simulator, step, group, |_, _, _| {});
    }

    /// [`step`](Self::step), and the readings of sensors in it.
    #[inline]
    pub(super) fn step_and_read<'a>(
        &mut self,
        simulator: impl Fn(usize) -> &'a Simulator,
        step: usize,
        group: &mut Group<BatchScalar, BATCH_WIDTH>,
        readout: &mut Readout<'_>,
    ) {
        let read = |own: &mut Self, simulator: &Simulator, lane: usize| {
            let at = (simulator, &own.state, own.u_lane.as_slice());
            readout.read(at, &own.scratch, &mut own.sensors, lane);
        };
        self.step_with(simulator, step, group, read);
    }

    /// [`step`](Self::step), with a function that is called after the step of each lane.
    #[inline]
    fn step_with<'a>(
        &mut self,
        simulator: impl Fn(usize) -> &'a Simulator,
        step: usize,
        group: &mut Group<BatchScalar, BATCH_WIDTH>,
        mut taken: impl FnMut(&mut Self, &Simulator, usize),
    ) {
        let mut status = [Status::Converged; BATCH_WIDTH];
        for (lane, status) in status.iter_mut().enumerate() {
            self.step_lane(simulator(lane), lane, &group.state);
            taken(self, simulator(lane), lane);
            *status = self.scratch.solver_status(0);
        }
        group.watch_solver(step, |lane| status[lane]);
        let bound = simulator(0).divergence_bound();
        group.accept(step, &self.u, &mut self.next_group, bound);
    }

    fn step_lane(&mut self, simulator: &Simulator, lane: usize, group: &State<BatchScalar>) {
        let numbers = self.state.numbers_mut().zip(group.numbers());
        numbers.for_each(|(own, all)| *own = all.0[lane]);
        self.u_lane.clear();
        self.u_lane.extend(self.u.iter().map(|u| u.0[lane]));
        let u = &self.u_lane;
        simulator.step_into(&self.state, u, &mut self.scratch, &mut self.next);
        let numbers = self.next_group.numbers_mut().zip(self.next.numbers());
        numbers.for_each(|(all, own)| all.0[lane] = *own);
    }
}
