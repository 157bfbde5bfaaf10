//! Weighted least squares of base parameters, with their uncertainty.

use nalgebra::{DMatrix, DVector};

use super::base::BaseParameters;
use super::dataset::Dataset;
use super::equations::{Equations, collect};
use super::error::IdentifyError;
use super::normal::Normal;
use super::regressor::Regressor;
use super::robot::Robot;
use super::student::{check_level, two_sided};
use crate::nested::IntoNested;

/// Rounds in which errors and weights find each other; the second changes what counts, the third nearly nothing.
const ROUNDS: usize = 4;
/// Least eigenvalue of the normal matrix of unit diagonal, below which a combination of base parameters does not show.
const NOT_EXCITED: f64 = 1e-12;

/// An estimate with its confidence interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Interval {
    /// Name of the estimated quantity.
    pub name: String,
    /// The estimate.
    pub value: f64,
    /// Standard deviation of the estimate.
    pub deviation: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

impl Interval {
    /// * `factor` – half of its width in deviations
    pub(super) fn new(name: String, value: f64, deviation: f64, factor: f64) -> Self {
        Self {
            name,
            value,
            deviation,
            lower: value - factor * deviation,
            upper: value + factor * deviation,
        }
    }
}

/// Base parameters by weighted least squares, made by [`estimate`].
#[derive(Clone, Debug)]
pub struct Estimate {
    /// The regressor.
    pub regressor: Regressor,
    /// The base parameters.
    pub base: BaseParameters,
    /// Their values.
    pub values: DVector<f64>,
    /// Covariance of the values.
    pub covariance: DMatrix<f64>,
    /// Standard deviation of the errors of the measured force along each velocity coordinate, N·m or N.
    pub force_deviations: Vec<f64>,
    /// Number of equations of each velocity coordinate.
    pub equations: Vec<usize>,
    /// Condition number of the weighted regressor with columns of unit length: the maximum amplification of relative errors.
    pub condition: f64,
    /// Inverse of the covariance: the weighted normal matrix.
    pub information: DMatrix<f64>,
}

/// Estimates the base parameters of a robot from data.
///
/// Minimises Σ (τ − Y β)² / σₖ² with the standard deviation σₖ of the errors of each coordinate's force, which is estimated from the residuals at the
/// same time. Data are read once; the cost is that of the regressor, about 6 µs per sample for an arm of six joints (`cargo bench --features full
/// --bench identify`).
///
/// # Limitations
/// Covariance and intervals assume that force errors are independent of each other and of the motion, and that positions, velocities and
/// accelerations are exact. Errors of these bias the parameters that multiply them towards zero: [smooth](super::Preparation) as much as the motion
/// allows.
///
/// # Errors
/// If data belong to another robot, if there are fewer equations than unknowns, or if the motion does not determine some of these; the error names them.
///
/// # Examples
/// ```
/// use dualbody::identify::{Dataset, Regressor, Segment, estimate};
/// use dualbody::{dynamics, model::samples};
/// use nalgebra::DMatrix;
///
/// // A pendulum of 1 kg and 1 m: moment ⅓ kg·m², first moment ½ kg·m.
/// let model = samples::pendulum();
/// let motion = |f: fn(f64) -> f64| DMatrix::from_fn(1, 200, |_, k| f(0.05 * k as f64));
/// let (q, v, a) = (motion(f64::sin), motion(f64::cos), motion(|t| -t.sin()));
/// let tau = DMatrix::from_fn(1, 200, |_, k| dynamics::inverse_dynamics(&model, &[q[k]], &[v[k]], &[a[k]])[0]);
/// let segment = Segment { experiment: "swing".into(), start: 0.0, rate: 20.0, q, v, a, tau };
/// let found = estimate(&Regressor::new(&model), &Dataset::new(vec![segment]))?;
/// let moment = found.intervals(0.95).into_iter().find(|own| own.name == "rod: Jzz").unwrap();
/// assert!((moment.value - 1.0 / 3.0).abs() < 1e-9);
/// # Ok::<(), dualbody::identify::IdentifyError>(())
/// ```
///
/// # References
/// [Gautier 1997; Bard 1974, section 7.5].
pub fn estimate(regressor: &Regressor, data: &Dataset) -> Result<Estimate, IdentifyError> {
    data.check(regressor.model())?;
    let base = BaseParameters::new(regressor);
    let equations = collect(regressor, &base, data);
    let rows: usize = equations.iter().map(|own| own.rows).sum();
    if rows <= base.len() {
        return Err(IdentifyError::TooFewData {
            rows,
            unknowns: base.len(),
        });
    }
    let mut variances = vec![1.0; equations.len()];
    let mut system = System::new(&equations, &variances, &base)?;
    for _ in 1..ROUNDS {
        let values = system.solve();
        for (variance, own) in variances.iter_mut().zip(&equations) {
            *variance = residual_variance(own, &values, base.len(), rows);
        }
        system = System::new(&equations, &variances, &base)?;
    }
    let values = system.solve();
    Ok(Estimate {
        regressor: regressor.clone(),
        covariance: system.covariance(),
        condition: system.condition,
        information: system.matrix,
        values,
        base,
        force_deviations: variances.iter().map(|variance| variance.sqrt()).collect(),
        equations: equations.iter().map(|own| own.rows).collect(),
    })
}

