//! Motions that tell much: Fourier series within the limits of joints, of least condition.

mod problem;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use super::error::{IdentifyError, check_positive};
use super::regressor::Regressor;
use super::series::Series;
use crate::memory;
use crate::minimize::{MinimizeOptions, Minimizer, minimize};
use problem::Problem;

/// Options of [`excite`].
#[derive(Clone, Debug, PartialEq)]
pub struct ExcitationOptions {
    /// Period, s; 10 by default. A longer period contains slower motion, in which friction has more effect.
    pub period: f64,
    /// Number of harmonics of each joint; 5 by default. More harmonics are more informative, and may excite vibrations of the structure.
    pub harmonics: usize,
    /// Share of the range between position limits that is used; 0.9 by default.
    pub range: f64,
    /// Half the range of a joint without position limits, rad or m; 1 by default.
    pub reach: f64,
    /// Largest speed of a joint without a speed limit, rad/s or m/s; 2 by default.
    pub speed: f64,
    /// Largest acceleration, rad/s² or m/s²; 10 by default.
    pub acceleration: f64,
    /// Standard deviation of the error of the measured force along each velocity coordinate, N·m or N; empty by default, for equal ones.
    pub force_deviations: Vec<f64>,
    /// Largest number of iterations from each start; 60 by default.
    pub max_iterations: usize,
    /// Number of random starts, of which the best is kept; 3 by default.
    pub starts: usize,
    /// Seed of the random starts; 1 by default.
    pub seed: u64,
}

impl Default for ExcitationOptions {
    fn default() -> Self {
        Self {
            period: 10.0,
            harmonics: 5,
            range: 0.9,
            reach: 1.0,
            speed: 2.0,
            acceleration: 10.0,
            force_deviations: Vec::new(),
            max_iterations: 60,
            starts: 3,
            seed: 1,
        }
    }
}

/// A periodic motion to identify a robot with, made by [`excite`]: qᵢ(t) = cᵢ + Σₖ aᵢₖ sin(k ω t) + bᵢₖ cos(k ω t).
#[derive(Clone, Debug, PartialEq)]
pub struct Excitation {
    /// Period 2π / ω, s.
    pub period: f64,
    /// cᵢ, rad or m.
    pub center: Vec<f64>,
    /// For each coordinate aᵢ₁, bᵢ₁, aᵢ₂, …, rad or m; coordinates × twice the harmonics.
    pub coefficients: DMatrix<f64>,
    /// Condition number of the regressor of the base parameters over a period, with weighted rows and columns of unit length, as in
    /// [`Estimate::condition`](super::Estimate::condition).
    pub condition: f64,
    /// Condition of the random start.
    pub start_condition: f64,
}

/// Configuration, velocity and acceleration of a motion at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionPoint {
    /// Configuration.
    pub q: DVector<f64>,
    /// Velocity, rad/s or m/s.
    pub v: DVector<f64>,
    /// Acceleration, rad/s² or m/s².
    pub a: DVector<f64>,
}

impl Excitation {
    /// Computes configuration, velocity and acceleration at a time, s.
    ///
    /// # Panics
    /// If the period is not positive and finite, or the time is not finite.
    pub fn at(&self, time: f64) -> MotionPoint {
        let Self { period, .. } = *self;
        let is_period = period > 0.0 && period.is_finite();
        assert!(
            is_period,
            "the period of a motion must be positive and finite, got {period} s"
        );
        assert!(time.is_finite(), "the time must be finite, got {time} s");
        let n = self.center.len();
        let harmonics = self.coefficients.ncols() / 2;
        let mut out = MotionPoint {
            q: DVector::from_column_slice(&self.center),
            v: DVector::zeros(n),
            a: DVector::zeros(n),
        };
        for k in 0..harmonics {
            let rate = (k + 1) as f64 * std::f64::consts::TAU / self.period;
            let (sin, cos) = (rate * time).sin_cos();
            for i in 0..n {
                let (a, b) = (
                    self.coefficients[(i, 2 * k)],
                    self.coefficients[(i, 2 * k + 1)],
                );
                let (value, slope) = (a * sin + b * cos, a * cos - b * sin);
                out.q[i] += value;
                out.v[i] += rate * slope;
                out.a[i] -= rate * rate * value;
            }
        }
        out
    }
}

