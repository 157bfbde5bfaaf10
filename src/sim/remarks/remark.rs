//! The remarks, and their text.

use std::f64::consts::TAU;
use std::fmt;

use crate::sim::integrator::Integrator;

/// Speed of an impact that a step should be short enough for, m/s or rad/s: a fall from five centimetres.
pub(super) const SPEED: f64 = 1.0;

/// Steps of an impact below which it is called short.
pub(super) const FEW_STEPS: f64 = 10.0;

/// A natural mode: motion of a robot about a pose that decays or vibrates without external forces.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NaturalMode {
    /// Name of the joint with the largest share of the kinetic energy, numbered if it has several coordinates, as in
    /// [`Simulator::tangent_names`](crate::Simulator::tangent_names).
    pub joint: String,
    /// Frequency, Hz; 0 for a motion that decays without vibrating.
    pub frequency: f64,
    /// Rate of decay, 1/s.
    pub decay: f64,
}

impl fmt::Display for NaturalMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            joint,
            frequency,
            decay,
        } = self;
        match *frequency > 0.0 {
            true => write!(f, "the vibration of \"{joint}\" at {frequency:.3} Hz"),
            false => write!(
                f,
                "the damping of \"{joint}\", which has a time constant of {:.1e} s",
                1.0 / decay
            ),
        }
    }
}

impl NaturalMode {
    /// Mode of an eigenvalue of the rate of the state, 1/s.
    pub(crate) fn of(joint: String, re: f64, im: f64) -> Self {
        Self {
            joint,
            frequency: im.abs() / TAU,
            decay: -re,
        }
    }
}

/// Remark on a valid simulator whose result is probably not intended. `Display` writes it as a sentence.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SimulatorRemark {
    /// The step is too long for soft contact that is evaluated at the start of the step (all integrators except implicit velocity): landing bodies
    /// are thrown up again, and bodies on a slope chatter.
    UnstableSoftContact {
        /// Link with the contact point that is worst.
        link: String,
        /// The longest step that is stable there in an impact at 1 m/s, s.
        longest: f64,
        /// The time step, s.
        time_step: f64,
    },
    /// An impact lasts only a few steps: linearly implicit steps lose energy in it, and derivatives through it scatter.
    ShortImpact {
        /// Link with the contact point that is worst.
        link: String,
        /// Duration of an impact at 1 m/s there, without damping, s.
        duration: f64,
        /// The time step, s.
        time_step: f64,
    },
    /// A natural mode of the robot about the pose grows in steps of this length: it diverges or chatters.
    UnstableMode {
        /// The first motion that grows when steps get longer.
        mode: NaturalMode,
        /// The longest step in which none grows, s.
        longest: f64,
        /// The time step, s.
        time_step: f64,
        /// An integrator with which none grows in steps of this length, if there is one.
        stable: Option<Integrator>,
    },
    /// A period of a vibration of the robot about the pose has less than ten steps. Both Euler methods damp it: at ten steps per period, 20 % of the
    /// amplitude of a joint on a spring remains after one period. The implicit midpoint rule keeps the amplitude and lowers the frequency.
    UnresolvedMode {
        /// The fastest vibration.
        mode: NaturalMode,
        /// The time step, s.
        time_step: f64,
    },
    /// Coriolis and centrifugal forces rotate the motion of the robot by too large an angle in a step: energy changes by 1 % or more per revolution.
    UnresolvedRotation {
        /// Joint with the fastest rotation of its motion, numbered if it has several coordinates.
        joint: String,
        /// Rate of that rotation, rad/s.
        rate: f64,
        /// The longest step with an energy change of about 1 % per revolution, s.
        longest: f64,
        /// The time step, s.
        time_step: f64,
        /// An integrator with which it is less in steps of this length, if there is one.
        better: Option<Integrator>,
    },
    /// The integrator smooths dry friction that should hold: a joint under load creeps.
    SmoothedFriction {
        /// Joint with such friction: the one with the largest slip velocity.
        joint: String,
        /// Velocity at which 71 % of the friction act, rad/s or m/s.
        slip_velocity: f64,
        /// The integrator that smooths it.
        integrator: Integrator,
    },
    /// The Runge–Kutta step is too long for a joint limit, which is a spring and damper: a joint that reaches it is thrown back, or diverges.
    UnstableLimit {
        /// Joint whose limit of position or speed is worst.
        joint: String,
        /// The longest step that is stable there at 1 rad/s or m/s, s.
        longest: f64,
        /// The time step, s.
        time_step: f64,
    },
}

