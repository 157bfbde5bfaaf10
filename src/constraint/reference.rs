//! Reference acceleration of regularised rows: of contacts and of constraints.

use super::impedance::Impedance;
use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};

/// Coefficients b and k of the reference acceleration, which returns a point to the surface, or the error of a constraint to zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reference<P = f64> {
    /// As a damped oscillator, for any impedance: b = 2 / (`d_max` T), k = 1 / (`d_max` T ζ)².
    TimeConstant {
        /// T, s. A value below 1.9 time steps acts as 1.9 time steps, since a faster spring is unstable.
        time_constant: P,
        /// ζ; 1 is critically damped.
        damping_ratio: P,
    },
    /// As given: b = damping / `d_max`, k = stiffness / `d_max`².
    Direct {
        /// 1/s².
        stiffness: P,
        /// 1/s.
        damping: P,
    },
}

numbers! { pub enum Reference {
    TimeConstant {
        time_constant: Positive("time constant", "time constant of a reference acceleration"),
        damping_ratio: Positive("damping ratio", "damping ratio of a reference acceleration"),
    },
    Direct {
        stiffness: NotNegative("stiffness", "stiffness of a reference acceleration"),
        damping: NotNegative("damping", "damping of a reference acceleration"),
    },
} }

/// The shortest time constant, in time steps. A critically damped oscillator is stable from about one step on, and well damped from about two. `MuJoCo`'s
/// `refsafe` takes two; a little less keeps the default of 20 ms at steps of 10 ms away from the switch, where derivatives would be one-sided.
const LEAST_STEPS: f64 = 1.9;

impl<P: Scalar> Reference<P> {
    /// That of two surfaces: the mean of two time constants and damping ratios, the larger stiffness and damping, and these against a time constant.
    pub(crate) fn between(&self, other: &Self) -> Self {
        match (*self, *other) {
            (
                Self::TimeConstant {
                    time_constant,
                    damping_ratio,
                },
                Self::TimeConstant {
                    time_constant: other,
                    damping_ratio: second,
                },
            ) => Self::TimeConstant {
                time_constant: (time_constant + other) * 0.5,
                damping_ratio: (damping_ratio + second) * 0.5,
            },
            (
                Self::Direct { stiffness, damping },
                Self::Direct {
                    stiffness: other,
                    damping: second,
                },
            ) => Self::Direct {
                stiffness: stiffness.max(other),
                damping: damping.max(second),
            },
            (own @ Self::Direct { .. }, _) | (_, own) => own,
        }
    }

    /// b and k over a step of Δt.
    pub(crate) fn gains<T: Over<P>>(&self, impedance: &Impedance<P>, dt: T) -> (T, T) {
        let d = impedance.largest;
        match *self {
            Self::TimeConstant {
                time_constant,
                damping_ratio,
            } => {
                let rate = T::one() / (T::from(time_constant).max(dt * LEAST_STEPS) * d);
                let scaled = rate / T::from(damping_ratio);
                (rate * 2.0, scaled * scaled)
            }
            Self::Direct { stiffness, damping } => {
                (T::from(damping / d), T::from(stiffness / (d * d)))
            }
        }
    }
}
