//! Weights with which gradients of accelerations are taken.

use crate::scalar::Scalar;
use crate::sim::Held;

/// Weights of what is found at a moment.
#[derive(Clone, Copy, Debug)]
pub(in crate::sim::integrators) struct AccelerationWeights<'a, T> {
    /// λ, of the acceleration.
    pub(in crate::sim::integrators) a: &'a [T],
    /// Of what the step, or the rate at a moment, adds to the state of contact.
    pub(in crate::sim::integrators) contact: &'a [T],
    /// Whether the gradient in friction is wanted.
    pub(in crate::sim::integrators) has_friction: bool,
}

/// Acceleration at which the gradient of μᵀ r is taken.
#[derive(Clone, Copy, Debug)]
pub(in crate::sim::integrators) struct Balanced<'a, T: Scalar> {
    pub(in crate::sim::integrators) a: &'a [T],
    /// `true` for the acceleration that there would be without stops.
    pub(in crate::sim::integrators) is_free: bool,
    /// See [`AccelerationWeights`].
    pub(in crate::sim::integrators) contact: &'a [T],
    /// The rows of constraints that hold it, where it is the one without stops.
    pub(in crate::sim::integrators) held: Option<HeldWeights<'a, T>>,
}

/// Rows of constraints with weights, at fixed forces and accelerations:  λᵀ y − μᵀ Jᵀ f.
#[derive(Clone, Copy, Debug)]
pub(in crate::sim::integrators) struct HeldWeights<'a, T> {
    /// λ.
    pub(in crate::sim::integrators) y: &'a [T],
    /// ã.
    pub(in crate::sim::integrators) seen: &'a [T],
    pub(in crate::sim::integrators) rows: Held<'a, T>,
}