/// A length of a step as text, s: two digits, rounded down.
struct AtMost(f64);

impl fmt::Display for AtMost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = 10.0_f64.powf(self.0.log10().floor() - 1.0);
        write!(f, "{:.1e} s", (self.0 / unit).floor() * unit)
    }
}

/// Writes the integrator that may be used instead, if there is one.
fn write_other(f: &mut fmt::Formatter<'_>, other: Option<Integrator>) -> fmt::Result {
    other.map_or(Ok(()), |integrator| {
        write!(f, ", or Integrator::{integrator:?}")
    })
}

impl fmt::Display for SimulatorRemark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnstableSoftContact {
                link,
                longest,
                time_step,
            } => write!(
                f,
                "steps of {time_step} s are too long for soft contact of \"{link}\" at the start of a step: in an impact at {SPEED} m/s \
                 those up to {longest:.1e} s are stable; use Integrator::ImplicitVelocity, shorter steps, or softer contact"
            ),
            Self::ShortImpact {
                link,
                duration,
                time_step,
            } => write!(
                f,
                "an impact of \"{link}\" at {SPEED} m/s lasts {duration:.1e} s, {:.1} steps: motions lose energy in it, and derivatives through it \
                 scatter; 50 steps resolve it: use shorter steps, or softer contact",
                duration / time_step
            ),
            Self::UnstableMode {
                mode,
                longest,
                time_step,
                stable,
            } => {
                let longest = AtMost(*longest);
                write!(
                    f,
                    "steps of {time_step} s are too long for {mode}: it grows in each step; use steps of at most {longest}"
                )?;
                write_other(f, *stable)
            }
            Self::UnresolvedMode { mode, time_step } => {
                let period = 1.0 / mode.frequency;
                write!(
                    f,
                    "{mode} has {:.1} steps of {time_step} s in a period: the integrator changes its amplitude or frequency; use steps of at most \
                     {}, or a softer spring",
                    period / time_step,
                    AtMost(period / FEW_STEPS)
                )
            }
            Self::UnresolvedRotation {
                joint,
                rate,
                longest,
                time_step,
                better,
            } => {
                write!(
                    f,
                    "Coriolis and centrifugal forces rotate the motion of \"{joint}\" by {:.3} rad in a step of {time_step} s, at {rate:.1} rad/s: \
                     its energy changes by 1 % or more per revolution; use steps of at most {}",
                    rate * time_step,
                    AtMost(*longest)
                )?;
                write_other(f, *better)
            }
            Self::SmoothedFriction {
                joint,
                slip_velocity,
                integrator,
            } => write!(
                f,
                "Integrator::{integrator:?} smooths the dry friction of joint \"{joint}\", which creeps under a load at speeds up to the order of its slip \
                 velocity, {slip_velocity} rad/s or m/s; Integrator::SemiImplicitEuler and Integrator::ImplicitVelocity hold it"
            ),
            Self::UnstableLimit {
                joint,
                longest,
                time_step,
            } => write!(
                f,
                "steps of {time_step} s are too long for a limit of joint \"{joint}\", whose spring and damper the Runge–Kutta method evaluates \
                 explicitly; use steps of at most {}, or Integrator::SemiImplicitEuler",
                AtMost(*longest)
            ),
        }
    }
}
