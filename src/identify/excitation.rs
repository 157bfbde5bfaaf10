//! Motions that tell much: Fourier series within the limits of joints, of least condition.

use nalgebra::{DMatrix, DVector};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use super::base::BaseParameters;
use super::error::IdentifyError;
use super::experiment::{independent, joint_name, q_range};
use super::regressor::Regressor;
use super::series::{Bounds, Series};
use crate::scalar::Dual;
use crate::trajopt::{MinimizeOptions, Minimizer, Objective, minimize};

/// Directions that are differentiated at once.
const DIRECTIONS: usize = 8;

/// Options of [`excite`].
#[derive(Clone, Debug, PartialEq)]
pub struct ExcitationOptions {
    /// Period, s; 10 by default. Longer brings in slower motion, at which friction shows.
    pub period: f64,
    /// Number of harmonics of each joint; 5 by default. More excite more, and structures too.
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
    /// Condition number of the regressor of the base parameters over a period, with weighted rows and columns of unit length, as
    /// [`Estimate::condition`](super::Estimate::condition) has it.
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
    pub fn at(&self, time: f64) -> MotionPoint {
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

/// Finds a periodic motion within the limits of joints that tells as much as possible of the unknowns of a regressor.
///
/// Minimises the Frobenius condition number √(n tr S⁻¹) of the normal matrix S of unit diagonal by L-BFGS, from random starts. Coefficients are
/// scaled so that positions, speeds and accelerations keep their bounds at all times, whatever the variables. The gradient is exact: derivatives of the
/// regressor by dual numbers at each moment, and the rest backwards.
///
/// # Limitations
/// For joints with one coordinate. Collisions of the robot with itself and with what is around, and limits of force, are not looked at; so look at the motion before it is run, and
/// choose a smaller range or [scale](Excitation::coefficients) it.
///
/// # Errors
/// If an option is out of its range, a joint has no coordinate of a line, or no start excites all unknowns.
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
    for (option, value) in numbers {
        if !(value > 0.0 && value.is_finite()) {
            return Err(IdentifyError::Option {
                option: option.into(),
                reason: format!("{value} is not positive and finite"),
            });
        }
    }
    if ![0, model.nv()].contains(&options.force_deviations.len()) {
        return Err(IdentifyError::OtherRobot {
            model: model.name().into(),
            what: "force deviations".into(),
            found: options.force_deviations.len(),
            expected: model.nv(),
        });
    }
    match independent(model).find(|&body| model.body(body).joint.nq() != 1) {
        None => Ok(()),
        Some(body) => Err(IdentifyError::Option {
            option: format!("joint \"{}\"", joint_name(model, body)),
            reason: "its coordinates are not those of a line, as those of a Fourier series are"
                .into(),
        }),
    }
}

/// The condition as a function of coefficients.
struct Problem<'a> {
    regressor: &'a Regressor,
    base: BaseParameters,
    series: Vec<Series>,
    center: Vec<f64>,
    /// 1 / σ of each force.
    weights: Vec<f64>,
    period: f64,
    harmonics: usize,
}

impl<'a> Problem<'a> {
    fn new(regressor: &'a Regressor, options: &ExcitationOptions) -> Result<Self, IdentifyError> {
        let model = regressor.model();
        let (mut center, mut series) = (vec![0.0; model.nq()], Vec::new());
        for body in independent(model) {
            let limits = model.body_joint(body).map(|joint| *model.limits(joint));
            let limits = limits.unwrap_or_default();
            let (middle, half) = match (limits.lower, limits.upper) {
                (Some(lower), Some(upper)) => {
                    (0.5 * (lower + upper), 0.5 * (upper - lower) * options.range)
                }
                (Some(lower), None) => (lower + options.reach, options.reach * options.range),
                (None, Some(upper)) => (upper - options.reach, options.reach * options.range),
                (None, None) => (0.0, options.reach),
            };
            let bounds = Bounds {
                position: half,
                speed: limits.velocity.unwrap_or(options.speed),
                acceleration: options.acceleration,
            };
            if !bounds.are_positive() {
                return Err(IdentifyError::Option {
                    option: format!("joint \"{}\"", joint_name(model, body)),
                    reason: "its limits leave no motion".into(),
                });
            }
            center[q_range(model, body).start] = middle;
            series.push(Series::new(options.period, options.harmonics, bounds));
        }
        let weight = |k: usize| {
            options
                .force_deviations
                .get(k)
                .map_or(1.0, |sigma| sigma.recip())
        };
        Ok(Self {
            base: BaseParameters::new(regressor),
            regressor,
            series,
            center,
            weights: (0..model.nv()).map(weight).collect(),
            period: options.period,
            harmonics: options.harmonics,
        })
    }

    fn n_variables(&self) -> usize {
        2 * self.harmonics * self.series.len()
    }

