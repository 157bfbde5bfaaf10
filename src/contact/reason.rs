//! Explains the derivatives of a contact point.

use std::fmt;

use super::point_state::PointState;
use crate::cone::Mode;
use crate::scalar::Scalar;
use crate::spatial::linear::dot;

/// Outcome of a step at a point: its state, its force, and the mode of its law.
pub(crate) struct PointOutcome<'a, T> {
    pub(crate) state: &'a PointState<T>,
    /// Force along the normal, N.
    pub(crate) normal_force: T,
    /// Mode of the solver; separated where the point took no part.
    pub(crate) mode: Mode,
    /// Δt, s.
    pub(crate) dt: f64,
    /// Whether the law is smoothed.
    pub(crate) is_smoothed: bool,
}

/// Behaviour of a contact point at an instant, which explains why a derivative of a step is zero or not; in the first lane. `Display` writes it as a sentence.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, contact::{ContactLaw, Contacts, Rigid, Terrain}, sim::ContactReason};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let model = dualbody::Model::from_urdf_file(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/sphere.urdf"))?;
/// let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Rigid(Rigid::default()));
/// let simulator = Simulator::new(model).with_contacts(contacts);
/// let mut state = simulator.neutral_state();
/// state.q[2] = 0.125; // the centre of a ball of 0.1 m
/// let reason = simulator.contact_report(&state, &[]).reasons[0];
/// assert!(reason.to_string().starts_with("separated: 25 mm above the ground"));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ContactReason {
    /// No force: the point is above the ground, and stays there for the step. Derivatives are those of free flight.
    Separated {
        /// Height above the ground, m.
        height: f64,
    },
    /// No force: the point is on or in the ground, and leaves it fast enough by itself. Derivatives are those of free flight.
    Leaving {
        /// Velocity out of the ground, m/s.
        speed: f64,
    },
    /// On the surface without force and velocity, for example without a load on the point. Derivatives are those of free flight, one of the two
    /// sides; those of a loaded point are the mean of both, see [`Resting`](Self::Resting).
    Touching,
    /// A force inside the friction cone: the velocity after the step is the reference velocity of the contact model, independent of forces and friction.
    Sticking,
    /// Sticking exactly on the surface, with [`Rigid`](crate::contact::Rigid) contact: the reference velocity is nonsmooth in the depth there, and
    /// derivatives in the depth are the mean of both sides.
    Resting,
    /// A force on the surface of the cone and no slip: derivatives are those of sticking or those of sliding.
    Impending,
    /// A force on the surface of the cone, against the slip: its magnitude depends on the normal force only.
    Sliding,
    /// Sliding exactly on the surface, with [`Rigid`](crate::contact::Rigid) contact: derivatives in the depth are the mean of both sides, as for a
    /// point at rest.
    Gliding,
    /// Smoothed contact: all derivatives exist, and decrease with the height of the point.
    Smoothed {
        /// Height above the ground, m; negative below.
        height: f64,
    },
    /// Soft contact with a force: all derivatives exist.
    Soft {
        /// Depth in the ground, m.
        depth: f64,
    },
}

impl ContactReason {
    /// Reason of a point without a force, by its height and velocity.
    pub(crate) fn without_force<T: Scalar>(at: &PointState<T>) -> Self {
        let height = -at.depth.value(0);
        if height > 0.0 {
            return Self::Separated { height };
        }
        Self::Leaving {
            speed: dot(&at.normal, &at.velocity).value(0),
        }
    }

    /// Reason of a point whose force the solver found, by the mode of its law.
    pub(crate) fn of_mode<T: Scalar>(at: &PointState<T>, mode: Mode) -> Self {
        match mode {
            Mode::Smoothed => Self::Smoothed {
                height: -at.depth.value(0),
            },
            Mode::Touching => Self::Touching,
            Mode::Impending => Self::Impending,
            Mode::Sticking | Mode::Pressing | Mode::Bilateral | Mode::Holding => Self::Sticking,
            Mode::Sliding | Mode::Yielding => Self::Sliding,
            Mode::Separated => Self::without_force(at),
        }
    }
}

impl fmt::Display for ContactReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // To a thousandth.
        let mm = |x: f64| (1e6 * x).round() / 1e3;
        match *self {
            Self::Separated { height } => write!(
                f,
                "separated: {} mm above the ground, no force and the derivatives of free flight; smoothed rigid contact that reaches \
                 this height has other derivatives",
                mm(height)
            ),
            Self::Leaving { speed } => write!(
                f,
                "leaving: moves out of the ground at {speed:.3} m/s, no force and the derivatives of free flight"
            ),
            Self::Touching => f.write_str(
                "touching: no force and no velocity; derivatives are those of free flight, one side of two",
            ),
            Self::Sticking => f.write_str(
                "sticking: the contact model fixes its velocity, which has zero derivatives in friction and in the forces that the contact balances",
            ),
            Self::Resting => f.write_str(
                "resting: sticks on the surface itself, where the contact model is nonsmooth; derivatives in the depth are the mean of both sides, \
                 others those of sticking",
            ),
            Self::Gliding => f.write_str(
                "gliding: slides on the surface itself, where the contact model is nonsmooth; derivatives in the depth are the mean of both sides, \
                 others those of sliding",
            ),
            Self::Impending => f.write_str(
                "impending: about to slip; derivatives are those of sticking or those of sliding",
            ),
            Self::Sliding => f.write_str(
                "sliding: friction is μ times the normal force against the slip; derivatives in the speed of the slip are zero",
            ),
            Self::Smoothed { height } => write!(
                f,
                "smoothed: {} mm above the ground; all derivatives exist, and decrease with the height",
                mm(height)
            ),
            Self::Soft { depth } => {
                write!(f, "soft: {} mm in the ground; all derivatives exist", mm(depth))
            }
        }
    }
}
