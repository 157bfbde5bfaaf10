//! Multiple shooting: parameters of a robot from its simulated motion, including contact.
//!
//! The log is divided into short shots. Each shot is simulated from its own start under the measured forces, and all simulated states are compared
//! with measured ones. So accelerations are not needed, and nonlinear parameters, such as placements, springs and friction on the ground, can be
//! identified. Shots are short for two reasons: errors of the start grow along them, and the cost of a long simulation of an unstable robot, or of
//! one in contact, has too many local minima for a descent.
//!
//! Derivatives of the states are computed along with the simulation. For few parameters, each step is linearised and evaluated over dual numbers once
//! for every four of them. For many parameters, each entry of the next state has a vector-Jacobian product, whose cost does not depend on the number
//! of parameters.

mod body;
mod derivatives;
mod problem;
mod residuals;
mod slopes;
#[cfg(test)]
mod tests;
mod variables;

use super::dataset::Dataset;
use super::error::IdentifyError;
use super::estimate::Interval;
use super::student::{check_level, two_sided};
use crate::least_squares::{Options, Residuals, Status, solve};
use crate::sim::Simulator;
use problem::Shooting;

/// Relative offset at which parameters count as found: the remaining change is a thousandth of their uncertainty [Bates, Watts 1981].
const OFFSET: f64 = 1e-3;

/// Parameters of a simulator that [`shoot`] adjusts.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Adjustable {
    /// All ten inertial parameters of the body of a link; they stay physically consistent.
    Inertia(String),
    /// The mass of the body of a link, kg. First moment and moments of inertia change in proportion, so centre of mass and shape are unchanged. The
    /// parameter `pole: mass` differs: it keeps the moments, so the fitted mass belongs to a body of another shape.
    LinkMass(String),
    /// The parameter of the simulator with this name, as in [`Simulator::parameter_layout`]: `elbow: damping`, `elbow: shift x`, `door: stiffness`, `wheel: Coulomb friction`.
    /// Each stays in its domain: a mass or a stiffness is not negative, a length is positive, a coefficient of restitution is in 0..1. These parameters
    /// are refused, since their order restricts them as well: position limits, limits of the input of a frame actuator, speeds of a torque–speed
    /// curve. The time step is refused, since the rate of the log determines it.
    Parameter(String),
    /// One coefficient of friction for these contact points, by their index in [`Contacts::points`](crate::contact::Contacts::points). It does not
    /// become negative.
    Friction(Vec<usize>),
}

/// Initial states of shots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Starts {
    /// The measured states. The number of variables does not grow with the log; errors of the initial states bias the estimate.
    #[default]
    Measured,
    /// Variables of the fit, weighted towards the measured states by their standard deviations. Memory grows with the square of the number of shots: for tens of shots.
    Free,
}

/// Options of [`shoot`].
#[derive(Clone, Debug, PartialEq)]
pub struct ShootingOptions {
    /// Number of samples of a shot; 30 by default. Longer shots determine small forces better, until errors of the initial state dominate.
    pub samples: usize,
    /// Initial states of shots; the measured states by default.
    pub starts: Starts,
    /// Standard deviation of measured positions, rad or m; 1e-3 by default. Only its ratio to that of velocities counts.
    pub position_deviation: f64,
    /// Standard deviation of measured velocities, rad/s or m/s; 1e-2 by default.
    pub velocity_deviation: f64,
    /// Weight of the distance of log-Cholesky parameters from the nominal ones, which determines parameters that the motion does not; 1e-6 by default.
    pub regularization: f64,
    /// Largest number of iterations; 50 by default.
    pub max_iterations: usize,
}

impl Default for ShootingOptions {
    fn default() -> Self {
        Self {
            samples: 30,
            starts: Starts::Measured,
            position_deviation: 1e-3,
            velocity_deviation: 1e-2,
            regularization: 1e-6,
            max_iterations: 50,
        }
    }
}

/// Result of [`shoot`].
#[derive(Clone, Debug)]
pub struct ShootingEstimate {
    /// The simulator with the estimated parameters.
    pub simulator: Simulator,
    /// The estimated parameters with their intervals, in the order of the request, ten for an inertia; `None` if a parameter changes no state.
    pub intervals: Option<Vec<Interval>>,
    /// Values of the parameters.
    pub values: Vec<f64>,
    /// Standard deviation of the residuals, in units of the given standard deviations.
    pub deviation: f64,
    /// Status of the solver.
    pub status: Status,
    /// Number of its iterations.
    pub iterations: usize,
}

/// Adjusts parameters of a simulator until its motion agrees with the log, by the Levenberg–Marquardt method.
///
/// Each input of the simulator is the measured force along its coordinate, constant from sample to sample. Bristles of contact are straight at the
/// start of each segment, and are continued from shot to shot. If the simulator has kinematic constraints, measured initial states are moved to the
/// nearest states that satisfy these with the nominal parameters.
///
/// * `level` – probability that an interval contains the true value, for example 0.95
///
/// # Limitations
/// The Jacobian omits the effect of initial states of earlier shots on bristles, if these states are variables. The Jacobian of residuals of
/// spherical, planar and floating joints is exact to first order in the residuals. The cost is nonsmooth if a shot begins in flight and ends on the
/// ground, or the reverse. The cost of a body that rocks on several points of regularised contact is rough at time steps of some milliseconds, and
/// descent ends in local minima: fit friction with soft or [smoothed](crate::contact::Smoothing) contact, and with data in which the robot has settled.
///
/// # Errors
/// If data belong to another robot or another rate, a name is unknown, an option is out of its range, a kinematic constraint is not closed at a
/// logged configuration, or the log has no force for an input of the simulator.
///
/// # Panics
/// If the level is not between 0 and 1.
///
/// # References
/// [Bock 1987].
pub fn shoot(
    simulator: &Simulator,
    data: &Dataset,
    adjustable: &[Adjustable],
    level: f64,
    options: &ShootingOptions,
) -> Result<ShootingEstimate, IdentifyError> {
    check_level(level);
    data.check(simulator.model())?;
    let mut problem = Shooting::new(simulator, data, adjustable, options)?;
    let start = problem.start();
    let (lower, upper) = problem.bounds();
    let solver = Options {
        max_iterations: options.max_iterations,
        offset_tolerance: OFFSET,
        lower,
        upper,
        ..Options::default()
    };
    let found = solve(&mut problem, &start, &solver);
    let deviation = found.variance().unwrap_or(0.0).sqrt();
    let freedom = problem
        .n_residuals()
        .saturating_sub(problem.n_directions(&start))
        .max(1) as f64;
    let factor = two_sided(level, freedom);
    let p = problem.variables.len();
    let intervals = found.covariance().map(|covariance| {
        let (variables, x) = (&problem.variables, &found.x[..p]);
        let slopes = variables.slopes(x);
        let own = &slopes * covariance.view((0, 0), (p, p)) * slopes.transpose();
        variables.intervals(x, &own, factor)
    });
    let simulator = problem
        .simulator_with(&found.x[..p])
        .unwrap_or_else(|| simulator.clone());
    Ok(ShootingEstimate {
        simulator,
        intervals,
        values: found.x[..p].to_vec(),
        deviation,
        status: found.status,
        iterations: found.iterations,
    })
}
