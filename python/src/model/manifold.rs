//! Configurations: moves, differences, random ones.

use rand::SeedableRng;

use crate::prelude::*;

#[pymethods]
impl PyModel {
    /// Neutral configuration (nq,).
    pub(super) fn neutral<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, self.model.neutral().as_slice())
    }

    /// Random configuration within the limits, (nq,); equal seeds give equal results.
    fn random_configuration<'py>(&self, seed: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (py, seed) = (seed.py(), whole("seed", seed)?);
        let mut rng = rand::rngs::Xoshiro256PlusPlus::seed_from_u64(seed);
        let q = self.model.random_configuration(&mut rng);
        Ok(vector(py, q.as_slice()))
    }
}

methods! { PyModel {
    /// Configuration on the path from q0 (t = 0) to q1 (t = 1): (..., nq).
    fn interpolate(&self, q0, q1, t: f64) -> PyResult<Array<'py>> {
        let m = &self.model;
        let arguments = [("q0", q0, m.nq()), ("q1", q1, m.nq())];
        self.map(q0.py(), &arguments, &[m.nq()], &|x, out| {
            out.copy_from_slice(m.interpolate(x[0], x[1], t).as_slice());
        })
    }

    /// Random velocity of at most a speed in each coordinate, (nv,); equal seeds give equal results.
    fn random_velocity(&self, seed, speed: f64 = 1.0) -> PyResult<Bound<'py, PyAny>> {
        let (py, seed) = (seed.py(), whole("seed", seed)?);
        let mut rng = rand::rngs::Xoshiro256PlusPlus::seed_from_u64(seed);
        let v = guarded(|| self.model.random_velocity(&mut rng, speed))?;
        Ok(vector(py, v.as_slice()))
    }
} }