/// σₖ², with each coordinate's share of the unknowns.
fn residual_variance(own: &Equations, values: &DVector<f64>, unknowns: usize, rows: usize) -> f64 {
    let freedom = own.rows as f64 * (1.0 - unknowns as f64 / rows as f64);
    match own.rows {
        0 => 1.0,
        // Where nothing is measured to be anything.
        _ => match own.residual(values) / freedom {
            0.0 => f64::MIN_POSITIVE.sqrt(),
            variance => variance,
        },
    }
}

/// Weighted normal equations.
struct System {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    normal: Normal,
    /// Inverse of the matrix of unit diagonal.
    inverse: DMatrix<f64>,
    condition: f64,
}

impl System {
    /// # Errors
    /// If the matrix is singular.
    fn new(
        equations: &[Equations],
        variances: &[f64],
        base: &BaseParameters,
    ) -> Result<Self, IdentifyError> {
        let n = base.len();
        let (mut matrix, mut right) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for (own, variance) in equations.iter().zip(variances) {
            own.add_to(variance.recip(), &mut matrix, &mut right);
        }
        let normal = Normal::new(&matrix);
        let open: Vec<usize> = (0..n).filter(|&k| normal.lengths[k] == 0.0).collect();
        if !open.is_empty() {
            return Err(not_excited(open, base));
        }
        let eigen = normal.scaled.clone().symmetric_eigen();
        let (least, largest) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
        let weak = |value: f64| value <= NOT_EXCITED * largest;
        let factor = normal.scaled.clone().cholesky();
        let inverse = factor
            .filter(|_| !weak(least))
            .map(|factor| factor.inverse());
        let Some(inverse) = inverse else {
            /// Part of a direction that an unknown must have to be named.
            const PART: f64 = 0.3;
            let directions = eigen.eigenvectors.column_iter().zip(&eigen.eigenvalues);
            let weakest = directions.filter(|(_, value)| weak(**value) || **value == least);
            let mut open: Vec<usize> = weakest
                .nested(|(direction, _)| {
                    let large = direction.amax() * PART;
                    (0..n)
                        .filter(move |&k| direction[k].abs() >= large)
                        .collect::<Vec<_>>()
                })
                .collect();
            open.sort_unstable();
            open.dedup();
            return Err(not_excited(open, base));
        };
        Ok(Self {
            condition: (largest / least).sqrt(),
            inverse,
            matrix,
            right,
            normal,
        })
    }

    fn solve(&self) -> DVector<f64> {
        let lengths = &self.normal.lengths;
        let right = self.right.component_div(lengths);
        let scaled = |right: &DVector<f64>| (&self.inverse * right).component_div(lengths);
        // A second time, to correct rounding of the inverse.
        let first = scaled(&right);
        let rest = (&self.right - &self.matrix * &first).component_div(lengths);
        first + scaled(&rest)
    }

    fn covariance(&self) -> DMatrix<f64> {
        self.normal.divide(&self.inverse)
    }
}

fn not_excited(open: Vec<usize>, base: &BaseParameters) -> IdentifyError {
    IdentifyError::NotExcited {
        unknowns: open.into_iter().map(|k| base.meaning(k)).collect(),
    }
}

impl Estimate {
    /// Degrees of freedom: number of equations minus base parameters.
    pub fn freedom(&self) -> usize {
        self.equations.iter().sum::<usize>() - self.base.len()
    }

    /// Confidence intervals of the base parameters, by Student's t.
    ///
    /// * `level` – probability that an interval contains the true value, for example 0.95
    ///
    /// # Panics
    /// If the level is not between 0 and 1.
    pub fn intervals(&self, level: f64) -> Vec<Interval> {
        check_level(level);
        let factor = two_sided(level, self.freedom() as f64);
        let interval = |k: usize| {
            let (value, deviation) = (self.values[k], self.covariance[(k, k)].sqrt());
            Interval::new(self.base.meaning(k), value, deviation, factor)
        };
        (0..self.base.len()).map(interval).collect()
    }

    /// Values of all unknowns with these base parameters; undetermined combinations keep their nominal value. They may be physically inconsistent:
    /// check with [`Model::inertia_flaws`](crate::Model::inertia_flaws), or use a [`consistent`](Self::consistent) estimate.
    pub fn unknowns(&self) -> DVector<f64> {
        self.base.unknowns(&self.values, self.regressor.nominal())
    }

    /// The robot with [these](Self::unknowns) values. Use it to predict forces; for simulation it may be physically inconsistent.
    pub fn robot(&self) -> Robot {
        Robot::of(&self.regressor, &self.unknowns())
    }
}
