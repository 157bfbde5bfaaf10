//! Configurations: moves, differences, random ones.

use pyo3::prelude::*;
use rand::SeedableRng;

use super::handle::PyModel;
use crate::arrays::{Array, vector};
use crate::counts::whole;
use crate::errors::guarded;

#[pymethods]
impl PyModel {
    /// Neutral configuration (nq,).
    pub(super) fn neutral<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, self.model.neutral().as_slice().to_vec()).into_any()
    }

    /// Configuration q moved by the tangent vector dv, a velocity times a time: (..., nq). q (..., nq), dv (..., nv).
    ///
    /// Not q + dv where there are quaternions: dv has turns in the body's axes, rad, and moves of a floating base along them, m.
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

    /// Tangent vector that leads from q0 to q1, in the axes of the bodies at q0: (..., nv). q0 and q1 (..., nq). The shorter way about a turn.
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
    fn random_configuration<'py>(&self, seed: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (py, seed) = (seed.py(), whole("seed", seed)?);
        let mut rng = rand::rngs::Xoshiro256PlusPlus::seed_from_u64(seed);
        let q = self.model.random_configuration(&mut rng);
        Ok(vector(py, q.as_slice().to_vec()).into_any())
    }

    /// Random velocity of at most a speed in each coordinate, (nv,), the same for the same seed.
    #[pyo3(signature = (seed, speed=1.0))]
    fn random_velocity<'py>(
        &self,
        seed: &Bound<'py, PyAny>,
        speed: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, seed) = (seed.py(), whole("seed", seed)?);
        let mut rng = rand::rngs::Xoshiro256PlusPlus::seed_from_u64(seed);
        let v = guarded(|| self.model.random_velocity(&mut rng, speed))?;
        Ok(vector(py, v.as_slice().to_vec()).into_any())
    }
}
