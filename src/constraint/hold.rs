//! Force law of a constraint: rigid, a spring and damper, or regularised.

use super::regularisation::{Regularisation, SoftGains};
use crate::numbers::numbers;
use crate::scalar::{Over, Scalar};

/// Means by which the rows of a constraint go back to zero, with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ForceLaw<P> {
    /// No motion except the correction of errors.
    Rigid {
        /// T, s.
        time_constant: P,
    },
    /// f = −k φ − d φ̇.
    Spring {
        /// k, N/m or N·m/rad.
        stiffness: P,
        /// d, N·s/m or N·m·s/rad.
        damping: P,
    },
    /// φ̈ + b φ̇ + k d φ + R f = 0.
    Soft(Regularisation<P>),
}

numbers! { enum ForceLaw {
    Rigid { time_constant: Positive("time constant", "time constant of a constraint") },
    Spring {
        stiffness: NotNegative("stiffness", "stiffness of a constraint"),
        damping: NotNegative("damping", "damping of a constraint"),
    },
    Soft(own: part(Regularisation)),
} }

/// Force laws of the rows of a constraint at a state.
#[derive(Clone, Copy, Debug)]
pub(super) enum Holds<T> {
    /// One for all rows.
    Alike(Hold<T>),
    /// Regularised rows.
    Soft(SoftGains<T>),
}

impl<P: Scalar> ForceLaw<P> {
    /// Those at a state.
    ///
    /// * `squares` – |p|² and |θ|² of the errors, for a regularised constraint
    /// * `dt` – the step, s
    #[inline]
    pub(super) fn at<T: Over<P>>(&self, squares: impl FnOnce() -> [T; 2], dt: T) -> Holds<T> {
        match self {
            Self::Rigid { time_constant } => Holds::Alike(Hold::Rigid {
                time_constant: (*time_constant).into(),
            }),
            Self::Spring { stiffness, damping } => Holds::Alike(Hold::Spring {
                stiffness: (*stiffness).into(),
                damping: (*damping).into(),
            }),
            Self::Soft(own) => Holds::Soft(own.gains(squares(), dt)),
        }
    }
}

impl<T: Scalar> Holds<T> {
    /// That of a row.
    #[inline]
    pub(super) fn row(&self, error: T, rate: T, is_angular: bool) -> Hold<T> {
        match self {
            Self::Alike(hold) => *hold,
            Self::Soft(gains) => gains.hold(error, rate, is_angular),
        }
    }
}

/// Force law of a row at a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Hold<T> {
    /// No motion except the correction of errors.
    Rigid {
        /// T, s.
        time_constant: T,
    },
    /// f = −k φ − d φ̇.
    Spring {
        /// k, N/m or N·m/rad.
        stiffness: T,
        /// d, N·s/m or N·m·s/rad.
        damping: T,
    },
    /// φ̈ + p + R f = 0.
    Soft {
        /// p = b φ̇ + k d φ, the negative reference acceleration, m/s² or rad/s².
        pull: T,
        /// R, 1/kg or 1/(kg m²).
        compliance: T,
    },
}

impl<T> Hold<T> {
    /// Converts the numbers to another scalar.
    pub(crate) fn map<L>(self, to: impl Fn(T) -> L) -> Hold<L> {
        match self {
            Self::Rigid { time_constant } => Hold::Rigid {
                time_constant: to(time_constant),
            },
            Self::Spring { stiffness, damping } => Hold::Spring {
                stiffness: to(stiffness),
                damping: to(damping),
            },
            Self::Soft { pull, compliance } => Hold::Soft {
                pull: to(pull),
                compliance: to(compliance),
            },
        }
    }
}

impl<T: Scalar> SoftGains<T> {
    /// The law of a row.
    pub(crate) fn hold(&self, error: T, rate: T, is_angular: bool) -> Hold<T> {
        Hold::Soft {
            pull: self.damping * rate + self.stiffness * error,
            compliance: self.share * self.inverses[usize::from(is_angular)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraint::Impedance;

    // `MuJoCo`'s manual: b = 2 / (d_max T), k = 1 / (d_max T ζ)², R = (1 − d) / d w; the error of 3 mm and 8 mrad at ½ m is 5 mm, where d is the largest.
    #[test]
    fn rows_equal_the_documented_formulas() {
        let own = Regularisation {
            inverse_mass: 3.0,
            inverse_inertia: 7.0,
            impedance: Impedance {
                width: 5e-3,
                ..Impedance::default()
            },
            ..Regularisation::default()
        };
        let gains = own.gains([9e-6_f64, 64e-6], 1e-3);
        let (b, k) = (2.0 / (0.95 * 0.02), (0.95_f64 * 0.02).powi(-2));
        for (is_angular, w) in [(false, 3.0), (true, 7.0)] {
            let Hold::Soft { pull, compliance } = gains.hold(3e-3, -0.2, is_angular) else {
                panic!("a soft row")
            };
            let expected = -b * 0.2 + k * 0.95 * 3e-3;
            assert!((pull - expected).abs() < 1e-12 * expected.abs());
            assert!((compliance - 0.05 / 0.95 * w).abs() < 1e-12);
        }
    }

    #[test]
    fn gains_without_error_are_those_of_the_least_impedance() {
        let gains = Regularisation::default().gains([0.0, 0.0], 1e-3);
        assert!((gains.share - 0.1 / 0.9_f64).abs() < 1e-12);
    }
}
