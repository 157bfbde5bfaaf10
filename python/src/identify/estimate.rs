//! Weighted and consistent least squares, the report.

use dualbody::identify::{
    BaseParameters, ConsistencyOptions, Estimate, Interval, Report, estimate,
};
use dualbody::view::identification_page;

use super::data::data_of;
use super::regressor::regressor_of;
use super::robot::{RobotNumbers, numbers_of, robot_of};
use crate::prelude::*;

/// Name, value, standard deviation, lower and upper end.
pub(super) type IntervalNumbers = (String, f64, f64, f64, f64);

pub(super) fn interval(own: Interval) -> IntervalNumbers {
    (own.name, own.value, own.deviation, own.lower, own.upper)
}

functions! {
    /// Estimates the base parameters of a robot from data: (values, covariance, information, force deviations, equations, condition, degrees of freedom, all unknowns).
    fn _estimate(py: Python, regressor, data) -> PyResult<Bound<'py, PyTuple>> {
        let (regressor, data) = (regressor_of(regressor)?, data_of(data)?);
        let found = py.detach(|| guarded(|| estimate(&regressor, &data)))?;
        let own = found.or_raise()?;
        let (freedom, unknowns) = (own.freedom(), own.unknowns());
        let values = vector(py, own.values.as_slice());
        let [covariance, information] = [own.covariance, own.information].map(|own| matrix(py, &own));
        let unknowns = vector(py, unknowns.as_slice());
        (values, covariance, information, own.force_deviations, own.equations, own.condition, freedom, unknowns).into_pyobject(py)
    }
}

/// The estimate that Python has.
fn estimate_of(value: &Bound<'_, PyAny>) -> PyResult<Estimate> {
    let regressor = regressor_of(&value.getattr("regressor")?)?;
    let base = guarded(|| BaseParameters::new(&regressor))?;
    let (n, nv) = (base.len(), regressor.model().nv());
    let square = |name| read_matrix_of(name, &value.getattr(name)?, (n, n));
    let force_deviations: Vec<f64> = attribute(value, "force_deviations")?;
    let equations: Vec<usize> = attribute(value, "equations")?;
    if [force_deviations.len(), equations.len()] != [nv; 2] {
        refuse!("force_deviations and equations are not {nv} each");
    }
    Ok(Estimate {
        values: read_vector("values", &value.getattr("values")?, Some(n))?.into(),
        covariance: square("covariance")?,
        information: square("information")?,
        force_deviations,
        equations,
        condition: attribute(value, "condition")?,
        regressor,
        base,
    })
}

functions! {
    /// Confidence intervals of the base parameters.
    fn _intervals(estimate, level: f64) -> PyResult<Vec<IntervalNumbers>> {
        let own = estimate_of(estimate)?;
        let all = guarded(|| own.intervals(level))?;
        Ok(all.into_iter().map(interval).collect())
    }

    /// The robot with what was found.
    fn _identified(estimate) -> PyResult<RobotNumbers<'py>> { Ok(numbers_of(estimate.py(), &estimate_of(estimate)?.robot())) }

    /// A physically consistent robot: (unknowns, robot, excess, gap, iterations).
    fn _consistent(estimate, regularization: Option<f64>, gap: Option<f64>) -> PyResult<(Bound<'py, PyAny>, RobotNumbers<'py>, f64, f64, usize)> {
        let (py, own) = (estimate.py(), estimate_of(estimate)?);
        let mut options = ConsistencyOptions::default();
        options.regularization = regularization.unwrap_or(options.regularization);
        options.gap = gap.unwrap_or(options.gap);
        let found = on_pool_stopped(py, || own.consistent(&options))?.or_raise()?;
        let unknowns = vector(py, found.unknowns.as_slice());
        let robot = numbers_of(py, &found.robot);
        Ok((unknowns, robot, found.excess, found.gap, found.iterations))
    }

    /// Text and page of the report.
    fn _report(estimate, robot, validation, level: f64) -> PyResult<(String, String)> {
        let (own, robot, data) = (estimate_of(estimate)?, robot_of(robot)?, data_of(validation)?);
        let report = guarded(|| Report::new(&own, &robot, &data, level))?.or_raise()?;
        Ok((report.to_string(), identification_page(&report)))
    }
}
