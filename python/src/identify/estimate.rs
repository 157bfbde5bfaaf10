//! Weighted and consistent least squares, the report.

use dualbody::identify::{
    BaseParameters, ConsistencyOptions, Estimate, Interval, Report, estimate,
};
use dualbody::view::identification_page;
use pyo3::prelude::*;

use super::data::data_of;
use super::regressor::regressor_of;
use super::robot::{RobotNumbers, numbers_of, robot_of};
use crate::arrays::{Array, matrix, read_matrix, read_vector, vector};
use crate::errors::{OrRaise, guarded, shape_error, value_error};
use crate::threads::on_pool_stopped;

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

/// An estimate of which the numbers are known: those of [`PyEstimate::numbers`].
#[pyfunction]
pub(crate) fn _restored_estimate(
    regressor: &Bound<'_, PyAny>,
    values: &Bound<'_, PyAny>,
    matrices: [Bound<'_, PyAny>; 2],
    force_deviations: Vec<f64>,
    equations: Vec<usize>,
    condition: f64,
) -> PyResult<PyEstimate> {
    let regressor = regressor_of(regressor)?;
    let base = guarded(|| BaseParameters::new(&regressor))?;
    let (n, nv) = (base.len(), regressor.model().nv());
    let square = |name, value| match read_matrix(name, value)? {
        m if m.shape() == (n, n) => Ok(m),
        m => Err(shape_error(name, m.shape(), format_args!("({n}, {n})"))),
    };
    if [force_deviations.len(), equations.len()] != [nv; 2] {
        return Err(value_error(format_args!(
            "force_deviations and equations are not {nv} each"
        )));
    }
    Ok(PyEstimate {
        estimate: Estimate {
            values: read_vector("values", values, Some(n))?.into(),
            covariance: square("covariance", &matrices[0])?,
            information: square("information", &matrices[1])?,
            force_deviations,
            equations,
            condition,
            regressor,
            base,
        },
    })
}

#[pymethods]
impl PyEstimate {
    /// (values, (covariance, information), force deviations, equations, condition, degrees of freedom, all unknowns).
    fn numbers<'py>(
        &self,
        py: Python<'py>,
    ) -> (
        Bound<'py, PyAny>,
        [Array<'py>; 2],
        Vec<f64>,
        Vec<usize>,
        f64,
        usize,
        Bound<'py, PyAny>,
    ) {
        let own = &self.estimate;
        (
            vector(py, own.values.as_slice().to_vec()).into_any(),
            [&own.covariance, &own.information].map(|m| matrix(py, m)),
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
        let found = on_pool_stopped(py, || self.estimate.consistent(&options))?;
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
