//! Working memory of a thread that steps groups of states.

use super::group::Group;
use super::readout::SensorMemory;
use crate::scalar::{Over, Scalar};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::step::StepScratch;

/// Working memory of a thread.
#[derive(Clone, Debug)]
pub(super) struct Worker<T: Scalar> {
    scratch: StepScratch<T>,
    next: State<T>,
    u: Vec<T>,
    /// From the first reading of sensors on.
    sensors: Option<Box<SensorMemory<T>>>,
}

impl<T: Scalar> Worker<T> {
    #[inline]
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            scratch: StepScratch::new(simulator),
            next: simulator.neutral_state(),
            u: vec![T::zero(); simulator.nu()],
            sensors: None,
        }
    }

    /// Lets `control` set the input of a group, which starts at zero.
    #[inline]
    pub(super) fn set_input<const N: usize>(
        &mut self,
        group: &Group<T, N>,
        control: impl FnOnce(&State<T>, &mut [T]),
    ) {
        self.u.fill(T::zero());
        control(&group.state, &mut self.u);
    }

    /// Takes a step of a group with the input that was set.
    #[inline]
    pub(super) fn step<P: Scalar, const N: usize>(
        &mut self,
        simulator: &Simulator<P>,
        step: usize,
        group: &mut Group<T, N>,
    ) where
        T: Over<P>,
    {
        self.step_with(simulator, step, group, |_, _, _, _| {});
    }

    /// [`step`](Self::step), with a function that is called between the step and the change of the states.
    #[inline]
    pub(super) fn step_with<P: Scalar, const N: usize>(
        &mut self,
        simulator: &Simulator<P>,
        step: usize,
        group: &mut Group<T, N>,
        taken: impl FnOnce(&State<T>, &[T], &StepScratch<T>, &mut Option<Box<SensorMemory<T>>>),
    ) where
        T: Over<P>,
    {
        let Self {
            scratch,
            next,
            u,
            sensors,
        } = self;
        simulator.step_into(&group.state, u, scratch, next);
        taken(&group.state, u, scratch, sensors);
        group.watch_solver(step, |lane| scratch.solver_status(lane));
        group.accept(step, u, next, simulator.divergence_bound());
    }
}
