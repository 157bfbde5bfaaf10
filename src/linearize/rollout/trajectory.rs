//! The states of a rollout in its backward pass: stored, or recomputed from stored ones.

use nalgebra::DVector;

use crate::sim::{RolloutStatus, Simulator, State, StepPoint, StepScratch, most_states};

/// States that are kept, and all states of one stretch between two of them.
pub(super) struct Trajectory {
    scratch: StepScratch<f64>,
    interval: usize,
    /// The first state of each stretch.
    kept: Vec<State>,
    /// The states of a stretch, and the first of the next.
    stretch: Vec<State>,
    /// The accelerations of its steps, in sequence.
    accelerations: Vec<f64>,
    /// Index of that stretch.
    present: usize,
    /// Number of steps.
    steps: usize,
}

impl Trajectory {
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            scratch: StepScratch::awake(simulator),
            interval: 1,
            kept: Vec::new(),
            stretch: Vec::new(),
            accelerations: Vec::new(),
            present: 0,
            steps: 0,
        }
    }

    /// Takes the steps from `start`; afterwards the last stretch is there.
    pub(super) fn roll(
        &mut self,
        simulator: &Simulator,
        start: &State,
        inputs: &[DVector<f64>],
        interval: usize,
    ) -> RolloutStatus {
        (self.interval, self.steps) = (interval, 0);
        self.kept.clear();
        self.kept.push(start.clone());
        let mut longest = interval.min(inputs.len()) + 1;
        // With an acceleration beside each state.
        let kept = longest + inputs.len() / interval;
        let fits = kept <= most_states(start, simulator.model().nv());
        if !fits {
            longest = 1;
        }
        self.stretch.resize_with(longest, || start.clone());
        self.stretch[0].clone_from(start);
        let nv = simulator.model().nv();
        self.accelerations.resize(nv * longest, 0.0);
        self.present = 0;
        if !fits {
            return RolloutStatus::OutOfMemory { step: 0 };
        }
        let bound = simulator.divergence_bound();
        for (step, u) in inputs.iter().enumerate() {
            if let Some(status) = RolloutStatus::before(step, u.as_slice(), 0..1) {
                return status;
            }
            if step > 0 && step % interval == 0 {
                let first = self.stretch[interval].clone();
                self.stretch[0].clone_from(&first);
                self.kept.push(first);
                self.present += 1;
            }
            let next = self.step(simulator, step, u);
            if let Some(status) = RolloutStatus::after(step, next, bound, 0..1) {
                return status;
            }
            self.steps += 1;
        }
        RolloutStatus::Completed
    }

    /// The last state that was reached.
    pub(super) fn last(&self) -> &State {
        &self.stretch[self.steps - self.present * self.interval]
    }

    /// Finds the segment of a step, for steps from the last to the first.
    pub(super) fn find(&mut self, simulator: &Simulator, inputs: &[DVector<f64>], step: usize) {
        let stretch = step / self.interval;
        if stretch == self.present {
            return;
        }
        self.present = stretch;
        self.stretch[0].clone_from(&self.kept[stretch]);
        let first = stretch * self.interval;
        for (k, u) in (first..).zip(&inputs[first..first + self.interval]) {
            self.step(simulator, k, u);
        }
    }

    /// A step of the stretch with the input `u`, which has been taken.
    pub(super) fn at<'a>(&'a self, step: usize, u: &'a [f64]) -> StepPoint<'a> {
        let local = step - self.present * self.interval;
        let nv = self.stretch[local].v.len();
        StepPoint {
            state: &self.stretch[local],
            u,
            acceleration: Some(&self.accelerations[nv * local..nv * (local + 1)]),
        }
    }

    /// Takes a step of the present stretch.
    fn step(&mut self, simulator: &Simulator, step: usize, u: &DVector<f64>) -> &State {
        let local = step - self.present * self.interval;
        let (before, after) = self.stretch.split_at_mut(local + 1);
        simulator.step_into(
            &before[local],
            u.as_slice(),
            &mut self.scratch,
            &mut after[0],
        );
        let a = &self.scratch.acceleration().a;
        let nv = a.len();
        self.accelerations[nv * local..nv * (local + 1)].copy_from_slice(a);
        &after[0]
    }
}
