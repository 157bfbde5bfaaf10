//! Reports of results.

use std::fmt;

use nalgebra::DMatrix;

use super::dataset::Dataset;
use super::error::IdentifyError;
use super::estimate::{Estimate, Interval};
use super::robot::Robot;
use super::validation::ForceError;
use crate::joint::JointKind;
use crate::model::FLOATING_BASE;

/// Report of an identification: estimates, their uncertainty, and prediction errors.
///
/// `Display` writes it as text; `view::identification_page` (feature `view`) makes an HTML page.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// Name of the robot.
    pub robot: String,
    /// Level of the confidence intervals.
    pub level: f64,
    /// Number of equations.
    pub equations: usize,
    /// Condition number of the weighted regressor.
    pub condition: f64,
    /// Base parameters with their intervals.
    pub base: Vec<Interval>,
    /// Each velocity coordinate.
    pub coordinates: Vec<CoordinateReport>,
    /// Flaws of inertias, link by link; empty for a physically consistent robot.
    pub flaws: Vec<String>,
    /// Measured and predicted forces of the data for validation.
    pub traces: Vec<Trace>,
}

/// Forces along a velocity coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct CoordinateReport {
    /// Name of the joint, with the index of the coordinate if it has several.
    pub name: String,
    /// Standard deviation of the force in the training data, N·m or N.
    pub deviation: f64,
    /// Errors of the prediction on the data for validation.
    pub error: ForceError,
}

/// Measured and predicted forces of a segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Name of the experiment.
    pub experiment: String,
    /// Time of each sample, s.
    pub times: Vec<f64>,
    /// Measured forces, `nv` × samples.
    pub measured: DMatrix<f64>,
    /// Predicted forces, `nv` × samples.
    pub predicted: DMatrix<f64>,
}

impl Report {
    /// Makes the report of an identified robot.
    ///
    /// * `robot` – [`Estimate::robot`], or that of a [consistent](Estimate::consistent) estimate
    /// * `validation` – data for validation
    /// * `level` – probability that an interval contains the true value, for example 0.95
    ///
    /// # Errors
    /// If the data belong to another robot.
    ///
    /// # Panics
    /// If the level is not between 0 and 1.
    pub fn new(
        estimate: &Estimate,
        robot: &Robot,
        validation: &Dataset,
        level: f64,
    ) -> Result<Self, IdentifyError> {
        let found = robot.validate(validation)?;
        let names = (robot.model).coordinate_names(JointKind::nv, FLOATING_BASE);
        let coordinates = names
            .zip(&estimate.force_deviations)
            .zip(&found.coordinates);
        let traces = validation.segments.iter().zip(found.predicted);
        let flaws = robot.model.inertia_flaws();
        Ok(Self {
            robot: robot.model.name().into(),
            level,
            equations: estimate.equations.iter().sum(),
            condition: estimate.condition,
            base: estimate.intervals(level),
            coordinates: coordinates
                .map(|((name, &deviation), &error)| CoordinateReport {
                    name,
                    deviation,
                    error,
                })
                .collect(),
            flaws: flaws
                .iter()
                .map(|(link, flaw)| format!("{link}: {flaw}"))
                .collect(),
            traces: traces
                .map(|(segment, predicted)| Trace {
                    experiment: segment.experiment.clone(),
                    times: (0..segment.len()).map(|k| segment.time(k)).collect(),
                    measured: segment.tau.clone(),
                    predicted,
                })
                .collect(),
        })
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: {} base parameters from {} equations, condition {:.1}",
            self.robot,
            self.base.len(),
            self.equations,
            self.condition
        )?;
        writeln!(
            f,
            "\n{:>12} {:>12} {:>12} {:>12}  force [N·m, N]",
            "learnt σ", "validation", "mean", "largest"
        )?;
        for own in &self.coordinates {
            let ForceError {
                rms, mean, largest, ..
            } = own.error;
            writeln!(
                f,
                "{:>12.4e} {rms:>12.4e} {mean:>12.4e} {largest:>12.4e}  {}",
                own.deviation, own.name
            )?;
        }
        writeln!(
            f,
            "\n{:>14} {:>11}  base parameter, ± half the interval of {} %",
            "value",
            "±",
            100.0 * self.level
        )?;
        for own in &self.base {
            let half = 0.5 * (own.upper - own.lower);
            writeln!(f, "{:>14.6e} {half:>11.2e}  {}", own.value, own.name)?;
        }
        match self.flaws.is_empty() {
            true => writeln!(f, "\nall inertias are physically consistent"),
            false => writeln!(
                f,
                "\nthese inertias are not physically consistent: {}",
                self.flaws.join("; ")
            ),
        }
    }
}
