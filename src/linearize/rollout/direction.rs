//! Directions in the start and the inputs of a rollout.

use nalgebra::DVector;

use crate::nested::IntoNested;
use crate::sim::Simulator;

/// A direction in the start and all inputs of a rollout, or a gradient in them.
#[derive(Clone, Debug, PartialEq)]
pub struct RolloutDirection {
    /// Along the tangent of the start (δq, δv, and the contact state where there is one), length [`Simulator::n_tangent`].
    pub start: DVector<f64>,
    /// Along the input of each step, length `nu` each.
    pub inputs: Vec<DVector<f64>>,
}

impl RolloutDirection {
    /// The zero direction, for a simulator and a number of steps.
    pub fn zeros(simulator: &Simulator, steps: usize) -> Self {
        Self {
            start: DVector::zeros(simulator.n_tangent()),
            inputs: vec![DVector::zeros(simulator.nu()); steps],
        }
    }

    /// All numbers, those of the start first.
    pub(super) fn numbers_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        let inputs = self.inputs.iter_mut().nested(|u| u.iter_mut());
        self.start.iter_mut().chain(inputs)
    }

    /// # Panics
    /// If it does not fit.
    pub(super) fn check(&self, simulator: &Simulator, steps: usize) {
        let (n, given) = (self.start.len(), self.inputs.len());
        let fits = n == simulator.n_tangent() && given == steps;
        let name = simulator.model().name();
        assert!(
            fits,
            "a direction with {n} start entries and {given} inputs does not fit {steps} steps of \"{name}\""
        );
        for u in &self.inputs {
            simulator.check_input(u.as_slice());
        }
    }
}
