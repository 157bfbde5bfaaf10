//! What a simulator is: inputs, contacts, constraints.

use dualbody::contact::ContactPoint;
use nalgebra::DVector;
use pyo3::prelude::*;

use super::handle::PySimulator;
use crate::arrays::vector;
use crate::contact::point_numbers;
use crate::errors::OrRaise;

#[pymethods]
impl PySimulator {
    /// Number of inputs.
    #[getter]
    pub(super) fn nu(&self) -> usize {
        self.simulator.nu()
    }

    /// Numbers of the state of contact: zero but for contacts with bristles.
    #[getter]
    pub(super) fn n_contact(&self) -> usize {
        self.simulator.n_contact()
    }

    /// Number of tangent directions of the state.
    #[getter]
    pub(super) fn n_tangent(&self) -> usize {
        self.simulator.n_tangent()
    }

    /// Speed beyond which a motion counts as diverged, m/s or rad/s.
    #[getter]
    pub(super) fn divergence_bound(&self) -> f64 {
        self.simulator.divergence_bound()
    }

    /// The velocity coordinate of each joint input.
    #[getter]
    fn actuated(&self) -> Vec<usize> {
        self.simulator.actuated().to_vec()
    }

    /// All parameters of a step, (n,), named by parameter_names: those of the model, then of motors, joint limits, constraints, contact points and
    /// models, ground and forces, and the time step.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, self.simulator.parameters().as_slice().to_vec()).into_any()
    }

    /// Names of the parameters, in the order of `parameters`: "pivot: Coulomb friction", "contact 0 of foot: friction", "time step".
    #[getter]
    fn parameter_names(&self) -> Vec<String> {
        self.simulator.parameter_layout().names().to_vec()
    }

    /// Names of the inputs.
    #[getter]
    fn input_names(&self) -> Vec<String> {
        self.simulator.input_names()
    }

    /// Name of each direction of the tangent space of the state: rows and columns of A.
    #[getter]
    fn tangent_names(&self) -> Vec<String> {
        self.simulator.tangent_names()
    }

    /// Lower and upper bounds of the input by effort limits: (nu,) each, infinite for no limit.
    #[getter]
    fn effort_bounds<'py>(&self, py: Python<'py>) -> (Bound<'py, PyAny>, Bound<'py, PyAny>) {
        let (lower, upper) = self.simulator.effort_bounds();
        (vector(py, lower).into_any(), vector(py, upper).into_any())
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

    /// The state of contact of a robot that touches nothing, (n_contact,).
    pub(super) fn neutral_contact<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        vector(py, vec![0.0; self.simulator.n_contact()]).into_any()
    }

    /// Errors of the constraints in a state, row by row.
    fn constraint_errors<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let given = self.one(q, v, None, None)?;
        let errors = self.with_memory(&given, |memory| {
            self.simulator.constraint_errors(&memory.state)
        })?;
        Ok(vector(q.py(), errors).into_any())
    }

    /// A nearby state that satisfies the constraints: (q, v). Raises a ValueError with the remaining error if none is found.
    fn assemble<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let given = self.one(q, v, None, None)?;
        let state = self
            .with_memory(&given, |memory| self.simulator.assemble(&memory.state))?
            .or_raise()?
            .state;
        let array = |x: &DVector<f64>| vector(q.py(), x.as_slice().to_vec()).into_any();
        Ok((array(&state.q), array(&state.v)))
    }
}
