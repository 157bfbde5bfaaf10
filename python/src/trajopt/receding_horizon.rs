//! Model-predictive control.

use std::sync::{Mutex, MutexGuard, TryLockError};

use dualbody::trajopt::RecedingHorizon;
use pyo3::exceptions::PyRuntimeError;

use super::ddp::{gains, options_of};
use super::problem::{Guess, cost_of, guess_of, problem_of_simulator};
use super::solution::solution;
use crate::prelude::*;

/// Model-predictive controller: solves the problem from where the robot is, a few iterations at each step, and moves the plan along.
#[pyclass(frozen, name = "RecedingHorizon", module = "dualbody.trajopt")]
pub(crate) struct PyRecedingHorizon {
    pub(super) controller: Mutex<RecedingHorizon>,
    raised: Raised,
}

#[pymethods]
impl PyRecedingHorizon {
    /// The plan as a tuple of numbers; see `dualbody.trajopt.plan`.
    fn _solution<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let controller = self.lock()?;
        let (dynamics, found) = (controller.problem().dynamics(), controller.solution());
        solution(py, dynamics, found, gains(py, dynamics, &found.own)?)
    }
}

methods! { PyRecedingHorizon {
    /// problem: a Problem; the keywords are those of Ddp, max_iterations those of each step.
    #[new]
    fn new(py: Python, problem, guess: Option<Guess<'py>> = None, **options) -> PyResult<Self> {
        let raised = Raised::default();
        let problem = problem_of_simulator(problem, &raised)?;
        let none = PyDict::new(py);
        let options = options_of(options.unwrap_or(&none))?;
        let guess = guess_of(&problem, guess)?;
        let controller = guarded(|| RecedingHorizon::from_guess(problem, options, guess))?;
        Ok(Self {
            controller: Mutex::new(controller),
            raised,
        })
    }

    /// Input (nu,) for the state (q, v).
    fn control(&self, q, v, contact = None) -> PyResult<Bound<'py, PyAny>> {
        let mut controller = self.lock()?;
        let dynamics = controller.problem().dynamics();
        let model = dynamics.robot().expect("the model of a simulator");
        let mut x = read_vector("q", q, Some(model.nq()))?;
        x.extend(read_vector("v", v, Some(model.nv()))?);
        if let Some(contact) = contact {
            let n_contact = dynamics.nx() - x.len();
            x.extend(read_vector("contact", contact, Some(n_contact))?);
        }
        if let Some(k) = x.iter().position(|x| !x.is_finite()) {
            refuse!("the state (q, v)[{k}] is {}",
                x[k]);
        }
        // Threads of the solver may call functions of Python.
        let own = &mut *controller;
        let u = (q.py()).detach(|| guarded(|| own.control(&x).to_vec()));
        self.raised.check()?;
        let u = u?;
        Ok(vector(q.py(), &u))
    }

    /// Replaces the costs.
    fn set_costs(&self, stage_cost, final_cost) -> PyResult<()> {
        let mut controller = self.lock()?;
        let dynamics = controller.problem().dynamics();
        let (stage, last) = (
            cost_of(dynamics, stage_cost, &self.raised)?,
            cost_of(dynamics, final_cost, &self.raised)?,
        );
        let problem = controller.problem_mut();
        guarded(|| {
            problem.set_stage_cost(stage);
            problem.set_final_cost(last);
        })
    }
} }

impl PyRecedingHorizon {
    /// Does not wait: who has the controller may wait for the interpreter lock, or be a function of Python that this very call asks.
    fn lock(&self) -> PyResult<MutexGuard<'_, RecedingHorizon>> {
        match self.controller.try_lock() {
            Ok(own) => Ok(own),
            Err(TryLockError::Poisoned(own)) => Ok(own.into_inner()),
            Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err(
                "the controller is in use by another call, which is not finished",
            )),
        }
    }
}
