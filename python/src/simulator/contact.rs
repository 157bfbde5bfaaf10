//! Contacts of a simulator.

use dualbody::cone::Certificate;
use dualbody::contact::PointState;
use dualbody::sim::ContactReport;

use crate::prelude::*;

methods! { PySimulator {
    /// Remarks on a time step that is too long for springs, dampers, limits and soft contact near this pose, and for rotations if a velocity is given.
    fn remarks(&self, q, v = None) -> PyResult<Vec<String>> {
        let model = self.simulator.model();
        let q = read_vector("q", q, Some(model.nq()))?;
        let said = match v {
            None => self.simulator.remarks(&q),
            Some(v) => {
                let v = read_vector("v", v, Some(model.nv()))?;
                self.simulator.remarks_at(&q, &v)
            }
        };
        Ok(said.iter().map(ToString::to_string).collect())
    }

    /// Report on contact in a state under an input: a ContactReport.
    fn contact_report(&self, q, v, u = None, *, contact = None) -> PyResult<Bound<'py, PyAny>> {
        let py = q.py();
        let given = self.one(q, v, u, contact)?;
        let report = self.with_memory(&given, |memory| {
            self.simulator.contact_report(&memory.state, &memory.u)
        })?;
        let fields = (
            points(py, &report, |p| p.position.into()),
            points(py, &report, |p| p.velocity.into()),
            points(py, &report, |p| p.normal.into()),
            vector(py, &Vec::from_iter(report.points.iter().map(|p| p.depth))),
            rows(py, report.forces.iter().map(|f| [f.x, f.y, f.z])),
            rows(py, report.links.iter().map(|f| f.to_array())),
            words(&report.modes, |mode| snake(mode)),
            words(&report.reasons, ToString::to_string),
            vector(py, &report.constraints),
            certificate(&report.certificate),
            self.pairs(py, &report)?,
        );
        of_package!(py, "_rollout", "ContactReport").call1(fields)
    }
} }

impl PySimulator {
    /// Points between bodies: a PairContact each.
    fn pairs<'py>(
        &self,
        py: Python<'py>,
        report: &ContactReport,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let class = of_package!(py, "_rollout", "PairContact");
        let frames = self.simulator.model().frames();
        let xyz = |x: &nalgebra::Vector3<f64>| vector(py, x.as_slice());
        let pairs = report.pairs.iter().map(|pair| {
            let [first, second] = pair.links.map(|link| frames[link.0].name.as_str());
            let point = &pair.point;
            class.call1((
                (first, second),
                xyz(&point.position),
                xyz(&point.velocity),
                xyz(&point.normal),
                point.depth,
                xyz(&pair.force),
                snake(pair.mode),
                pair.reason.to_string(),
            ))
        });
        pairs.collect()
    }
}

/// An array with a row of N numbers for each item.
fn rows<'py, const N: usize>(
    py: Python<'py>,
    items: impl Iterator<Item = [f64; N]>,
) -> Bound<'py, PyAny> {
    let all: Vec<_> = items.collect();
    stack(py, &[all.len()], &[N], all.iter().map(|row| &row[..])).into_any()
}

/// A vector of each point, (n, 3).
fn points<'py>(
    py: Python<'py>,
    report: &ContactReport,
    one: fn(&PointState<f64>) -> [f64; 3],
) -> Bound<'py, PyAny> {
    rows(py, report.points.iter().map(one))
}

fn words<T>(items: &[T], one: impl Fn(&T) -> String) -> Vec<String> {
    items.iter().map(one).collect()
}

/// Status, iterations, residual, violations of the solver.
fn certificate(c: &Certificate) -> (String, usize, f64, f64, f64, f64) {
    let status = snake(c.status);
    (
        status,
        c.iterations,
        c.residual,
        c.cone_violation,
        c.complementarity,
        c.dual_violation,
    )
}
