//! Contacts over their own numbers, for gradients in those of points, laws and ground.
//!
//! The numbers of a point, of its law and of a plane are few: one evaluation of the point has the derivatives in all of them. Ground that is no plane is computed, at a
//! place, from some of many numbers (of a grid from sixteen weights of splines): the point is evaluated over these, as many at a time as a number has directions. Slopes
//! in the weights are gathered over all points, and taken to the heights at the end, by one pass over the grid.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::point::{DIRECTIONS, LinearizedPoint, Number, PointDual, seeded};
use super::rows::Contact;
use crate::contact::Contacts;
use crate::model::Generation;
use crate::scalar::Scalar;
use crate::sim::moment::Moment;
use crate::sim::parameter_slots::PartSlots;

/// A sum over a point that is weighted, with its derivatives in numbers of contacts.
pub(super) type WeightedSum<'a, T> =
    dyn Fn(&LinearizedPoint<'_, Number<T>, T>) -> PointDual<T> + 'a;

/// A point of contact in a motion.
#[derive(Clone, Copy)]
pub(super) struct PointPlace<'a, T: Scalar> {
    point: &'a LinearizedPoint<'a, f64, T>,
    at: &'a Moment<'a, f64, T>,
    term: &'a Contact<T>,
}

impl<'a, T: Scalar> PointPlace<'a, T> {
    pub(super) fn of(
        point: &'a LinearizedPoint<'a, f64, T>,
        at: &'a Moment<'a, f64, T>,
        term: &'a Contact<T>,
    ) -> Self {
        Self { point, at, term }
    }

    /// The point over the numbers of contacts.
    fn over<'c>(&self, contacts: &'c Contacts<Number<T>>) -> LinearizedPoint<'c, Number<T>, T> {
        let (index, kinematics) = (self.point.index(), &self.term.kinematics);
        let id = Some(contacts.points()[index].body);
        let (X_WB, V_B) = (kinematics.pose(id), kinematics.velocity(id));
        let (simulator, state) = (self.at.simulator, self.at.state);
        LinearizedPoint::over_numbers(contacts, simulator, state, index, &X_WB, &V_B)
    }
}

/// Contacts over their own numbers.
#[derive(Clone, Debug)]
pub(super) struct OverNumbers<T: Scalar> {
    /// Of the contacts that they were made from.
    generation: Generation,
    /// Seeded in the numbers of points, laws and a plane.
    contacts: Contacts<Number<T>>,
    /// `None` where the ground is a plane.
    ground: Option<OverGround<T>>,
}

/// Contacts over the numbers of ground that is no plane.
#[derive(Clone, Debug)]
struct OverGround<T: Scalar> {
    contacts: Contacts<Number<T>>,
    /// Numbers from which the ground at a point is computed.
    indices: Vec<usize>,
    /// Slopes in all numbers of the ground.
    slopes: Vec<T>,
    /// Whether there are any.
    any: bool,
}

impl<T: Scalar> OverNumbers<T> {
    /// Allocates.
    pub(super) fn new(contacts: &Contacts) -> Box<Self> {
        let ground = || OverGround {
            contacts: contacts.cast(),
            indices: Vec::with_capacity(contacts.terrain().n_local_numbers()),
            slopes: vec![T::zero(); contacts.terrain().n_local_numbers()],
            any: false,
        };
        Box::new(Self {
            generation: contacts.generation(),
            contacts: seeded(contacts),
            ground: contacts.terrain().is_curved().then(ground),
        })
    }

    /// Whether they were made from these contacts.
    pub(super) fn are_of(&self, contacts: &Contacts) -> bool {
        self.generation == contacts.generation()
    }

    /// Adds the derivatives of a sum over a point to those in all parameters; those in ground that is no plane when [finished](Self::finish).
    pub(super) fn add(
        &mut self,
        place: &PointPlace<'_, T>,
        sum: &WeightedSum<'_, T>,
        slots: &PartSlots,
        parameters: &mut [T],
    ) {
        let own = sum(&place.over(&self.contacts));
        own.add_numbers(place.point.index(), slots, parameters);
        if let Some(ground) = &mut self.ground {
            ground.add(place, sum);
        }
    }

    /// Adds the derivatives in the ground of all points to those in the parameters.
    pub(super) fn finish(&mut self, slots: &PartSlots, parameters: &mut [T]) {
        let ground = self.ground.as_mut().filter(|ground| ground.any);
        let own = parameters.get_mut(slots.terrain.clone());
        if let Some((ground, own)) = ground.zip(own) {
            let terrain = ground.contacts.terrain();
            terrain.add_local_slopes(&mut ground.slopes, own);
            ground.slopes.fill(T::zero());
            ground.any = false;
        }
    }
}

impl<T: Scalar> OverGround<T> {
    fn add(&mut self, place: &PointPlace<'_, T>, sum: &WeightedSum<'_, T>) {
        self.indices.clear();
        for at in place.point.places() {
            let terrain = self.contacts.terrain();
            terrain.local_numbers(at, &mut self.indices);
        }
        self.any |= !self.indices.is_empty();
        for own in self.indices.chunks(DIRECTIONS) {
            seed(&mut self.contacts, own, T::one());
            let slopes = sum(&place.over(&self.contacts)).slopes();
            for (&index, slope) in own.iter().zip(slopes) {
                self.slopes[index] += slope;
            }
            seed(&mut self.contacts, own, T::zero());
        }
    }
}

/// Sets the derivative of each of some numbers of the ground in itself.
fn seed<T: Scalar>(contacts: &mut Contacts<Number<T>>, indices: &[usize], slope: T) {
    let terrain = contacts.terrain_mut();
    for (direction, &index) in indices.iter().enumerate() {
        terrain.local_number_mut(index).eps[direction] = slope;
    }
}