    /// Coefficients of each coordinate.
    fn coefficients(&self, x: &[f64]) -> DMatrix<f64> {
        let n = 2 * self.harmonics;
        let rows: Vec<Vec<f64>> = x
            .chunks_exact(n)
            .zip(&self.series)
            .map(|(x, series)| series.bounded(x))
            .collect();
        DMatrix::from_fn(rows.len(), n, |i, k| rows[i][k])
    }

    fn motion(&self, x: &[f64]) -> Excitation {
        Excitation {
            period: self.period,
            center: self.center.clone(),
            coefficients: self.coefficients(x),
            condition: f64::INFINITY,
            start_condition: f64::INFINITY,
        }
    }

    fn excitation(&self, start: &[f64], x: &[f64]) -> Excitation {
        Excitation {
            condition: self.condition(start, x).1,
            start_condition: self.condition(start, x).0,
            ..self.motion(x)
        }
    }

    /// Condition numbers of a start and of a solution.
    fn condition(&self, start: &[f64], x: &[f64]) -> (f64, f64) {
        let of = |x: &[f64]| {
            let Some(normal) = Normal::of(&self.equations(&self.motion(x))) else {
                return f64::INFINITY;
            };
            let values = normal.scaled.symmetric_eigenvalues();
            (values.max() / values.min()).sqrt()
        };
        (of(start), of(x))
    }

    /// Times of the moments of a period.
    fn times(&self) -> impl Iterator<Item = f64> + '_ {
        let n = self.series.first().map_or(0, Series::n_moments);
        (0..n).map(move |k| self.period * k as f64 / n as f64)
    }

    /// The weighted regressor of the base parameters over a period.
    fn equations(&self, motion: &Excitation) -> DMatrix<f64> {
        let nv = self.weights.len();
        let n = self.times().count();
        let mut out = DMatrix::zeros(n * nv, self.base.len());
        for (k, time) in self.times().enumerate() {
            let at = motion.at(time);
            let own = (self.regressor).matrix(at.q.as_slice(), at.v.as_slice(), at.a.as_slice());
            for (column, &unknown) in self.base.independent().iter().enumerate() {
                for row in 0..nv {
                    out[(k * nv + row, column)] = self.weights[row] * own[(row, unknown)];
                }
            }
        }
        out
    }

    /// Slopes of Σ w̄ · w of a moment in q, v and a, one after another.
    fn moment_slopes(&self, at: &MotionPoint, weights: &DMatrix<f64>) -> Vec<f64> {
        let n = at.v.len();
        let values: Vec<f64> = at.q.iter().chain(&at.v).chain(&at.a).copied().collect();
        let mut out = vec![0.0; 3 * n];
        let mut seeded: Vec<Dual<f64, DIRECTIONS>> =
            values.iter().map(|&x| Dual::from(x)).collect();
        for first in (0..3 * n).step_by(DIRECTIONS) {
            let own = first..(first + DIRECTIONS).min(3 * n);
            own.clone().for_each(|k| seeded[k].eps[k - first] = 1.0);
            let matrix = self
                .regressor
                .matrix(&seeded[..n], &seeded[n..2 * n], &seeded[2 * n..]);
            for (column, &unknown) in self.base.independent().iter().enumerate() {
                for row in 0..n {
                    for k in own.clone() {
                        out[k] += self.weights[row]
                            * weights[(row, column)]
                            * matrix[(row, unknown)].eps[k - first];
                    }
                }
            }
            own.for_each(|k| seeded[k] = Dual::from(values[k]));
        }
        out
    }
}

/// Normal matrix of unit diagonal.
struct Normal {
    scaled: DMatrix<f64>,
    inverse: DMatrix<f64>,
    lengths: Vec<f64>,
}

impl Normal {
    /// `None` if it is singular.
    fn of(equations: &DMatrix<f64>) -> Option<Self> {
        let lengths: Vec<f64> = equations
            .column_iter()
            .map(|column| column.norm())
            .collect();
        let mut unit = equations.clone();
        for (mut column, length) in unit.column_iter_mut().zip(&lengths) {
            column /= *length;
        }
        let scaled = unit.transpose() * &unit;
        let inverse = scaled.clone().cholesky()?.inverse();
        let is_finite = inverse.iter().all(|x| x.is_finite());
        is_finite.then_some(Self {
            scaled,
            inverse,
            lengths,
        })
    }

    /// ½ ln(tr S⁻¹ / n), zero where columns are orthogonal.
    fn value(&self) -> f64 {
        0.5 * (self.inverse.trace() / self.lengths.len() as f64).ln()
    }

    /// Slopes G of the value in the normal matrix N before scaling: with t = tr S⁻¹ and lengths lᵢ = √Nᵢᵢ,
    /// G = (−S⁻²ᵢₖ / (lᵢ lₖ) + δᵢₖ S⁻¹ᵢᵢ / lᵢ²) / 2 t.
    fn slopes(&self) -> DMatrix<f64> {
        let square = &self.inverse * &self.inverse;
        let half = 0.5 / self.inverse.trace();
        let n = self.lengths.len();
        DMatrix::from_fn(n, n, |i, k| {
            let own = if i == k { self.inverse[(i, i)] } else { 0.0 };
            half * (own - square[(i, k)]) / (self.lengths[i] * self.lengths[k])
        })
    }
}

