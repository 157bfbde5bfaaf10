//! What touches.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

use super::handle::PySimulator;
use crate::arrays::vector;

#[pymethods]
impl PySimulator {
    /// What touches and how in a state under an input: a ContactReport.
    #[pyo3(signature = (q, v, u=None, *, contact=None))]
    fn contact_report<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = q.py();
        let given = self.one(q, v, u, contact)?;
        let report = self.with_memory(&given, |memory| {
            self.simulator.contact_report(&memory.state, &memory.u)
        })?;
        let rows = |n: usize, x: Vec<f64>| {
            PyArray1::from_vec(py, x).reshape([report.points.len().min(n), 3])
        };
        let n = report.points.len();
        let three = |f: fn(&dualbody::contact::PointState<f64>) -> [f64; 3]| {
            rows(n, report.points.iter().flat_map(f).collect())
        };
        let forces = report.forces.iter().flat_map(|f| [f.x, f.y, f.z]).collect();
        let links: Vec<f64> = report.links.iter().flat_map(|f| f.to_array()).collect();
        let links = PyArray1::from_vec(py, links).reshape([report.links.len(), 6])?;
        let c = &report.certificate;
        let certificate = (
            format!("{:?}", c.status),
            c.iterations,
            c.residual,
            c.cone_violation,
            c.complementarity,
            c.dual_violation,
        );
        let depths: Vec<f64> = report.points.iter().map(|p| p.depth).collect();
        let fields = (
            three(|p| p.position.into())?,
            three(|p| p.velocity.into())?,
            three(|p| p.normal.into())?,
            vector(py, depths),
            rows(n, forces)?,
            links,
            report
                .modes
                .iter()
                .map(|mode| format!("{mode:?}"))
                .collect::<Vec<_>>(),
            report
                .reasons
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>(),
            vector(py, report.constraints.clone()),
            certificate,
        );
        py.import("dualbody.sim")?
            .getattr("ContactReport")?
            .call1(fields)
    }
}
