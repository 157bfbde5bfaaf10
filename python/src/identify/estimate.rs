//! Weighted and consistent least squares, the report.

use dualbody::identify::{ConsistencyOptions, Estimate, Interval, Report, estimate};
use dualbody::view::identification_page;
use pyo3::prelude::*;

use super::data::data_of;
use super::regressor::regressor_of;
use super::robot::{RobotNumbers, numbers_of, robot_of};
use crate::arrays::{Array, matrix, vector};
use crate::errors::{OrRaise, guarded};

/// Name, value, standard deviation, lower and upper end.
pub(super) type IntervalNumbers = (String, f64, f64, f64, f64);

pub(super) fn interval(own: Interval) -> IntervalNumbers {
    (own.name, own.value, own.deviation, own.lower, own.upper)
}

/// Base parameters by weighted least squares.
#[pyclass(frozen, name = "_Estimate", module = "dualbody.identify")]
pub(crate) struct PyEstimate {
    estimate: Estimate,
}

/// Estimates the base parameters of a robot from data.
#[pyfunction]
pub(crate) fn _estimate(
    py: Python<'_>,
    regressor: &Bound<'_, PyAny>,
    data: &Bound<'_, PyAny>,
) -> PyResult<PyEstimate> {
    let (regressor, data) = (regressor_of(regressor)?, data_of(data)?);
    let estimate = py.detach(|| guarded(|| estimate(&regressor, &data)))?;
    Ok(PyEstimate {
        estimate: estimate.or_raise()?,
    })
}

#[pymethods]
impl PyEstimate {
    /// (values, covariance, force deviations, equations, condition, degrees of freedom, all unknowns).
    fn numbers<'py>(
        &self,
        py: Python<'py>,
    ) -> (
        Bound<'py, PyAny>,
        Array<'py>,
        Vec<f64>,
        Vec<usize>,
        f64,
        usize,
        Bound<'py, PyAny>,
    ) {
        let own = &self.estimate;
        (
            vector(py, own.values.as_slice().to_vec()).into_any(),
            matrix(py, &own.covariance),
            own.force_deviations.clone(),
            own.equations.clone(),
            own.condition,
            own.freedom(),
            vector(py, own.unknowns().as_slice().to_vec()).into_any(),
        )
    }

    /// Confidence intervals of the base parameters.
    fn intervals(&self, level: f64) -> PyResult<Vec<IntervalNumbers>> {
        let all = guarded(|| self.estimate.intervals(level))?;
        Ok(all.into_iter().map(interval).collect())
    }

    /// The robot with what was found.
    fn robot<'py>(&self, py: Python<'py>) -> PyResult<RobotNumbers<'py>> {
        Ok(numbers_of(py, &guarded(|| self.estimate.robot())?))
    }

    /// A robot that can be: (unknowns, robot, excess, gap, iterations).
    fn consistent<'py>(
        &self,
        py: Python<'py>,
        regularization: Option<f64>,
        gap: Option<f64>,
    ) -> PyResult<(Bound<'py, PyAny>, RobotNumbers<'py>, f64, f64, usize)> {
        let mut options = ConsistencyOptions::default();
        options.regularization = regularization.unwrap_or(options.regularization);
        options.gap = gap.unwrap_or(options.gap);
        let found = py.detach(|| guarded(|| self.estimate.consistent(&options)))?;
        let found = found.or_raise()?;
        let unknowns = vector(py, found.unknowns.as_slice().to_vec()).into_any();
        let robot = numbers_of(py, &found.robot);
        Ok((unknowns, robot, found.excess, found.gap, found.iterations))
    }

    /// Text and page of the report.
    fn report(
        &self,
        robot: &Bound<'_, PyAny>,
        validation: &Bound<'_, PyAny>,
        level: f64,
    ) -> PyResult<(String, String)> {
        let (robot, data) = (robot_of(robot)?, data_of(validation)?);
        let report = guarded(|| Report::new(&self.estimate, &robot, &data, level))?.or_raise()?;
        Ok((report.to_string(), identification_page(&report)))
    }
}
