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

/// Relative offset at which numbers count as found: what is left to find is a thousandth of their uncertainty [Bates, Watts 1981].
const OFFSET: f64 = 1e-3;

/// Numbers of a robot that [`shoot`] adjusts.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Adjustable {
    /// The inertia of the body that a link is on, all ten numbers: it stays that of a body.
    Inertia(String),
    /// The mass of the body that a link is on, kg: first moment and moments of inertia change in proportion, so that the centre of mass and the shape stay.
    /// The parameter `pole: mass` by itself is another thing: it holds the moments, and the mass that fits then is that of another body.
    LinkMass(String),
    /// The parameter of the simulator with this name, as in [`Simulator::parameter_layout`]: `elbow: damping`, `elbow: shift x`, `door: stiffness`, `wheel: Coulomb friction`.
    /// Each stays in its domain: a mass or a stiffness is not negative, a length is positive, a coefficient of restitution is in 0..1. Limits of positions, of a frame actuator's
    /// input, and the speeds of a motor's torque–speed curve are refused, since their order restricts them too, and so is the time
    /// step, which the rate of the log sets.
    Parameter(String),
    /// One coefficient of friction for these contact points, by their index in [`Contacts::points`](crate::contact::Contacts::points). It stays not
    /// negative.
    Friction(Vec<usize>),
}

/// Starts of shots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Starts {
    /// The measured states. The number of variables does not grow with the log; errors of the start bias what is found.
    #[default]
    Measured,
    /// Variables, near the measured states as these are certain. Memory grows with the square of their number: for tens of shots.
    Free,
}

/// Options of [`shoot`].
#[derive(Clone, Debug, PartialEq)]
pub struct ShootingOptions {
    /// Number of samples of a shot; 30 by default. Longer ones tell small forces better, until errors of the start outgrow what they tell.
    pub samples: usize,
    /// Starts of shots; the measured states by default.
    pub starts: Starts,
    /// Standard deviation of measured positions, rad or m; 1e-3 by default. Only its ratio to that of velocities counts.
    pub position_deviation: f64,
    /// Standard deviation of measured velocities, rad/s or m/s; 1e-2 by default.
    pub velocity_deviation: f64,
    /// Weight of the distance of log-Cholesky parameters from the nominal ones, for what the motion leaves open; 1e-6 by default.
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
    /// The simulator with the numbers that were found.
    pub simulator: Simulator,
    /// Numbers with their intervals, in the order of what was requested: ten for an inertia. Without intervals, `None`, if some number changes no state.
    pub intervals: Option<Vec<Interval>>,
    /// Values of these numbers.
    pub values: Vec<f64>,
    /// Standard deviation of the residuals, in units of the deviations that were given.
    pub deviation: f64,
    /// Status of the solver.
    pub status: Status,
    /// Number of its iterations.
    pub iterations: usize,
}

/// Adjusts parameters of a simulator until its motion agrees with the log, by Levenberg and Marquardt's method.
///
/// Each input of the simulator is the measured force along its coordinate, held from sample to sample. Bristles of contact are straight at the start of each
/// segment, and go on from shot to shot.
///
/// * `level` – probability that an interval holds the true value, 0.95 say
///
/// Where the simulator has kinematic constraints, measured starts are moved to the nearest states that obey them with the nominal numbers.
///
/// # Limitations
/// The Jacobian leaves out what starts of earlier shots, where they are variables, do to bristles. That of residuals of spherical, planar and floating joints is exact to first order in these residuals. Where a shot
/// begins in flight and ends on the ground, or the other way round, the cost is nonsmooth; and that of a rigid body on several points of relaxed contact that
/// rocks is rough at time steps of some milliseconds, so that descents end in holes: fit friction with soft contact, or
/// [smoothed](crate::contact::Smoothing), and from data in which the robot has settled.
///
/// # Errors
/// If data belong to another robot or another rate, a name is unknown, an option is out of its range, a kinematic constraint does not close where the log has the
/// robot, or the simulator has inputs that no force of the log is for.
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
