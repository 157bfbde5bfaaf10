//! Linear-quadratic regulators, computed torque, poses that can be held.

use dualbody::control::{
    ComputedTorque, Equilibrium, EquilibriumStatus, FiniteHorizonLqr, Lqr, LqrStage, LqrStatus,
};

use crate::prelude::*;

functions! {
    /// Solves a regulator's problem over an infinite horizon: (gain, cost to go, eigenvalues, residual, iterations, status, stabilised).
    fn _lqr(py: Python, discrete: bool, a, b, q, r) -> PyResult<Bound<'py, PyTuple>> {
        let (a, b) = (read_matrix("a", a)?, read_matrix("b", b)?);
        let (nx, nu) = (a.nrows(), b.ncols());
        check_size("a", a.shape(), (nx, nx))?;
        check_size("b", b.shape(), (nx, nu))?;
        let q = read_matrix_of("q", q, (nx, nx))?;
        let r = read_matrix_of("r", r, (nu, nu))?;
        let lqr = py.detach(|| {
            guarded(|| match discrete {
                true => Lqr::discrete(&a, &b, &q, &r),
                false => Lqr::continuous(&a, &b, &q, &r),
            })
        })?;
        let eigenvalues = PyArray1::from_slice(py, &lqr.closed_loop_eigenvalues);
        let stabilized = lqr.status == LqrStatus::Stabilized;
        let (gain, cost) = (matrix(py, &lqr.gain), matrix(py, &lqr.cost_to_go));
        let status = lqr.status.to_string();
        (gain, cost, eigenvalues, lqr.residual, lqr.iterations, status, stabilized).into_pyobject(py)
    }
}

fn check_size(name: &str, given: (usize, usize), expected: (usize, usize)) -> PyResult<()> {
    match given == expected {
        true => Ok(()),
        false => Err(shape_error(name, given, format_args!("{expected:?}"))),
    }
}

functions! {
    /// Solves a regulator's problem over stages: (gains, costs to go, status, solved).
    fn _finite_horizon_lqr(py: Python, a, b, q, r, final_cost) -> PyResult<Bound<'py, PyTuple>> {
        let last = read_matrix("final_cost", final_cost)?;
        let (nx, stages) = (last.nrows(), numbers("a", a)?.shape().first().copied().unwrap_or(0));
        let nu = numbers("b", b)?.shape().last().copied().unwrap_or(0);
        check_size("final_cost", last.shape(), (nx, nx))?;
        let all = |name, value: &Bound<'py, PyAny>, rows: usize, columns: usize| {
            let array = numbers(name, value)?;
            if array.shape() != [stages, rows, columns] {
                let expected = format_args!("({stages}, {rows}, {columns})");
                return Err(shape_error(name, array.shape(), expected));
            }
            // SAFETY: the array is in C order, and its numbers are copied at once.
            let x = unsafe { array.as_slice().unwrap_or(&[]) };
            let chunks = x.chunks((rows * columns).max(1));
            Ok(chunks.map(|x| DMatrix::from_row_slice(rows, columns, x)).collect::<Vec<_>>())
        };
        let (a, b) = (all("a", a, nx, nx)?, all("b", b, nx, nu)?);
        let (q, r) = (all("q", q, nx, nx)?, all("r", r, nu, nu)?);
        let stages = a.into_iter().zip(b).zip(q.into_iter().zip(r));
        let stages: Vec<LqrStage> = stages.map(|((a, b), (q, r))| LqrStage { a, b, q, r }).collect();
        let lqr = py.detach(|| guarded(|| FiniteHorizonLqr::discrete(&stages, &last)))?;
        let gains = matrices(py, &[lqr.gains.len()], [nu, nx], lqr.gains.iter())?;
        let costs = matrices(py, &[lqr.costs_to_go.len()], [nx, nx], lqr.costs_to_go.iter())?;
        (gains, costs, lqr.status.to_string(), lqr.is_solved()).into_pyobject(py)
    }

    /// Torque that makes the errors obey ë + k_d ė + k_p e = 0, of states (..., nq), (..., nv).
    fn _computed_torque(model: &Bound<'py, PyModel>, gains: (Bound<'py, PyAny>, Bound<'py, PyAny>), q, v, target_q, target_v) -> PyResult<Array<'py>> {
        let this = model.get();
        let m = &*this.model;
        let (nq, nv) = ([m.nq()], [m.nv()]);
        let gain = |name, value| read_vector(name, value, Some(m.nv())).map(DVector::from_vec);
        let controller = ComputedTorque {
            position_gain: gain("position_gain", &gains.0)?,
            velocity_gain: gain("velocity_gain", &gains.1)?,
        };
        let target = [argument("target_q", target_q, &nq), argument("target_v", target_v, &nv)];
        this.map(&[argument("q", q, &nq), argument("v", v, &nv), target[0], target[1]], &nv, &|x, out| {
            let (state, target) = (State::new(x[0], x[1]), State::new(x[2], x[3]));
            out.copy_from_slice(controller.torque(m, &state, &target).as_slice());
        })
    }
}

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
