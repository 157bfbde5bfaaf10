//! Force law of a constraint: rigid, or a spring and damper.

use crate::numbers::numbers;

/// Means by which the rows of a constraint go back to zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Hold<P> {
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
}

impl<P> Hold<P> {
    /// Converts the numbers to another scalar.
    pub(crate) fn map<L>(self, to: impl Fn(P) -> L) -> Hold<L> {
        match self {
            Self::Rigid { time_constant } => Hold::Rigid {
                time_constant: to(time_constant),
            },
            Self::Spring { stiffness, damping } => Hold::Spring {
                stiffness: to(stiffness),
                damping: to(damping),
            },
        }
    }
}

numbers! { enum Hold {
    Rigid { time_constant: Positive("time constant", "time constant of a constraint") },
    Spring {
        stiffness: NotNegative("stiffness", "stiffness of a constraint"),
        damping: NotNegative("damping", "damping of a constraint"),
    },
} }
