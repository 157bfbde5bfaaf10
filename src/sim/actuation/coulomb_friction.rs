//! Dry friction of joints.

use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};

/// Dry friction: a force of at most f against the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoulombFriction<P = f64> {
    /// f, N·m or N.
    pub force: P,
    /// `v_s` of the smoothed law, rad/s or m/s: at this speed 71 % of the force act. Smaller holds better at rest (under a force τ = r f it creeps at
    /// `v_s` r / √(1 − r²)) and makes the joint stiffer against small motion: steps of Runge and Kutta must be shorter than about 2 I `v_s` / f with an
    /// inertia I, those of the other integrators need not.
    pub slip_velocity: P,
    /// Law of the force.
    pub law: FrictionLaw,
}

/// Law of dry friction between rest and motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionLaw {
    /// Stick and slip. Over a step the force τ is that with which |τ| ≤ f, and
    ///
    /// > v⁺ = 0,  or  τ = −f where v⁺ > 0,  or  τ = f where v⁺ < 0
    ///
    /// for the velocity v⁺ = v + Δt v̇ after it: a joint at rest stays exactly there until more than f acts on it. Derivatives are those of the joint
    /// that is held, or that of one that slides under a constant force; where it starts or stops sliding, those of one side.
    ///
    /// Both methods of Euler simulate it. At an instant, with Runge and Kutta's method and with the implicit midpoint rule the force is that of the
    /// [smoothed](Self::Smoothed) law, which [`Simulator::remarks`](crate::Simulator::remarks) says.
    Exact,
    /// τ = −f v / √(v² + `v_s²`), smooth through rest, where it creeps.
    Smoothed,
}

numbers! { pub struct CoulombFriction {
    force: NotNegative("Coulomb friction", "force of Coulomb friction"),
    slip_velocity: Positive("slip velocity", "slip velocity of Coulomb friction"),
    law: kept(),
} }

/// Slip velocity of joints whose file says no more than the force of friction: rad/s or m/s.
const DEFAULT_SLIP_VELOCITY: f64 = 1e-2;

impl<P: Scalar> CoulombFriction<P> {
    /// Friction that holds, of a force f in N·m or N. The slip velocity of integrators that smooth it is 0.01 rad/s or m/s.
    pub fn exact(force: P) -> Self {
        Self {
            law: FrictionLaw::Exact,
            ..Self::smoothed(force, P::constant(DEFAULT_SLIP_VELOCITY))
        }
    }

    /// Friction that is smooth through rest.
    ///
    /// * `force` – f, N·m or N
    /// * `slip_velocity` – `v_s`, rad/s or m/s
    pub fn smoothed(force: P, slip_velocity: P) -> Self {
        Self {
            force,
            slip_velocity,
            law: FrictionLaw::Smoothed,
        }
    }

    /// The force of the smoothed law.
    pub(crate) fn force<T: Over<P>>(&self, v: T) -> T {
        -(v * self.damping(v))
    }

    /// f / √(v² + `v_s²`)
    pub(super) fn damping<T: Over<P>>(&self, v: T) -> T {
        let slip = T::from(self.slip_velocity);
        T::from(self.force) / (v * v + slip * slip).sqrt()
    }
}
