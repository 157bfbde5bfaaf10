//! Configurations: moves, differences, random ones.

use num_dual::Dual64;
use pyo3::prelude::*;
use rand::SeedableRng;

use super::handle::PyModel;
use crate::arrays::{Array, Work, argument, map_rows, vector};
use crate::errors::guarded;

/// Derivative of a configuration in tangent directions, (..., nq, nv): of integrate(q, dv) in dv at zero.
#[pyfunction]
pub(crate) fn _integrate_jacobian<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
) -> PyResult<Array<'py>> {
    let this = model.get();
    let (m, nq, nv) = (&*this.model, [this.model.nq()], this.model.nv());
    let one = |x: &[&[f64]], out: &mut [f64]| {
        let q: Vec<Dual64> = x[0].iter().map(|&x| x.into()).collect();
        for j in 0..nv {
            let mut dv = vec![Dual64::from(0.0); nv];
            dv[j].eps = 1.0;
            for (i, x) in m.integrate(&q, &dv).iter().enumerate() {
                out[i * nv + j] = x.eps;
            }
        }
    };
    let work = Work {
        one: &|_, x, out| one(x, out),
        wide: None,
    };
    let arguments = [argument("q", q, &nq)];
    map_rows(
        model.py(),
        (m, this.id),
        &arguments,
        &[nq[0], nv],
        None,
        work,
    )
}

/// Tangent vector of a change of a configuration's coordinates, (..., nv, nq): the derivative of difference(q, q1) in q1 at q.
#[pyfunction]
pub(crate) fn _difference_jacobian<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
) -> PyResult<Array<'py>> {
    let this = model.get();
    let (m, nq, nv) = (&*this.model, [this.model.nq()], this.model.nv());
    let one = |x: &[&[f64]], out: &mut [f64]| {
        let q: Vec<Dual64> = x[0].iter().map(|&x| x.into()).collect();
        for j in 0..nq[0] {
            let mut moved = q.clone();
            moved[j].eps = 1.0;
            for (i, x) in m.difference(&q, &moved).iter().enumerate() {
                out[i * nq[0] + j] = x.eps;
            }
        }
    };
    let work = Work {
        one: &|_, x, out| one(x, out),
        wide: None,
    };
    let arguments = [argument("q", q, &nq)];
    map_rows(
        model.py(),
        (m, this.id),
        &arguments,
        &[nv, nq[0]],
        None,
        work,
    )
}

#[pymethods]
impl PyModel {
    /// Neutral configuration (nq,).
    pub(super) fn neutral<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, self.model.neutral().as_slice().to_vec()).into_any()
    }

    /// Configuration q moved by the tangent vector dv: (..., nq). q (..., nq), dv (..., nv).
    fn integrate<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        dv: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        let m = &self.model;
        let arguments = [("q", q, m.nq()), ("dv", dv, m.nv())];
        self.map(q.py(), &arguments, m.nq(), &|x, out| {
            m.integrate_into(x[0], x[1], out)
        })
    }

    /// Tangent vector that leads from q0 to q1: (..., nv). q0 and q1 (..., nq).
    fn difference<'py>(
        &self,
        q0: &Bound<'py, PyAny>,
        q1: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        let m = &self.model;
        let arguments = [("q0", q0, m.nq()), ("q1", q1, m.nq())];
        self.map(q0.py(), &arguments, m.nv(), &|x, out| {
            m.difference_into(x[0], x[1], out)
        })
    }

    /// Configuration on the way from q0 (t = 0) to q1 (t = 1): (..., nq).
    fn interpolate<'py>(
        &self,
        q0: &Bound<'py, PyAny>,
        q1: &Bound<'py, PyAny>,
        t: f64,
    ) -> PyResult<Array<'py>> {
        let m = &self.model;
        let arguments = [("q0", q0, m.nq()), ("q1", q1, m.nq())];
        self.map(q0.py(), &arguments, m.nq(), &|x, out| {
            out.copy_from_slice(m.interpolate(x[0], x[1], t).as_slice());
        })
    }

    /// Random configuration within the limits, (nq,), the same for the same seed.
    fn random_configuration<'py>(&self, py: Python<'py>, seed: u64) -> Bound<'py, PyAny> {
        let mut rng = rand::rngs::Xoshiro256PlusPlus::seed_from_u64(seed);
        let q = self.model.random_configuration(&mut rng);
        vector(py, q.as_slice().to_vec()).into_any()
    }

    /// Random velocity of at most a speed in each coordinate, (nv,), the same for the same seed.
    #[pyo3(signature = (seed, speed=1.0))]
    fn random_velocity<'py>(
        &self,
        py: Python<'py>,
        seed: u64,
        speed: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut rng = rand::rngs::Xoshiro256PlusPlus::seed_from_u64(seed);
        let v = guarded(|| self.model.random_velocity(&mut rng, speed))?;
        Ok(vector(py, v.as_slice().to_vec()).into_any())
    }
}
