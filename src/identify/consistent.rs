//! Physically consistent estimates.
//!
//! Least squares ignores physical consistency: if the motion contains little information on a small moment of inertia, its estimate is often not that
//! of a body. Here the pseudo-inertia of each body stays positive definite, and damping, rotor inertias and dry friction stay nonnegative: a
//! semidefinite program. The data enter only by the estimate and its covariance, so the computing time does not depend on their number.
//!
//! It is solved by [`barrier`](super::barrier). Clarabel's cone of such matrices needs BLAS and LAPACK, that is a Fortran compiler or a library of the system, which
//! this crate does not ask for; and Levenberg and Marquardt's method in log-Cholesky parameters creeps where the solution is at the boundary, at infinite
//! parameters, which is the rule: it is what a test compares with.

use nalgebra::{DMatrix, DVector, Matrix3, Matrix4};

use super::barrier::{Cone, Program, inertia, root_transposed};
use super::error::{IdentifyError, check_positive};
use super::estimate::Estimate;
use super::regressor::Unknown;
use super::robot::Robot;
use crate::model::{BodyId, Model};
use crate::nested::IntoNested;
use crate::spatial::{INERTIAL_PARAMETERS, Inertia};

/// Options of [`Estimate::consistent`].
#[derive(Clone, Debug, PartialEq)]
pub struct ConsistencyOptions {
    /// Weight of the distance from the nominal robot, which determines parameters that the forces do not; 1e-4 by default. A distance of 1 is a
    /// relative change of a pseudo-inertia by 100 %. The weight is relative to the information of the data: a parameter that the data determine to 1
    /// % has the weight 10⁴. A larger weight moves poorly determined parameters towards the nominal robot.
    pub regularization: f64,
    /// Maximum difference of the cost from the minimum, in units in which one error of one standard deviation costs ½; 1e-4 by default, far below the
    /// resolution of data. A smaller value takes more iterations, and lets bodies come nearer to the boundary of physical consistency.
    pub gap: f64,
}

impl Default for ConsistencyOptions {
    fn default() -> Self {
        Self {
            regularization: 1e-4,
            gap: 1e-4,
        }
    }
}

/// The physically consistent robot nearest to the data.
#[derive(Clone, Debug)]
pub struct ConsistentEstimate {
    /// Values of all unknowns.
    pub unknowns: DVector<f64>,
    /// The robot with these values.
    pub robot: Robot,
    /// Increase of Σ (τ − Y x)² / σ² over the unconstrained estimate. An increase up to about the number of base parameters is random. A much larger
    /// increase means that the data contradict all rigid robots with these joints: a wrong unit, sign or delay, or a force that is not modelled.
    pub excess: f64,
    /// Upper bound of the difference of the cost from the minimum; larger than the option only if rounding ends the iterations earlier.
    pub gap: f64,
    /// Number of iterations.
    pub iterations: usize,
}

impl Estimate {
    /// Finds the physically consistent robot nearest to the data.
    ///
    /// Minimises (β(x) − β̂)ᵀ Σ⁻¹ (β(x) − β̂) + μ d(x)² with the covariance Σ of the estimate, over bodies whose pseudo-inertia is positive definite, and
    /// damping, rotors and dry friction that are not negative; d is the distance of the pseudo-inertias P from the nominal ones,
    /// Σ ‖U⁻¹ (P − P₀) U⁻ᵀ‖² with P₀ = U Uᵀ, plus that of other unknowns. The [intervals](Estimate::intervals) of the estimate remain valid:
    /// constraints do not widen them.
    ///
    /// Inertias stay inside the cone, possibly near its boundary: a moment of inertia may become very small, but never negative.
    ///
    /// # Errors
    /// If an option is out of its range.
    ///
    /// # References
    /// [Rucker, Wensing 2022; Lee, Wensing, Park 2020; Sousa, Cortesão 2014].
    pub fn consistent(
        &self,
        options: &ConsistencyOptions,
    ) -> Result<ConsistentEstimate, IdentifyError> {
        check_positive([
            ("regularization", options.regularization),
            ("gap", options.gap),
        ])?;
        let program = program(self, options.regularization);
        let found = program.solve(options.gap);
        let fit = &program.map * &found.x - &program.target;
        Ok(ConsistentEstimate {
            robot: Robot::of(&self.regressor, &found.x),
            unknowns: found.x,
            excess: fit.norm_squared(),
            gap: found.gap,
            iterations: found.iterations,
        })
    }
}