/// Finds an informative periodic motion: within the limits of the joints, it determines the unknowns of a regressor as well as possible.
///
/// Minimises the Frobenius condition number √(n tr S⁻¹) of the normal matrix S of unit diagonal by L-BFGS, from random starts. Coefficients are
/// scaled so that positions, speeds and accelerations keep their bounds at all times, for any values of the variables. The gradient is exact: the
/// regressor is differentiated by dual numbers at each time, everything else by a backward pass.
///
/// # Limitations
/// All joints must have one coordinate. Collisions and limits of force are not checked. Inspect the motion before the robot runs it; choose a smaller
/// range or [scale](Excitation::coefficients) it if necessary.
///
/// # Errors
/// If an option is out of its range, a joint has more than one coordinate, or no start excites all unknowns.
///
/// # Examples
/// ```
/// use dualbody::identify::{ExcitationOptions, Regressor, excite};
/// use dualbody::model::samples;
///
/// let options = ExcitationOptions { harmonics: 3, max_iterations: 10, starts: 1, ..Default::default() };
/// let motion = excite(&Regressor::new(&samples::double_pendulum()), &options)?;
/// assert!(motion.condition < motion.start_condition);
/// assert!(motion.at(1.7).q.amax() < 1.0);
/// # Ok::<(), dualbody::identify::IdentifyError>(())
/// ```
///
/// # References
/// [Swevers et al. 1997].
pub fn excite(
    regressor: &Regressor,
    options: &ExcitationOptions,
) -> Result<Excitation, IdentifyError> {
    check(regressor, options)?;
    let problem = Problem::new(regressor, options)?;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(options.seed);
    let n = problem.n_variables();
    let limits = MinimizeOptions {
        max_iterations: options.max_iterations,
        ..MinimizeOptions::default()
    };
    let mut best: Option<(f64, Excitation)> = None;
    for _ in 0..options.starts.max(1) {
        let start: Vec<f64> = (0..n).map(|_| rng.random_range(-1.0..1.0)).collect();
        let found = minimize(&problem, &start, Minimizer::Lbfgs, &limits);
        let is_better = best.as_ref().is_none_or(|(value, _)| found.value < *value);
        if found.value.is_finite() && is_better {
            best = Some((found.value, problem.excitation(&start, &found.x)));
        }
    }
    match best {
        Some((_, found)) if found.condition.is_finite() => Ok(found),
        _ => Err(IdentifyError::NotExcited {
            unknowns: vec!["all base parameters: more harmonics, or less unknowns".into()],
        }),
    }
}

fn check(regressor: &Regressor, options: &ExcitationOptions) -> Result<(), IdentifyError> {
    let model = regressor.model();
    let positive = [
        ("period", options.period),
        ("range", options.range),
        ("reach", options.reach),
        ("speed", options.speed),
        ("acceleration", options.acceleration),
        ("harmonics", options.harmonics as f64),
    ];
    let numbers = positive.into_iter().chain(
        options
            .force_deviations
            .iter()
            .map(|&x| ("force deviations", x)),
    );
    check_positive(numbers)?;
    let series = model.independent().count();
    let bytes = Series::bytes(options.harmonics).saturating_mul(series);
    memory::check(
        format_args!("Fourier series of {} harmonics", options.harmonics),
        bytes,
    )
    .map_err(|error| IdentifyError::option("harmonics", error.to_string()))?;
    if ![0, model.nv()].contains(&options.force_deviations.len()) {
        return Err(IdentifyError::OtherRobot {
            model: model.name().into(),
            what: "force deviations".into(),
            found: options.force_deviations.len(),
            expected: model.nv(),
        });
    }
    let mut joints = model.independent_with_ids();
    match joints.find(|(_, body)| body.joint.nq() != 1) {
        None => Ok(()),
        Some((id, _)) => Err(IdentifyError::option(
            format!("joint \"{}\"", model.joint_name(id)),
            "its coordinates are not those of a line, as those of a Fourier series are",
        )),
    }
}
