//! Properties of a simulator: inputs, contacts, constraints.

use dualbody::contact::ContactPoint;

use crate::contact::point_numbers;
use crate::prelude::*;

getters! { PySimulator {
    /// Number of inputs.
    nu: usize = |own| own.simulator.nu();

    /// Numbers of the state beside q and v, which are called `contact`: those of contacts with bristles, then n_activation of activations, then n_sleep
    /// of what sleeps.
    n_contact: usize = |own| own.sizes().3;

    /// Numbers of the activations of inputs, in `contact`.
    n_activation: usize = |own| own.simulator.n_activation();

    /// Numbers of what sleeps: the last ones of `contact`. All zeros: everything is awake.
    n_sleep: usize = |own| own.simulator.n_sleep();

    /// Number of tangent directions of the state.
    n_tangent: usize = |own| own.simulator.n_tangent();

    /// Speed beyond which a motion counts as diverged, m/s or rad/s.
    divergence_bound: f64 = |own| own.simulator.divergence_bound();

    /// The velocity coordinate of each joint input.
    actuated: Vec<usize> = |own| own.simulator.actuated().to_vec();

    /// All parameters of a step, (n,), named by parameter_names: those of the model, then of motors, joint limits, constraints, contact points and
    /// models, ground and forces, and the time step.
    parameters: Bound<'py, PyAny> = |own, py| vector(py, own.simulator.parameters().as_slice());

    /// Names of the parameters, in the order of `parameters`: "pivot: Coulomb friction", "contact 0 of foot: friction", "time step".
    parameter_names: Vec<String> = |own| own.simulator.parameter_layout().names().to_vec();

    /// Names of the inputs.
    input_names: Vec<String> = |own| own.simulator.input_names();

    /// Name of each direction of the tangent space of the state: rows and columns of A.
    tangent_names: Vec<String> = |own| own.simulator.tangent_names();
} }

#[pymethods]
impl PySimulator {
    /// Lower and upper bounds of the input by effort limits: (nu,) each, infinite for no limit.
    #[getter]
    fn effort_bounds<'py>(&self, py: Python<'py>) -> (Bound<'py, PyAny>, Bound<'py, PyAny>) {
        let (lower, upper) = self.simulator.effort_bounds();
        (vector(py, &lower), vector(py, &upper))
    }

    /// The contact points: [(link, centre in the frame of the link (3,), kind)].
    #[getter]
    fn contact_points(&self) -> Vec<(String, [f64; 3], String)> {
        let model = self.simulator.model();
        let points = self
            .simulator
            .contacts()
            .map_or(&[][..], |contacts| contacts.points());
        let one = |point: &ContactPoint| {
            let (link, _, _, kind, _) = point_numbers(point);
            let center = point.center_in_link(model);
            (model.frames()[link].name.clone(), center.into(), kind)
        };
        points.iter().map(one).collect()
    }

    /// Collision shapes without contact points: [(link, reason)].
    #[getter]
    fn shapes_without_points(&self) -> Vec<(String, String)> {
        let shapes = self
            .simulator
            .contacts()
            .map_or(&[][..], |c| c.shapes_without_points());
        shapes
            .iter()
            .map(|shape| (shape.link.clone(), shape.reason.clone()))
            .collect()
    }

    /// The state of contact of a robot that touches nothing and is awake, and activations of 0, (n_contact,).
    pub(super) fn neutral_contact<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, &vec![0.0; self.n_contact()])
    }
}

methods! { PySimulator {
    /// Names of the links that sleep in a state of which `contact` says what sleeps; a state without `contact` is awake.
    fn asleep(&self, q, v, contact = None) -> PyResult<Vec<String>> {
        let given = self.one(q, v, None, contact)?;
        let names = self.with_memory(&given, |memory| {
            let names = self.simulator.asleep(&memory.state).into_iter();
            names.map(String::from).collect::<Vec<_>>()
        })?;
        Ok(names)
    }

    /// Errors of the constraints in a state, row by row.
    fn constraint_errors(&self, q, v) -> PyResult<Bound<'py, PyAny>> {
        let given = self.one(q, v, None, None)?;
        let errors = self.with_memory(&given, |memory| {
            self.simulator.constraint_errors(&memory.state)
        })?;
        Ok(vector(q.py(), &errors))
    }

    /// A nearby state that satisfies the constraints: (q, v). Raises a ValueError with the remaining error if none is found.
    fn assemble(&self, q, v) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let given = self.one(q, v, None, None)?;
        let state = self.with_memory(&given, |memory| self.simulator.assemble(&memory.state))?.or_raise()?.state;
        let array = |x: &DVector<f64>| vector(q.py(), x.as_slice());
        Ok((array(&state.q), array(&state.v)))
    }
} }
