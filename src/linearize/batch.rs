//! Jacobians of the steps of a batch, and their products with vectors.

use super::{Linearization, LinearizeScratch, StepGradient, VjpScratch};
use crate::model::Generation;
use crate::parallel::for_each_part;
use crate::sim::{BatchSimulator, Simulator, State};

/// Working memory of derivatives of a step.
trait StepMemory: Clone + Send {
    /// The derivatives.
    type Out: Send;

    fn memory(simulator: &Simulator) -> Self;
    fn is_of(&self, simulator: &Simulator) -> bool;
    fn zeros(simulator: &Simulator) -> Self::Out;
}

/// Memory of Jacobians, with the model that it belongs to.
type OfModel = (Generation, LinearizeScratch);

impl StepMemory for OfModel {
    type Out = Linearization;

    fn memory(simulator: &Simulator) -> Self {
        (
            simulator.model().generation(),
            LinearizeScratch::new(simulator),
        )
    }

    fn is_of(&self, simulator: &Simulator) -> bool {
        self.0 == simulator.model().generation()
    }

    fn zeros(simulator: &Simulator) -> Linearization {
        Linearization::zeros(simulator)
    }
}

impl StepMemory for VjpScratch {
    type Out = StepGradient;

    fn memory(simulator: &Simulator) -> Self {
        Self::new(simulator)
    }

    fn is_of(&self, simulator: &Simulator) -> bool {
        self.belongs_to(simulator)
    }

    fn zeros(simulator: &Simulator) -> StepGradient {
        StepGradient::zeros(simulator)
    }
}

impl BatchSimulator {
    /// Computes the Jacobians of the step from each state, on the threads of the simulator; bit-identical to
    /// [`Simulator::linearize_into`](crate::Simulator::linearize_into). Allocates.
    ///
    /// * `inputs` – the input of one state after the other, length `len` × `nu` (N·m or N)
    ///
    /// # Panics
    /// If the number of states or inputs is wrong, or a state has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, sim::BatchSimulator};
    ///
    /// let pendulum = Simulator::new(samples::pendulum());
    /// let states: Vec<State> = (0..10).map(|k| State::new(&[0.1 * k as f64], &[0.0])).collect();
    /// let all = BatchSimulator::new(pendulum.clone(), 10).linearize(&states, &[0.0; 10]);
    /// assert_eq!(all[3], pendulum.linearize(&states[3], &[0.0]));
    /// ```
    pub fn linearize(&self, states: &[State], inputs: &[f64]) -> Vec<Linearization> {
        self.differentiate(states, inputs, |i, u, (_, scratch): &mut OfModel, out| {
            let simulator = self.simulator(i);
            simulator.linearize_into(&states[i], u, scratch, out);
        })
    }

    /// Computes the gradients of λᵀ x⁺ of the steps from all states in state, input and parameters, on the threads of the simulator; bit-identical to
    /// [`Simulator::vjp`](crate::Simulator::vjp). Allocates.
    ///
    /// * `inputs` – the input of one state after the other, length `len` × `nu` (N·m or N)
    /// * `adjoints` – λ of one state after the other, length `len` × [`n_tangent`](crate::Simulator::n_tangent)
    ///
    /// # Panics
    /// If the number of states, inputs or adjoints is wrong, or a state has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, sim::BatchSimulator};
    ///
    /// let pendulum = Simulator::new(samples::pendulum());
    /// let states: Vec<State> = (0..10).map(|k| State::new(&[0.1 * k as f64], &[0.0])).collect();
    /// let all = BatchSimulator::new(pendulum.clone(), 10).vjp(&states, &[0.0; 10], &[1.0; 20]);
    /// assert_eq!(all[3], pendulum.vjp(&states[3], &[0.0], &[1.0, 1.0]));
    /// ```
    pub fn vjp(&self, states: &[State], inputs: &[f64], adjoints: &[f64]) -> Vec<StepGradient> {
        let n = self.template().n_tangent();
        assert_eq!(
            adjoints.len(),
            self.len() * n,
            "number of weights, given and expected: n_tangent for each state"
        );
        self.differentiate(states, inputs, |i, u, scratch: &mut VjpScratch, out| {
            let (simulator, adjoint) = (self.simulator(i), &adjoints[i * n..(i + 1) * n]);
            simulator.vjp_into(&states[i], u, adjoint, scratch, out);
        })
    }

    /// Passes each state's index, input, working memory and result to `work`, on all threads.
    fn differentiate<S: StepMemory>(
        &self,
        states: &[State],
        inputs: &[f64],
        work: impl Fn(usize, &[f64], &mut S, &mut S::Out) + Sync,
    ) -> Vec<S::Out> {
        let nu = self.nu();
        assert_eq!(
            states.len(),
            self.len(),
            "number of states, given and of the batch"
        );
        assert_eq!(
            inputs.len(),
            self.len() * nu,
            "number of inputs, given and expected: nu for each state"
        );
        let zeros = (0..self.len()).map(|i| S::zeros(self.simulator(i)));
        let mut out: Vec<_> = zeros.collect();
        let memory = |_| S::memory(self.template());
        let mut workers: Vec<S> = (0..self.threads()).map(memory).collect();
        for_each_part(&mut workers, &mut out, |scratch, i, out| {
            let simulator = self.simulator(i);
            if !scratch.is_of(simulator) {
                *scratch = S::memory(simulator);
            }
            work(i, &inputs[i * nu..(i + 1) * nu], scratch, out);
        });
        out
    }
}
