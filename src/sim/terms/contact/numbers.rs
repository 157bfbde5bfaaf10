//! Contacts over their own parameters, for gradients in parameters of points, contact models and ground.
//!
//! A point, its contact model and a plane have few parameters: one evaluation of the point has the derivatives in all of them. Other ground depends,
//! at a position, on a few of many parameters (a grid on sixteen spline weights): the point is evaluated over these, several at a time. Derivatives
//! in the weights are summed over all points, and converted to those in the heights at the end, by one pass over the grid.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::point::LinearizedPoint;
use super::rows::Contact;
use super::seeds::{
    add_numbers, add_numbers_beside, add_pair_numbers, add_pair_numbers_beside, seeded,
    seeded_beside,
};
use crate::contact::{Contacts, PairPoint};
use crate::model::{BodyId, Generation};
use crate::scalar::{Cast, MapEach, Scalar};
use crate::sim::terms::local::{BODY_DIRECTIONS, OfBody};
use crate::sim::terms::numbers::{Numbers, WeightedSum};
use crate::sim::terms::sink::DerivativePoint;

/// A contact point over parameters of contacts.
pub(super) type Statement<'a, T> =
    dyn Fn(&LinearizedPoint<'_, OfBody<T>, T>, &mut WeightedSum<'_, T, BODY_DIRECTIONS>) + 'a;

/// A contact point in a motion.
#[derive(Clone, Copy)]
pub(super) struct PointPlace<'a, T: Scalar> {
    pub(super) at: &'a DerivativePoint<'a, T>,
    pub(super) term: &'a Contact<T>,
    pub(super) index: usize,
}

/// A point between bodies in a motion.
#[derive(Clone, Copy)]
pub(super) struct PairPlace<'a, T: Scalar> {
    pub(super) at: &'a DerivativePoint<'a, T>,
    pub(super) term: &'a Contact<T>,
    pub(super) point: &'a PairPoint,
    pub(super) bodies: [Option<BodyId>; 2],
}

impl<T: Scalar> PointPlace<'_, T> {
    /// The weighted results of the point, over parameters of contacts.
    fn weighted(
        &self,
        contacts: &Contacts<OfBody<T>>,
        out: &Numbers<'_, T>,
        state: &Statement<'_, T>,
    ) -> OfBody<T> {
        let (index, kinematics) = (self.index, &self.term.kinematics);
        let on = Some(contacts.points()[index].body);
        let (X_WB, V_B) = (kinematics.pose(on), kinematics.velocity(on));
        let point = self.at.point;
        let point = LinearizedPoint::over_numbers(contacts, point, index, &X_WB, &V_B);
        let mut sum = out.sum(on);
        state(&point, &mut sum);
        sum.value
    }

    /// Places, x and y, at which the ground counts: under the centre, under the point, and where the normal from the point meets the ground.
    fn places(&self, contacts: &Contacts<OfBody<T>>) -> [[f64; 2]; 3] {
        let own = &contacts.points()[self.index];
        let point = &self.term.points[self.index];
        let pose = self.term.kinematics.pose_of(own.body);
        let center = pose.point(&own.center.map(|x| x.re));
        let depth = point.depth - contacts.margin(self.index).re;
        let foot = point.position + point.normal * depth;
        [center, point.position, foot].map_each(|p| [p.x.value(0), p.y.value(0)])
    }
}

impl<T: Scalar> PairPlace<'_, T> {
    /// The weighted results of the point, over parameters of contacts, of the shapes those of one.
    fn weighted(
        &self,
        contacts: &Contacts<OfBody<T>>,
        side: usize,
        out: &Numbers<'_, T>,
        state: &Statement<'_, T>,
    ) -> OfBody<T> {
        let kinematics = &self.term.kinematics;
        let X = self.bodies.map_each(|on| kinematics.pose(on));
        let V = self.bodies.map_each(|on| kinematics.velocity(on));
        let point_of = LinearizedPoint::between_numbers;
        let own = point_of(contacts, self.at.point, self.point, side, &X, &V);
        let mut sum = out.sum_between(self.bodies);
        state(&own, &mut sum);
        sum.value
    }
}

/// Contacts over their own numbers.
#[derive(Clone, Debug)]
pub(super) struct OverNumbers<T: Scalar> {
    /// Of the contacts that they were made from.
    generation: Generation,
    /// Seeded in the numbers of points, laws and a plane.
    contacts: Contacts<OfBody<T>>,
    /// `None` where the ground is a plane.
    ground: Option<OverGround<T>>,
    /// Seeded in torsional and rolling friction, in margins of points and in compliance of materials; `None` without.
    beside: Option<Contacts<OfBody<T>>>,
}

