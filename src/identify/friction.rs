//! Dry friction of joints as a function of velocity with an unknown factor.

use crate::scalar::Over;
use crate::sim::CoulombFriction;

/// Shape of dry friction along a velocity: −f s(v) with the unknown force f.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum DryFriction {
    /// s = v / √(v² + `v_s²`), that of [`CoulombFriction`](crate::sim::CoulombFriction): the one for simulation.
    Smooth {
        /// `v_s`, rad/s or m/s, positive: at this speed 71 % of the force act.
        slip_velocity: f64,
    },
    /// s = sign(v). Equations of a joint below the speed of the dead zone are dropped, since the force may be any value between −f and f there.
    Sign {
        /// Speed up to which the sign of the velocity is not known, rad/s or m/s, not negative: some standard deviations of its error.
        dead_zone: f64,
    },
}

impl DryFriction {
    /// Computes s(v).
    pub(crate) fn shape<T: Over<f64>>(self, v: T) -> T {
        match self {
            Self::Smooth { slip_velocity } => {
                // The friction of a simulator, whose force opposes the velocity.
                -CoulombFriction::smoothed(1.0, slip_velocity).force(v)
            }
            Self::Sign { .. } => {
                let (zero, one) = (T::zero(), T::one());
                v.select_lt(zero, -one, zero.select_lt(v, one, zero))
            }
        }
    }

    /// Whether the force at a velocity is known up to a factor.
    pub(super) fn is_known(self, v: f64) -> bool {
        match self {
            Self::Smooth { .. } => true,
            Self::Sign { dead_zone } => v.abs() > dead_zone,
        }
    }

    /// The parameter of the shape: its name and whether it is in its range.
    pub(super) fn number(self) -> (&'static str, f64, bool) {
        match self {
            Self::Smooth { slip_velocity: v } => ("slip velocity", v, v > 0.0 && v.is_finite()),
            Self::Sign { dead_zone: v } => ("dead zone", v, v >= 0.0 && v.is_finite()),
        }
    }
}
