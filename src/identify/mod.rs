//! System identification: parameters of a robot from logged motion.
//!
//! With m equations (samples times joints) and p unknowns:
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | logged channels, with units and gaps? | [`Experiment`] | | |
//! | filtered motion and its derivatives, without delay? | [`Preparation`], with [`SavitzkyGolay`] and [`Butterworth`] | linear in the samples | [Savitzky, Golay 1964] |
//! | forces as a linear function of unknowns? | [`Regressor`]: inertias, damping, rotors, dry friction, offsets | O(n · depth) a sample | [Atkeson, An, Hollerbach 1986] |
//! | identifiable combinations of unknowns? | [`BaseParameters`] | O(p³), after the regressor of random motions | [Gautier 1991] |
//! | their values and uncertainty? | [`estimate()`], [`Estimate::intervals`] | O(m p²) | [Atkeson, An, Hollerbach 1986] |
//! | a physically consistent robot, for simulation? | [`Estimate::consistent`] | a convex program: milliseconds | [Wensing, Kim, Slotine 2018] |
//! | the most informative motion? | [`excite`] | an iteration: the regressor along a period, and its derivatives | [Swevers et al. 1997] |
//! | prediction of other motions? | [`Robot::validate`] | inverse dynamics of each sample | |
//! | parameters in which forces are not linear, and friction on the ground? | [`shoot`], through the simulator | an iteration: gradients of all shots | [Bock 1987] |
//! | a report as text or as an HTML page? | [`Report`], `view::identification_page` | linear in the samples | |
//!
//! Joint forces are linear in masses, moments and friction. A linear least-squares problem therefore gives the best values and their covariance,
//! without an initial guess. Parameters without effect on forces, such as the mass of a link that only rotates, come from the nominal robot.
//!
//! # Examples
//!
//! ```
//! use dualbody::identify::{ConsistencyOptions, Experiment, Preparation, Regressor, Report, SavitzkyGolay, estimate};
//! use dualbody::{Simulator, State, model::samples};
//!
//! // Logged: a cart-pole that is pushed. The rail and the hinge are damped; the nominal robot has no damping.
//! let robot = samples::cartpole().with_damping(0, 0.4).with_damping(1, 0.05);
//! let simulator = Simulator::new(robot).with_time_step(1e-3);
//! let push = |t: f64, _: &State, u: &mut [f64]| {
//!     u[0] = 4.0 * (7.0 * t).sin() + 2.0 * (3.0 * t).cos();
//!     u[1] = 0.5 * (5.0 * t).sin();
//! };
//! let log = simulator.rollout(&State::new(&[0.0, 2.0], &[0.0; 2]), 6000, push);
//! let experiment = Experiment::from_rollout("push", simulator.model(), &log, simulator.actuated());
//!
//! let nominal = samples::cartpole();
//! let data = Preparation::new(SavitzkyGolay::new(4, 2)?).prepare(&nominal, &[experiment])?;
//! let (learn, held) = data.hold_back(0.3);
//! let found = estimate(&Regressor::new(&nominal).with_damping(), &learn)?;
//! let consistent = found.consistent(&ConsistencyOptions::default())?;
//! assert!((consistent.robot.model.damping()[0] - 0.4).abs() < 0.02);
//! println!("{}", Report::new(&found, &consistent.robot, &held, 0.95)?);
//! # Ok::<(), dualbody::identify::IdentifyError>(())
//! ```

mod barrier;
mod base;
mod butterworth;
mod consistent;
mod dataset;
mod equations;
mod error;
mod estimate;
mod excitation;
mod experiment;
mod friction;
mod normal;
mod preparation;
mod regressor;
mod report;
mod robot;
mod savitzky_golay;
mod series;
mod shooting;
mod student;
mod table;
mod unit;
mod validation;

pub use base::BaseParameters;
pub use butterworth::Butterworth;
pub use consistent::{ConsistencyOptions, ConsistentEstimate};
pub use dataset::{Dataset, LeftOut, Segment};
pub use error::IdentifyError;
pub use estimate::{Estimate, Interval, estimate};
pub use excitation::{Excitation, ExcitationOptions, MotionPoint, excite};
pub use experiment::Experiment;
pub use friction::DryFriction;
pub use preparation::{LowPass, Preparation};
pub use regressor::{Regressor, Unknown};
pub use report::{CoordinateReport, Report, Trace};
pub use robot::Robot;
pub use savitzky_golay::SavitzkyGolay;
pub use shooting::{Adjustable, ShootingEstimate, ShootingOptions, Starts, shoot};
pub use unit::{Quantity, Unit};
pub use validation::{ForceError, Validation};

#[cfg(test)]
mod tests;
