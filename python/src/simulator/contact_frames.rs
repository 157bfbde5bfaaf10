//! Kinematics of the points of contact, of one state and of batches.

use dualbody::Model;
use dualbody::contact::{Contacts, PointState};
use dualbody::spatial::Representation;
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::handle::PySimulator;
use crate::arrays::{Array, Work, argument, map_rows, write_matrix};
use crate::dynamics::{Named, write_pose};
use crate::errors::value_error;

/// Numbers of a point: position, velocity, normal, depth.
const POINT: usize = 10;

#[pymethods]
impl PySimulator {
    /// Positions, velocities, normals and depths of all points of contact in one array, (..., n, 10).
    fn _contact_points<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
    ) -> PyResult<Array<'py>> {
        let contacts = self.contacts()?;
        let tail = [contacts.points().len(), POINT];
        self.map_contacts(&[("q", q), ("v", v)], &tail, &|m, x, out| {
            let points = contacts.states(m, x[0], x[1]);
            for (point, out) in points.iter().zip(out.chunks_mut(POINT)) {
                write_point(point, out);
            }
        })
    }

    /// Poses of the frames of all points of contact, (..., n, 4, 4): the origin at the point, the axes of its link. q (..., nq).
    fn contact_frames<'py>(&self, q: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        let contacts = self.contacts()?;
        let tail = [contacts.points().len(), 4, 4];
        self.map_contacts(&[("q", q)], &tail, &|m, x, out| {
            let frames = contacts.frames(m, x[0]);
            for (frame, out) in frames.iter().zip(out.chunks_mut(16)) {
                write_pose(frame, out);
            }
        })
    }

    /// Jacobians of the frames of all points of contact, (..., n, 6, nv). q (..., nq).
    ///
    /// If mixed, the first three rows give the velocity of the body at the point, in axes of the world. A frame is fixed to its body.
    #[pyo3(signature = (q, representation="mixed"))]
    fn contact_jacobians<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        representation: &str,
    ) -> PyResult<Array<'py>> {
        let contacts = self.contacts()?;
        let r = Representation::find(self.simulator.model(), representation)?;
        self.map_contacts(&[("q", q)], &self.jacobian_shape(contacts), &|m, x, out| {
            write_jacobians(&contacts.frame_jacobians(m, x[0], r), out);
        })
    }

    /// Rates of the Jacobians of the frames of all points of contact along v, (..., n, 6, nv). q (..., nq), v (..., nv).
    #[pyo3(signature = (q, v, representation="mixed"))]
    fn contact_jacobian_derivatives<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        representation: &str,
    ) -> PyResult<Array<'py>> {
        let contacts = self.contacts()?;
        let r = Representation::find(self.simulator.model(), representation)?;
        self.map_contacts(
            &[("q", q), ("v", v)],
            &self.jacobian_shape(contacts),
            &|m, x, out| {
                write_jacobians(&contacts.frame_jacobian_derivatives(m, x[0], x[1], r), out);
            },
        )
    }

    /// Whether a point of each link is below the ground, in the order of ``model.link_names``, (..., n_links) of bool. q (..., nq).
    fn links_in_contact<'py>(
        &self,
        q: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        let contacts = self.contacts()?;
        let tail = [self.simulator.model().links().len()];
        let flags = self.map_contacts(&[("q", q)], &tail, &|m, x, out| {
            let flags = contacts.links_in_contact(m, x[0]);
            out.iter_mut()
                .zip(flags)
                .for_each(|(out, flag)| *out = f64::from(u8::from(flag)));
        })?;
        let shape = flags.shape().to_vec();
        let flags: Vec<bool> = crate::arrays::numbers_mut(&flags)
            .iter()
            .map(|&x| x > 0.0)
            .collect();
        numpy::PyArray1::from_vec(q.py(), flags).reshape(shape)
    }
}

impl PySimulator {
    fn contacts(&self) -> PyResult<&Contacts> {
        self.simulator
            .contacts()
            .ok_or_else(|| value_error("the simulator has no contacts"))
    }

    fn jacobian_shape(&self, contacts: &Contacts) -> [usize; 3] {
        [contacts.points().len(), 6, self.simulator.model().nv()]
    }

    /// Applies a function of q, or of q and v, to each row.
    fn map_contacts<'py>(
        &self,
        given: &[(&'static str, &Bound<'py, PyAny>)],
        tail: &[usize],
        one: &(dyn Fn(&Model, &[&[f64]], &mut [f64]) + Sync),
    ) -> PyResult<Array<'py>> {
        let model = self.simulator.model();
        let widths = [[model.nq()], [model.nv()]];
        let arguments: Vec<_> = given
            .iter()
            .zip(&widths)
            .map(|(&(name, value), width)| argument(name, value, width))
            .collect();
        let work = Work {
            one: &|_, x, out| one(model, x, out),
            wide: None,
        };
        let py = given[0].1.py();
        map_rows(py, (model, self.id()), &arguments, tail, None, work)
    }
}

fn write_point(point: &PointState<f64>, out: &mut [f64]) {
    let vectors = [&point.position, &point.velocity, &point.normal];
    for (vector, out) in vectors.into_iter().zip(out.chunks_mut(3)) {
        out.copy_from_slice(vector.as_slice());
    }
    out[POINT - 1] = point.depth;
}

fn write_jacobians(all: &[nalgebra::DMatrix<f64>], out: &mut [f64]) {
    let width = all.first().map_or(1, |one| one.len().max(1));
    for (one, out) in all.iter().zip(out.chunks_mut(width)) {
        write_matrix(one, out);
    }
}
