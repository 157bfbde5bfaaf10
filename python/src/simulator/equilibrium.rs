//! Poses that can be held, and regulators about them.

use dualbody::control::{Equilibrium, EquilibriumStatus};

use crate::prelude::*;

methods! { PySimulator {
    /// Equilibrium near a guess: (q, contact, u, acceleration, iterations, status, found).
    fn _equilibrium(&self, q, u = None, contact = None) -> PyResult<Bound<'py, PyTuple>> {
        let py = q.py();
        let rest = vector(py, &vec![0.0; self.simulator.model().nv()]);
        let given = self.one(q, &rest, u, contact)?;
        let (state, u) =
            self.with_memory(&given, |memory| (memory.state.clone(), memory.u.to_vec()))?;
        let found = on_pool_stopped(py, || Equilibrium::find(&self.simulator, &state, &u))?;
        let numbers = |x: &DVector<f64>| vector(py, x.as_slice());
        (
            numbers(&found.state.q),
            numbers(&found.state.contact),
            numbers(&found.input),
            found.acceleration,
            found.iterations,
            found.status.to_string(),
            found.is_found(),
        ).into_pyobject(py)
    }

    /// Regulator about an equilibrium: (gain, eigenvalues of the loop, status, stabilised, bristles, dropped directions, names, eigenvalues).
    fn _equilibrium_lqr(&self, at: [Bound<'py, PyAny>; 3], q, r) -> PyResult<Bound<'py, PyTuple>> {
        let (py, [pose, contact, u]) = (q.py(), at);
        let (n, nu) = (2 * self.simulator.model().nv(), self.simulator.nu());
        let rest = vector(py, &vec![0.0; n / 2]);
        let given = self.one(&pose, &rest, Some(&u), Some(&contact))?;
        let q = read_matrix_of("q", q, (n, n))?;
        let r = read_matrix_of("r", r, (nu, nu))?;
        let at = self.with_memory(&given, |memory| Equilibrium {
            state: memory.state.clone(),
            input: DVector::from_column_slice(&memory.u),
            acceleration: 0.0,
            status: EquilibriumStatus::Found,
            iterations: 0,
        })?;
        let found = py.detach(|| guarded(|| at.lqr(&self.simulator, &q, &r)))?;
        let dropped = &found.dropped;
        (
            matrix(py, &found.gain),
            PyArray1::from_slice(py, &found.lqr.closed_loop_eigenvalues),
            found.lqr.status.to_string(),
            found.is_stabilized(),
            dropped.bristles.clone(),
            matrix(py, &dropped.directions),
            dropped.names.clone(),
            PyArray1::from_slice(py, &dropped.eigenvalues),
        ).into_pyobject(py)
    }
} }
