//! Dry friction of joints.

use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};

/// Dry friction: a force of at most f against the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoulombFriction<P = f64> {
    /// f, N·m or N.
    pub force: P,
    /// `v_s` of the smoothed law, rad/s or m/s: at this speed 71 % of the force acts. A smaller value holds better at rest: under a force τ = r f the
    /// joint creeps at `v_s` r / √(1 − r²). It also makes the joint stiffer against small motion: with an inertia I, Runge–Kutta steps must be
    /// shorter than about 2 I `v_s` / f; the other integrators have no such limit.
    pub slip_velocity: P,
    /// Law of the friction force.
    pub law: FrictionLaw,
}

/// Law of dry friction between rest and motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionLaw {
    /// Stick and slip. Over a step the force τ satisfies |τ| ≤ f, and
    ///
    /// > v⁺ = 0,  or  τ = −f where v⁺ > 0,  or  τ = f where v⁺ < 0
    ///
    /// for the velocity v⁺ = v + Δt v̇ after the step. A joint at rest stays exactly at rest until more than f acts on it. Derivatives are those of a
    /// joint that is held or that slides under a constant force; at the transition they are those of one side.
    ///
    /// Both Euler methods simulate it. Runge–Kutta, the implicit midpoint rule and evaluations at an instant use the [smoothed](Self::Smoothed) law
    /// instead; [`Simulator::remarks`](crate::Simulator::remarks) reports this.
    Exact,
    /// τ = −f v / √(v² + `v_s²`), smooth through rest. A loaded joint creeps.
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
    /// Friction that holds a joint at rest, with the force f in N·m or N. Integrators that smooth it use a slip velocity of 0.01 rad/s or m/s.
    ///
    /// A small input does not move a joint at rest, so B is zero there: design regulators without friction, or with [`smoothed`](Self::smoothed).
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