/// The semidefinite program of an estimate.
pub(super) fn program(estimate: &Estimate, regularization: f64) -> Program {
    let regressor = &estimate.regressor;
    let (mut cones, mut nominal) = (Vec::new(), regressor.nominal().clone());
    let mut numbers = Vec::new();
    for (k, unknown) in regressor.unknowns().iter().enumerate() {
        match *unknown {
            Unknown::Inertia { body, number: 0 } => {
                let own = possible(regressor.model(), body).to_parameters();
                nominal
                    .rows_mut(k, INERTIAL_PARAMETERS)
                    .copy_from_slice(&own);
                cones.push(Cone::Body(k));
            }
            Unknown::Inertia { .. } => {}
            _ => numbers.push(k),
        }
        if unknown.is_not_negative() {
            cones.push(Cone::NotNegative(k));
        }
    }
    let root = root_transposed(&estimate.information);
    Program {
        metric: metric(&cones, &numbers, &nominal) * regularization.sqrt(),
        map: &root * estimate.base.map(),
        target: &root * &estimate.values,
        cones,
        nominal,
    }
}

/// The inertia of a body, made that of a solid where it is that of a point, a rod, a plate or of no body at all.
pub(super) fn possible(model: &Model, body: BodyId) -> Inertia<f64> {
    /// Share of the mean moment of mass that the least one has at least.
    const LEAST: f64 = 1e-2;
    /// Share of the robot's mass for a body without mass.
    const LIGHT: f64 = 1e-3;
    /// Least radius of gyration, m.
    const RADIUS: f64 = 1e-2;
    let own = &model.body(body).inertia;
    let all: f64 = model
        .bodies()
        .iter()
        .map(|body| body.inertia.mass.max(0.0))
        .sum();
    let mass = own.mass.max(LIGHT * all).max(f64::MIN_POSITIVE.sqrt());
    let center = own.first_moment / mass;
    let pseudo = own.to_pseudo_inertia();
    let about_center = pseudo.fixed_view::<3, 3>(0, 0) - center * center.transpose() * mass;
    let eigen = about_center.symmetric_eigen();
    let positive = eigen.eigenvalues.map(|x| x.max(0.0));
    let mean = (positive.sum() / 3.0).max(mass * RADIUS * RADIUS);
    let moments = positive.map(|x| x.max(LEAST * mean));
    let turn = eigen.eigenvectors;
    let sigma: Matrix3<f64> = turn * Matrix3::from_diagonal(&moments) * turn.transpose();
    let mut out = Matrix4::zeros();
    out.fixed_view_mut::<3, 3>(0, 0)
        .copy_from(&(sigma + center * center.transpose() * mass));
    out.fixed_view_mut::<3, 1>(0, 3).copy_from(&(center * mass));
    out.fixed_view_mut::<1, 3>(3, 0)
        .copy_from(&(center * mass).transpose());
    out[(3, 3)] = mass;
    Inertia::from_pseudo_inertia(&out)
}

/// The linear map from unknowns to distances: ten entries of U⁻¹ P U⁻ᵀ for each body, so that their squares are those of the whole matrix; the others in
/// units of their size, at least 1.
fn metric(cones: &[Cone], numbers: &[usize], nominal: &DVector<f64>) -> DMatrix<f64> {
    let mut rows: Vec<DVector<f64>> = Vec::new();
    for &k in numbers {
        let mut row = DVector::zeros(nominal.len());
        row[k] = nominal[k].abs().max(1.0).recip();
        rows.push(row);
    }
    for cone in cones {
        if let Cone::Body(first) = *cone {
            rows.extend(body_metric(first, nominal));
        }
    }
    DMatrix::from_fn(rows.len(), nominal.len(), |i, k| rows[i][k])
}

