//! The condition of a motion as an objective, with its gradient.

use nalgebra::{DMatrix, DVector};

use super::{Excitation, ExcitationOptions, MotionPoint};
use crate::identify::base::BaseParameters;
use crate::identify::error::IdentifyError;
use crate::identify::normal::Normal;
use crate::identify::regressor::Regressor;
use crate::identify::series::{Bounds, Series};
use crate::minimize::Objective;
use crate::model::manifold::q_range;
use crate::nested::IntoNested;
use crate::scalar::Dual;

/// Directions that are differentiated at once.
const DIRECTIONS: usize = 8;

/// The condition as a function of coefficients.
pub(super) struct Problem<'a> {
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
    pub(super) fn new(
        regressor: &'a Regressor,
        options: &ExcitationOptions,
    ) -> Result<Self, IdentifyError> {
        let model = regressor.model();
        let (mut center, mut series) = (vec![0.0; model.nq()], Vec::new());
        for (id, body) in model.independent_with_ids() {
            let limits = model.body_joint(id).map(|joint| *model.limits(joint));
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
                return Err(IdentifyError::option(
                    format!("joint \"{}\"", model.joint_name(id)),
                    "its limits leave no motion",
                ));
            }
            center[q_range(body).start] = middle;
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

    pub(super) fn n_variables(&self) -> usize {
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

    pub(super) fn motion(&self, x: &[f64]) -> Excitation {
        Excitation {
            period: self.period,
            center: self.center.clone(),
            coefficients: self.coefficients(x),
            condition: f64::INFINITY,
            start_condition: f64::INFINITY,
        }
    }

    pub(super) fn excitation(&self, start: &[f64], x: &[f64]) -> Excitation {
        Excitation {
            condition: self.condition(start, x).1,
            start_condition: self.condition(start, x).0,
            ..self.motion(x)
        }
    }

    /// Condition numbers of a start and of a solution.
    pub(super) fn condition(&self, start: &[f64], x: &[f64]) -> (f64, f64) {
        let of = |x: &[f64]| {
            let Some(found) = Inverted::of(&self.equations(&self.motion(x))) else {
                return f64::INFINITY;
            };
            let values = found.normal.scaled.symmetric_eigenvalues();
            (values.max() / values.min()).sqrt()
        };
        (of(start), of(x))
    }

    /// Times of the moments of a period.
    pub(super) fn times(&self) -> impl Iterator<Item = f64> + '_ {
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
            for (column, &unknown) in self.base.independent.iter().enumerate() {
                for row in 0..nv {
                    out[(k * nv + row, column)] = self.weights[row] * own[(row, unknown)];
                }
            }
        }
        out
    }

    /// Derivatives of Σ w̄ · w of a moment in q, v and a, one after another.
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
            for (column, &unknown) in self.base.independent.iter().enumerate() {
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

/// Normal matrix with its inverse S⁻¹.
struct Inverted {
    normal: Normal,
    inverse: DMatrix<f64>,
}

impl Inverted {
    /// `None` if it is singular.
    fn of(equations: &DMatrix<f64>) -> Option<Self> {
        let normal = Normal::new(&equations.tr_mul(equations));
        let inverse = normal.scaled.clone().cholesky()?.inverse();
        let is_finite = inverse.iter().all(|x| x.is_finite());
        is_finite.then_some(Self { normal, inverse })
    }

    /// ½ ln(tr S⁻¹ / n), zero where columns are orthogonal.
    fn value(&self) -> f64 {
        0.5 * (self.inverse.trace() / self.inverse.nrows() as f64).ln()
    }

    /// Derivatives G of the value in the normal matrix N before scaling: with t = tr S⁻¹ and lengths lᵢ = √Nᵢᵢ,
    /// G = (−S⁻²ᵢₖ / (lᵢ lₖ) + δᵢₖ S⁻¹ᵢᵢ / lᵢ²) / 2 t.
    fn slopes(&self) -> DMatrix<f64> {
        let square = &self.inverse * &self.inverse;
        let half = 0.5 / self.inverse.trace();
        let own = DMatrix::from_diagonal(&self.inverse.diagonal());
        self.normal.divide(&((own - square) * half))
    }
}

impl Objective for Problem<'_> {
    fn value(&self, x: &[f64]) -> f64 {
        let equations = self.equations(&self.motion(x));
        Inverted::of(&equations).map_or(f64::INFINITY, |normal| normal.value())
    }

    fn gradient(&self, x: &[f64]) -> DVector<f64> {
        let (motion, n) = (self.motion(x), 2 * self.harmonics);
        let equations = self.equations(&motion);
        let Some(normal) = Inverted::of(&equations) else {
            return DVector::from_element(x.len(), f64::NAN);
        };
        let weights = equations * normal.slopes() * 2.0;
        let nv = self.weights.len();
        // Derivatives in the coefficients that are bounded, then in the variables.
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
        let all = rows.nested(|(i, (series, x))| {
            let own: Vec<f64> = by_coefficient.row(i).iter().copied().collect();
            series.bounded_derivatives(x, &own)
        });
        DVector::from_vec(all.collect())
    }
}