impl Objective for Problem<'_> {
    fn value(&self, x: &[f64]) -> f64 {
        let equations = self.equations(&self.motion(x));
        Normal::of(&equations).map_or(f64::INFINITY, |normal| normal.value())
    }

    fn gradient(&self, x: &[f64]) -> DVector<f64> {
        let (motion, n) = (self.motion(x), 2 * self.harmonics);
        let equations = self.equations(&motion);
        let Some(normal) = Normal::of(&equations) else {
            return DVector::from_element(x.len(), f64::NAN);
        };
        let weights = equations * normal.slopes() * 2.0;
        let nv = self.weights.len();
        // Slopes in the coefficients that are bounded, then in the variables.
        let mut by_coefficient = DMatrix::zeros(nv, n);
        for (k, time) in self.times().enumerate() {
            let own = weights.rows(k * nv, nv).into_owned();
            let slopes = self.moment_slopes(&motion.at(time), &own);
            for (i, series) in self.series.iter().enumerate() {
                let slopes = [slopes[i], slopes[nv + i], slopes[2 * nv + i]];
                series.add_slopes(k, slopes, &mut by_coefficient.row_mut(i));
            }
        }
        let rows = self.series.iter().zip(x.chunks_exact(n)).enumerate();
        let all = rows.flat_map(|(i, (series, x))| {
            let own: Vec<f64> = by_coefficient.row(i).iter().copied().collect();
            series.bounded_slopes(x, &own)
        });
        DVector::from_vec(all.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::DryFriction;
    use crate::model::samples;

    fn regressor() -> Regressor {
        Regressor::new(&samples::cartpole())
            .with_damping()
            .with_dry_friction(DryFriction::Smooth {
                slip_velocity: 0.05,
            })
            .unwrap()
    }

    #[test]
    fn gradient_of_the_condition_equals_differences() {
        let options = ExcitationOptions {
            harmonics: 3,
            ..Default::default()
        };
        let regressor = regressor();
        let problem = Problem::new(&regressor, &options).unwrap();
        let x: Vec<f64> = (0..problem.n_variables())
            .map(|k| (1.0 + 1.7 * k as f64).sin())
            .collect();
        let gradient = problem.gradient(&x);
        for k in 0..x.len() {
            const STEP: f64 = 1e-5;
            let at = |by: f64| {
                let mut moved = x.clone();
                moved[k] += by;
                problem.value(&moved)
            };
            let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            assert!(
                (gradient[k] - difference).abs() < 1e-7,
                "{k}: {} {difference}",
                gradient[k]
            );
        }
    }

    #[test]
    fn motion_keeps_the_limits_at_all_times_and_lowers_the_condition() {
        let options = ExcitationOptions {
            starts: 1,
            max_iterations: 25,
            ..Default::default()
        };
        let model = samples::cartpole();
        let found = excite(&regressor(), &options).unwrap();
        assert!(
            found.condition < 0.8 * found.start_condition,
            "{} {}",
            found.condition,
            found.start_condition
        );
        let limits = model.limits(model.joint("linear").unwrap());
        for k in 0..5000 {
            let at = found.at(found.period * f64::from(k) / 5000.0);
            assert!(at.q[0] < limits.upper.unwrap() && at.q[0] > limits.lower.unwrap());
            assert!(at.q[1].abs() <= options.reach);
            assert!(at.v[0].abs() <= limits.velocity.unwrap() && at.v[1].abs() <= options.speed);
            assert!(at.a.amax() <= options.acceleration);
        }
        // Periodic, and a derivative is one.
        let step = 1e-6;
        let rate = (found.at(3.0 + step).q - found.at(3.0 - step).q) / (2.0 * step);
        assert!((rate - found.at(3.0).v).amax() < 1e-8);
        assert!((found.at(1.0).q - found.at(1.0 + found.period).q).amax() < 1e-12);
    }

    #[test]
    fn options_and_joints_of_no_use_are_refused_by_name() {
        let says = |regressor: &Regressor, options: ExcitationOptions, expected: &str| {
            let text = excite(regressor, &options).unwrap_err().to_string();
            assert!(text.contains(expected), "{text}\ndoes not say: {expected}");
        };
        let own = regressor();
        says(
            &own,
            ExcitationOptions {
                period: 0.0,
                ..Default::default()
            },
            "period: 0",
        );
        says(
            &own,
            ExcitationOptions {
                force_deviations: vec![1.0],
                ..Default::default()
            },
            "force deviations of 1 numbers",
        );
        let tree = Regressor::new(&samples::random_tree(6, 1));
        says(&tree, ExcitationOptions::default(), "not those of a line");
    }
}
