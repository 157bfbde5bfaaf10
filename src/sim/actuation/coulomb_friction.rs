//! Dry friction of joints.

use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};

/// Dry friction, smooth through rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoulombFriction<P = f64> {
    /// f, N·m or N.
    pub force: P,
    /// `v_s`, rad/s or m/s: at this speed 71 % of the force act. Smaller holds better at rest (under a force τ = r f it creeps at `v_s` r / √(1 − r²)) and
    /// makes the joint stiffer against small motion: steps of Runge and Kutta must be shorter than about 2 I `v_s` / f with an inertia I, those
    /// of the other integrators need not.
    pub slip_velocity: P,
}

numbers! { pub struct CoulombFriction {
    force: NotNegative("Coulomb friction", "force of Coulomb friction"),
    slip_velocity: Positive("slip velocity", "slip velocity of Coulomb friction"),
} }

impl<P: Scalar> CoulombFriction<P> {
    pub(crate) fn force<T: Over<P>>(&self, v: T) -> T {
        -(v * self.damping(v))
    }

    /// f / √(v² + `v_s²`)
    pub(super) fn damping<T: Over<P>>(&self, v: T) -> T {
        let slip = T::from(self.slip_velocity);
        T::from(self.force) / (v * v + slip * slip).sqrt()
    }
}