/// The rows of a body.
fn body_metric(first: usize, nominal: &DVector<f64>) -> Vec<DVector<f64>> {
    let own = inertia(nominal, first).to_pseudo_inertia();
    let inverse = own.cholesky().and_then(|factor| factor.l().try_inverse());
    let inverse = inverse.unwrap_or_else(Matrix4::identity);
    let mut rows = vec![DVector::zeros(nominal.len()); INERTIAL_PARAMETERS];
    for k in 0..INERTIAL_PARAMETERS {
        let unit = Inertia::unit(k).to_pseudo_inertia();
        let seen = inverse * unit * inverse.transpose();
        let entries = (0..4).nested(|i| (i..4).map(move |j| (i, j)));
        for (row, (i, j)) in rows.iter_mut().zip(entries) {
            let both = if i == j {
                1.0
            } else {
                std::f64::consts::SQRT_2
            };
            row[first + k] = both * seen[(i, j)];
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::tests::random_segment;
    use crate::identify::{Dataset, DryFriction, Regressor, estimate};
    use crate::least_squares::{Options, Residuals, solve};
    use crate::model::samples;
    use crate::scalar::Dual;

    /// The program in log-Cholesky parameters, of which each body has ten, as least squares.
    struct LogCholesky<'a>(&'a Program);

    impl LogCholesky<'_> {
        fn bodies(&self) -> impl Iterator<Item = usize> + '_ {
            self.0.cones.iter().filter_map(|cone| match cone {
                Cone::Body(first) => Some(*first),
                Cone::NotNegative(_) => None,
            })
        }

        fn start(&self) -> Vec<f64> {
            let mut out = self.0.nominal.as_slice().to_vec();
            for first in self.bodies() {
                out[first..first + 10]
                    .copy_from_slice(&inertia(&self.0.nominal, first).to_log_cholesky());
            }
            out
        }

        fn unknowns(&self, x: &[f64]) -> DVector<f64> {
            let mut out = DVector::from_column_slice(x);
            for first in self.bodies() {
                let own = Inertia::from_log_cholesky(std::array::from_fn(|i| x[first + i]));
                out.rows_mut(first, 10)
                    .copy_from_slice(&own.to_parameters());
            }
            out
        }
    }

    impl Residuals for LogCholesky<'_> {
        fn n_residuals(&self) -> usize {
            self.0.map.nrows() + self.0.metric.nrows()
        }

        fn residuals(&mut self, x: &[f64], out: &mut [f64]) {
            let unknowns = self.unknowns(x);
            let fit = &self.0.map * &unknowns - &self.0.target;
            let distance = &self.0.metric * (unknowns - &self.0.nominal);
            let all = fit.iter().chain(&distance);
            out.iter_mut().zip(all).for_each(|(out, r)| *out = *r);
        }

        fn jacobian(&mut self, x: &[f64], out: &mut DMatrix<f64>) {
            let mut slopes = DMatrix::identity(x.len(), x.len());
            for first in self.bodies() {
                let theta = std::array::from_fn(|i| {
                    let mut seeded = Dual::<f64, 10>::from(x[first + i]);
                    seeded.eps[i] = 1.0;
                    seeded
                });
                for (i, number) in Inertia::from_log_cholesky(theta)
                    .to_parameters()
                    .iter()
                    .enumerate()
                {
                    for (j, slope) in number.eps.iter().enumerate() {
                        slopes[(first + i, first + j)] = *slope;
                    }
                }
            }
            let n = self.0.map.nrows();
            out.rows_mut(0, n).copy_from(&(&self.0.map * &slopes));
            out.rows_mut(n, self.0.metric.nrows())
                .copy_from(&(&self.0.metric * &slopes));
        }
    }

    // Levenberg and Marquardt's method in log-Cholesky parameters stays inside the cones, so that no cost of its is below the least; and it comes near.
    #[test]
    fn semidefinite_program_is_no_worse_than_log_cholesky_parameters_and_hardly_better() {
        let model = samples::arm();
        let shape = DryFriction::Smooth {
            slip_velocity: 0.05,
        };
        let robot = Robot {
            model: model.clone(),
            shape: Some(shape),
            dry_friction: vec![0.0; 7],
            offsets: vec![0.0; 7],
        };
        let regressor = Regressor::new(&model.scaled(1.0, 1.3).unwrap()).with_damping();
        let regressor = regressor.with_dry_friction(shape).unwrap();
        for seed in 0..2 {
            let deviations = [0.5, 0.4, 0.3, 0.2, 0.1, 0.05, 0.02];
            let data = Dataset::new(vec![random_segment(&robot, 150, &deviations, seed)]);
            let found = estimate(&regressor, &data).unwrap();
            let mended = found.consistent(&ConsistencyOptions::default()).unwrap();
            assert!(mended.gap <= 1e-4, "{}", mended.gap);
            let program = program(&found, ConsistencyOptions::default().regularization);
            let mut creeping = LogCholesky(&program);
            let mut lower = vec![f64::NEG_INFINITY; program.nominal.len()];
            for cone in &program.cones {
                if let Cone::NotNegative(k) = cone {
                    lower[*k] = 0.0;
                }
            }
            let options = Options::default().with_bounds(&lower, &vec![f64::INFINITY; lower.len()]);
            let start = creeping.start();
            let other = solve(&mut creeping, &start, &options);
            let least = program.cost(&mended.unknowns);
            assert!(least < other.cost + 1e-4, "{seed}: {least} {}", other.cost);
            assert!(other.cost < 1.1 * least, "{seed}: {least} {}", other.cost);
        }
    }
}
