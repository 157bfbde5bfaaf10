//! The traits of a method of integration: its step, the Jacobians of that, its gradient. Working memory is the implementor.

use nalgebra::DMatrix;

use super::AccelerationScratch;
use crate::cone::Status;
use crate::dynamics::Calls;
use crate::scalar::{Differentiable, Over, Scalar};
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::StepGradientSum;

/// A step.
pub(crate) trait Step<T: Scalar> {
    /// Makes memory for a simulator.
    fn new<P: Scalar>(simulator: &Simulator<P>) -> Self;

    /// Takes a step with the input `u` held. Evaluations of the acceleration leave what they find in `found`.
    fn step<P: Scalar>(
        &mut self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        found: &mut AccelerationScratch<T>,
        next: &mut State<T>,
    ) where
        T: Over<P>;

    /// Status of the search of the method's own in the last step, in a lane.
    fn status(&self, _lane: usize) -> Status {
        Status::Converged
    }
}

/// A point at which a step is differentiated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepPoint<'a, T: Scalar = f64> {
    pub(crate) state: &'a State<T>,
    pub(crate) u: &'a [T],
    /// The acceleration, where the step has been taken before. Methods of several accelerations do without.
    pub(crate) acceleration: Option<&'a [T]>,
}

/// The Jacobians of a step, which are written:  δx⁺ = A δx + B δu.
pub(crate) struct StepColumns<'a, T> {
    /// A, `n_tangent` × `n_tangent`.
    pub(crate) a: &'a mut DMatrix<T>,
    /// B, `n_tangent` × `nu`.
    pub(crate) b: &'a mut DMatrix<T>,
}

/// The Jacobians of a step.
pub(crate) trait Pushforward<T: Differentiable> {
    /// Makes memory for a simulator.
    fn new(simulator: &Simulator, calls: Calls) -> Self;

    /// Writes A and B.
    fn linearize(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        out: &mut StepColumns<'_, T>,
    );
}

/// The gradient of a weighted sum of the next state's entries.
pub(crate) trait Pullback<T: Scalar> {
    /// Makes memory for a simulator.
    fn new(simulator: &Simulator, calls: Calls) -> Self;

    /// Adds the gradient of λᵀ x⁺.
    ///
    /// * `adjoint` – λ, along the tangent of the next state
    fn add_gradient(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        adjoint: &[T],
        out: &mut StepGradientSum<'_, T>,
    );
}
