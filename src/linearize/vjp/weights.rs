//! Weights with which gradients of accelerations are taken.

/// Weights of what is found at a moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct AccelerationWeights<'a> {
    /// λ, of the acceleration.
    pub(super) a: &'a [f64],
    /// Of what the step, or the rate at a moment, adds to the state of contact.
    pub(super) contact: &'a [f64],
    /// Whether the gradient in friction is wanted.
    pub(super) has_friction: bool,
}

/// Acceleration at which the gradient of μᵀ r is taken.
#[derive(Clone, Copy, Debug)]
pub(super) struct Balanced<'a> {
    pub(super) a: &'a [f64],
    /// `true` for the acceleration that there would be without stops.
    pub(super) is_free: bool,
    /// See [`AccelerationWeights`].
    pub(super) contact: &'a [f64],
}
