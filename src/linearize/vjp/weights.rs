//! Weights with which gradients of accelerations are taken.

use crate::scalar::Scalar;
use crate::sim::Held;

/// Weights of what is found at a moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct AccelerationWeights<'a, T> {
    /// λ, of the acceleration.
    pub(super) a: &'a [T],
    /// Of what the step, or the rate at a moment, adds to the state of contact.
    pub(super) contact: &'a [T],
    /// Whether the gradient in friction is wanted.
    pub(super) has_friction: bool,
}

/// Acceleration at which the gradient of μᵀ r is taken.
#[derive(Clone, Copy, Debug)]
pub(super) struct Balanced<'a, T: Scalar> {
    pub(super) a: &'a [T],
    /// `true` for the acceleration that there would be without stops.
    pub(super) is_free: bool,
    /// See [`AccelerationWeights`].
    pub(super) contact: &'a [T],
    /// The rows of constraints that hold it, where it is the one without stops.
    pub(super) held: Option<HeldWeights<'a, T>>,
}

/// Rows of constraints with weights, at fixed forces and accelerations:  λᵀ y − μᵀ Jᵀ f.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeldWeights<'a, T> {
    /// λ.
    pub(super) y: &'a [T],
    /// ã.
    pub(super) seen: &'a [T],
    pub(super) rows: Held<'a, T>,
}