/// Contacts over the numbers of ground that is not a plane.
#[derive(Clone, Debug)]
struct OverGround<T: Scalar> {
    contacts: Contacts<OfBody<T>>,
    /// Numbers from which the ground at a point is computed.
    indices: Vec<usize>,
    /// Derivatives in all parameters of the ground.
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
        let has_margin = contacts.counts_beside_law()[1] > 0;
        let has_more = contacts.have_turning() || has_margin || contacts.have_compliance();
        Box::new(Self {
            generation: contacts.generation(),
            contacts: seeded(contacts),
            ground: contacts.terrain().is_curved().then(ground),
            beside: has_more.then(|| seeded_beside(contacts)),
        })
    }

    /// Whether they were made from these contacts.
    pub(super) fn are_of(&self, contacts: &Contacts) -> bool {
        self.generation == contacts.generation()
    }

    /// Adds the derivatives of a point to those in all parameters; those in ground that is not a plane when [finished](Self::finish).
    pub(super) fn add(
        &mut self,
        place: &PointPlace<'_, T>,
        out: &mut Numbers<'_, T>,
        state: &Statement<'_, T>,
    ) {
        let sum = place.weighted(&self.contacts, out, state);
        add_numbers(&sum, place.index, out);
        if let Some(ground) = &mut self.ground {
            ground.add(place, out, state);
        }
        let matters = |own: &&Contacts<OfBody<T>>| {
            own.turning(place.index).is_some() || own.counts_beside_law()[1] > 0
        };
        if let Some(contacts) = self.beside.as_ref().filter(matters) {
            let sum = place.weighted(contacts, out, state);
            add_numbers_beside(&sum, contacts, place.index, out);
        }
    }

    /// Adds the derivatives of a point between bodies to those in its contact model, in the sizes of both shapes and in their materials.
    pub(super) fn add_pair(
        &mut self,
        place: &PairPlace<'_, T>,
        out: &mut Numbers<'_, T>,
        state: &Statement<'_, T>,
    ) {
        let shapes = place.point.shapes;
        let beside = self
            .beside
            .as_ref()
            .filter(|own| own.turning_between(shapes).is_some() || own.yield_by_material(shapes));
        for side in [0, 1] {
            let sum = place.weighted(&self.contacts, side, out, state);
            add_pair_numbers(&sum, &self.contacts, (shapes, side), out);
            if let Some(contacts) = beside {
                let sum = place.weighted(contacts, side, out, state);
                add_pair_numbers_beside(&sum, contacts, (shapes, side), out);
            }
        }
    }

    /// Adds the derivatives in the ground of all points to those in the parameters.
    pub(super) fn finish(&mut self, out: &mut Numbers<'_, T>) {
        let slots = out.slots().0.terrain.clone();
        let ground = self.ground.as_mut().filter(|ground| ground.any);
        if let Some((ground, own)) = ground.zip(out.parameters(&slots)) {
            let terrain = ground.contacts.terrain();
            terrain.add_local_slopes(&mut ground.slopes, own);
            ground.slopes.fill(T::zero());
            ground.any = false;
        }
    }
}

impl<T: Scalar> OverGround<T> {
    fn add(&mut self, place: &PointPlace<'_, T>, out: &Numbers<'_, T>, state: &Statement<'_, T>) {
        self.indices.clear();
        for at in place.places(&self.contacts) {
            let terrain = self.contacts.terrain();
            terrain.local_numbers(at, &mut self.indices);
        }
        self.any |= !self.indices.is_empty();
        for own in self.indices.chunks(BODY_DIRECTIONS) {
            seed(&mut self.contacts, own, T::one());
            let slopes = place.weighted(&self.contacts, out, state).eps;
            for (&index, slope) in own.iter().zip(slopes) {
                self.slopes[index] += slope;
            }
            seed(&mut self.contacts, own, T::zero());
        }
    }
}

/// Sets the derivative of some ground parameters with respect to themselves.
fn seed<T: Scalar>(contacts: &mut Contacts<OfBody<T>>, indices: &[usize], slope: T) {
    let terrain = contacts.terrain_mut();
    for (direction, &index) in indices.iter().enumerate() {
        terrain.local_number_mut(index).eps[direction] = slope;
    }
}
