//! Forces from which the next solution starts.

use super::places::last_forces;
use super::rows::Contact;
use super::touching::Touching;
use crate::contact::{Contacts, ROWS};
use crate::nested::IntoNested;
use crate::scalar::{Scalar, from_each};
use crate::sim::balance::Balance;
use crate::sim::island::Start;

impl<T: Scalar> Contact<T> {
    /// Lets each step start from the forces of the last one.
    pub(crate) fn keep_for_next_step(&mut self) {
        self.kept.stay = true;
    }

    /// Keeps the forces of the last solution.
    pub(super) fn keep_forces<P: Scalar>(&mut self, contacts: &Contacts<P>, balance: &Balance<T>) {
        let touching = Touching {
            contacts,
            pairs: &self.pairs,
            points: &self.points,
            kinematics: &self.kinematics,
        };
        let points = self.working.active().iter().enumerate();
        let forces = points.map(|(of, &i)| {
            let own = last_forces(&self.places, balance, of);
            (touching.key(i), from_each(|k| own[k]))
        });
        self.kept.keep(forces);
    }

    /// Lets points take part that had a force in the last solution.
    pub(super) fn add_kept<P: Scalar>(&mut self, contacts: &Contacts<P>) {
        let touching = Touching {
            contacts,
            pairs: &self.pairs,
            points: &self.points,
            kinematics: &self.kinematics,
        };
        self.working.add(|i| {
            let force = self.kept.find(touching.key(i));
            force.is_some_and(|f| !f[0].is_zero())
        });
    }

    /// Lets the next solution start from the forces that are kept: within an instant from those along normals alone, since redundant ones across them would stay.
    pub(super) fn start_from_kept<P: Scalar>(
        &self,
        contacts: &Contacts<P>,
        balance: &mut Balance<T>,
    ) {
        let stay = self.kept.stay;
        let touching = self.touching_in(contacts);
        let points = self.working.active().iter().enumerate();
        let (start, first, zero) = (Start::of(stay), self.first, T::zero());
        let forces = points.nested(|(of, &i)| {
            let kept = self.kept.find(touching.key(i)).unwrap_or([zero; ROWS]);
            let start = match (stay, kept) {
                (true, kept) => kept,
                (false, [along, ..]) => [along, zero, zero],
            };
            let moments = self.places.moments(of);
            start.into_iter().chain(std::iter::repeat_n(zero, moments))
        });
        balance.rows.start_from(start, first, forces);
    }
}
