//! Jacobians of the steps of a batch, and their products with vectors.

use super::{Linearization, LinearizeScratch, StepGradient, VjpScratch};
use crate::sim::{BatchSimulator, State, for_each_part};

impl BatchSimulator {
    /// Computes the Jacobians of the step from each state, on as many threads as the simulator uses; those of
    /// [`Simulator::linearize`](crate::Simulator::linearize), bit for bit. Allocates.
    ///
    /// * `inputs` – the input of one state after the other, length `len` × `nu` (N·m or N)
    ///
    /// # Panics
    /// If states or inputs are not as many as the simulator was made for, or if a state has the wrong length.
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
        let nu = self.nu();
        assert_eq!(states.len(), self.len(), "the number of states");
        assert_eq!(inputs.len(), self.len() * nu, "len × nu inputs");
        let mut out: Vec<_> = (0..self.len())
            .map(|i| Linearization::zeros(self.simulator(i)))
            .collect();
        let template = self.template();
        let memory = (
            template.model().generation(),
            LinearizeScratch::new(template),
        );
        let mut workers = vec![memory; self.threads()];
        for_each_part(&mut workers, &mut out, |(of, scratch), i, out| {
            let (simulator, u) = (self.simulator(i), &inputs[i * nu..(i + 1) * nu]);
            let generation = simulator.model().generation();
            if generation != *of {
                (*of, *scratch) = (generation, LinearizeScratch::new(simulator));
            }
            simulator.linearize_into(&states[i], u, scratch, out);
        });
        out
    }

    /// Computes the gradients of λᵀ x⁺ of the steps from all states in state, input and parameters, on as many threads as the simulator uses; those of
    /// [`Simulator::vjp`](crate::Simulator::vjp), bit for bit. Allocates.
    ///
    /// * `inputs` – the input of one state after the other, length `len` × `nu` (N·m or N)
    /// * `adjoints` – λ of one state after the other, length `len` × [`n_tangent`](crate::Simulator::n_tangent)
    ///
    /// # Panics
    /// If states, inputs or adjoints are not as many as the simulator was made for, if a state has the wrong length, or if there are kinematic
    /// constraints.
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
        let (template, nu) = (self.template(), self.nu());
        let n = template.n_tangent();
        assert_eq!(states.len(), self.len(), "the number of states");
        assert_eq!(inputs.len(), self.len() * nu, "len × nu inputs");
        assert_eq!(adjoints.len(), self.len() * n, "len × n_tangent weights");
        let mut out: Vec<_> = (0..self.len())
            .map(|i| StepGradient::zeros(self.simulator(i)))
            .collect();
        let mut workers = vec![VjpScratch::new(template); self.threads()];
        for_each_part(&mut workers, &mut out, |scratch, i, out| {
            let simulator = self.simulator(i);
            if !scratch.is_of(simulator) {
                *scratch = VjpScratch::new(simulator);
            }
            let (u, adjoint) = (&inputs[i * nu..(i + 1) * nu], &adjoints[i * n..(i + 1) * n]);
            simulator.vjp_into(&states[i], u, adjoint, scratch, out);
        });
        out
    }
}
