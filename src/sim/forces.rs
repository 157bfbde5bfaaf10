//! Sums of the forces of all terms at an instant.

use super::simulator::Simulator;
use crate::scalar::Scalar;
use crate::spatial::Force;

/// Forces along coordinates and on bodies, and the implicit damping diagonal.
#[derive(Clone, Debug)]
pub(crate) struct Forces<T> {
    /// Along the coordinates, at a = 0: N·m or N.
    pub(crate) tau: Vec<T>,
    /// Implicit damping diagonal Δt c + Δt² k, added to M, kg·m² or kg: decrease of forces at the end of a step with the acceleration. Unused if all
    /// forces are those of the state.
    pub(crate) resistance: Vec<T>,
    /// On each body, in the body; empty for robots on whose bodies nothing acts.
    pub(crate) bodies: Vec<Force<T>>,
}

impl<T: Scalar> Forces<T> {
    /// Makes memory for a simulator.
    pub(crate) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let model = simulator.model();
        let zeros = || vec![T::zero(); model.nv()];
        let touches = simulator
            .contacts()
            .is_some_and(|c| !c.are_solved_explicitly());
        let is_pushed = touches || !simulator.frame_terms().is_empty();
        let bodies = if is_pushed { model.n_bodies() } else { 0 };
        Self {
            tau: zeros(),
            resistance: zeros(),
            bodies: vec![Force::zero(); bodies],
        }
    }

    /// Starts anew without forces.
    pub(super) fn clear(&mut self) {
        self.tau.fill(T::zero());
        self.bodies.fill(Force::zero());
    }
}
