//! Kinematics of the points of contact, of one state and of batches.

use dualbody_python_table::Robot;
use dualbody_python_table::prelude::*;
use numpy::PyArrayDyn;

use crate::dynamics::table::{Entry, entries_of};
use crate::prelude::*;

dualbody_python_table::simulator_functions!(entries_of);

#[pymethods]
impl PySimulator {
    /// Poses of the frames of all contact points, (..., n, 4, 4): the origin at the point, the axes of its link. q (..., nq).
    fn contact_frames<'py>(&self, q: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        self.call_entry(&entries::contact_frames, &[q], &[])
    }
}

methods! { PySimulator {
    /// Positions, velocities, normals and depths of all points of contact in one array, (..., n, 10).
    fn _contact_points(&self, q, v) -> PyResult<Array<'py>> {
        self.call_entry(&entries::_contact_points, &[q, v], &[])
    }

    /// Jacobians of the frames of all contact points, (..., n, 6, nv). q (..., nq).
    ///
    /// In the mixed representation the first three rows give the velocity of the body at the point, in world axes. A frame is fixed to its body.
    fn contact_jacobians(&self, q, representation: &str = "mixed") -> PyResult<Array<'py>> {
        self.call_entry(&entries::contact_jacobians, &[q], &[representation])
    }

    /// Rates of the Jacobians of the frames of all contact points along v, (..., n, 6, nv). q (..., nq), v (..., nv).
    fn contact_jacobian_derivatives(&self, q, v, representation: &str = "mixed") -> PyResult<Array<'py>> {
        self.call_entry(&entries::contact_jacobian_derivatives, &[q, v], &[representation])
    }

    /// Whether a point of each link is below the ground, in the order of ``model.link_names``, (..., n_links) of bool. q (..., nq).
    fn links_in_contact(&self, q) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        self.check_contacts()?;
        let (simulator, model) = (&*self.simulator, self.simulator.model());
        let (nq, tail) = ([model.nq()], [model.links().len()]);
        let flags = map_plain((model, self.id()), &[argument("q", q, &nq)], &tail, &|x, out| {
            let flags = contacts(simulator).links_in_contact(model, x[0]);
            out.iter_mut().zip(flags).for_each(|(out, flag)| *out = f64::from(u8::from(flag)));
        })?;
        let shape = flags.shape().to_vec();
        let flags: Vec<bool> = numbers_mut(&flags).iter().map(|&x| x > 0.0).collect();
        PyArray1::from_vec(q.py(), flags).reshape(shape)
    }
} }

impl PySimulator {
    fn check_contacts(&self) -> PyResult<()> {
        let has_contacts = self.simulator.contacts().is_some();
        ensure!(has_contacts, "the simulator has no contacts");
        Ok(())
    }

    fn call_entry<'py>(
        &self,
        entry: &Entry,
        vectors: &[&Bound<'py, PyAny>],
        names: &[&str],
    ) -> PyResult<Array<'py>> {
        self.check_contacts()?;
        let robot = (Robot::Simulator(&self.simulator), self.id());
        entry.call(robot, (vectors, None), names, None)
    }
}
