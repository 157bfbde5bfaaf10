//! Bodies that sleep take no part in contact.

use super::rows::Contact;
use crate::contact::{Contacts, PointState};
use crate::scalar::Scalar;

impl<T: Scalar> Contact<T> {
    /// Leaves out the contacts of sleeping bodies from now on.
    ///
    /// * `asleep` – whether each body sleeps; empty where none does
    pub(crate) fn leave_out(&mut self, asleep: &[bool]) {
        self.asleep.clear();
        self.asleep.extend_from_slice(asleep);
    }

    /// Leaves out the same contacts as another one.
    pub(crate) fn leave_out_as(&mut self, other: &Self) {
        self.leave_out(&other.asleep);
    }

    /// Moves the points with the ground of sleeping bodies out of its reach.
    pub(super) fn hide_sleeping<P: Scalar>(&mut self, contacts: &Contacts<P>) {
        if self.asleep.is_empty() {
            return;
        }
        for (point, own) in self.points.iter_mut().zip(contacts.points()) {
            if self.asleep[own.body.0] {
                point.depth = T::constant(f64::NEG_INFINITY);
            }
        }
    }

    /// Passes the shapes of each point between bodies, and the point, to `each`.
    pub(crate) fn each_pair<P: Scalar>(
        &self,
        contacts: &Contacts<P>,
        mut each: impl FnMut([usize; 2], &PointState<T>),
    ) {
        for (pair, index) in self.pair_points(contacts) {
            each(pair.shapes, &self.points[index]);
        }
    }
}
