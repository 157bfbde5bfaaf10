//! All contact points of an instant, with the ground and between bodies: the bodies and the contact model of each.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::kept::Key;
use super::pairs::PairPoints;
use crate::contact::{
    BodyPoint, ContactLaw, Contacts, PairPoint, PointState, ROWS, Turning, body_force,
    each_jacobian_column, each_turning_column,
};
use crate::dynamics::Kinematics;
use crate::model::{BodyId, Model};
use crate::scalar::{MapEach, Over, Scalar};
use crate::spatial::Force;
use crate::spatial::linear::{rotate, rotate_back};

/// The points of an instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touching<'a, P, T> {
    pub(super) contacts: &'a Contacts<P>,
    pub(super) pairs: &'a PairPoints<T>,
    /// Those with the ground, then those between bodies.
    pub(super) points: &'a [PointState<T>],
    pub(super) kinematics: &'a Kinematics<T>,
}

/// Owner of a point, of which a few points are active at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    Link(usize),
    Pair([usize; 2]),
}

impl<'a, P: Scalar, T: Scalar> Touching<'a, P, T> {
    /// Index of a point between bodies; `None` for a point with the ground.
    fn pair(&self, i: usize) -> Option<usize> {
        i.checked_sub(self.contacts.points().len())
    }

    pub(super) fn group(&self, i: usize) -> Group {
        match self.pair(i) {
            None => Group::Link(self.contacts.points()[i].link.0),
            Some(k) => Group::Pair(self.pairs.get(k).shapes),
        }
    }

    /// Identity of a point from solution to solution.
    pub(super) fn key(&self, i: usize) -> Key {
        match self.pair_point(i) {
            None => Key::Ground(i),
            Some(point) => Key::Pair(point.shapes, point.feature.id),
        }
    }

    pub(super) fn law(&self, i: usize) -> ContactLaw<P> {
        match self.pair(i) {
            None => self.contacts.laws()[i],
            Some(k) => self.contacts.pair_law(self.pairs.get(k).shapes),
        }
    }

    /// The bodies that touch at a point; `None` is the ground or the world.
    pub(super) fn bodies(&self, i: usize) -> [Option<BodyId>; 2] {
        match self.pair(i) {
            None => [Some(self.contacts.points()[i].body), None],
            Some(k) => self.contacts.pair_bodies(self.pairs.get(k).shapes),
        }
    }

    /// The point between bodies; `None` for one with the ground.
    pub(super) fn pair_point(&self, i: usize) -> Option<&'a PairPoint> {
        self.pair(i).map(|k| self.pairs.get(k))
    }

    /// Torsional and rolling friction at a point, with the rate of rotation that they brake; `None` without.
    pub(super) fn turning(&self, i: usize) -> Option<Turning<P, T>> {
        let friction = match self.pair_point(i) {
            None => self.contacts.turning(i),
            Some(point) => self.contacts.turning_between(point.shapes),
        }?;
        let [first, second] = self.bodies(i).map_each(|body| {
            let rate = self.kinematics.velocity(body).angular;
            rotate(&self.kinematics.pose(body).rotation, &rate)
        });
        Some(Turning {
            friction,
            rate: first - second,
        })
    }

    /// Whether a point is met before it arrives by a law that else meets overlap only.
    pub(super) fn is_speculative(&self, i: usize) -> bool {
        self.pair(i).is_some() && self.contacts.are_pairs_speculative()
    }

    /// The axes in which laws see a point: normal, tangent, tangent, in the world.
    pub(super) fn axes(&self, i: usize) -> [Vector3<T>; ROWS] {
        match self.pair(i) {
            None => self.points[i].axes(),
            Some(_) => self.points[i].axes_of_any_normal(),
        }
    }
}

impl<P: Scalar, T: Over<P>> Touching<'_, P, T> {
    /// Passes the angular velocity that each coordinate's unit rate gives to the first body at a point, less that of the second, to `each(coordinate, ω)`.
    pub(super) fn each_turning_column(
        &self,
        model: &Model<P>,
        i: usize,
        mut each: impl FnMut(usize, Vector3<T>),
    ) {
        let [first, second] = self.bodies(i);
        each_turning_column(model, self.kinematics, first, &mut each);
        if second.is_some() {
            each_turning_column(model, self.kinematics, second, |k, x| each(k, -x));
        }
    }

    /// Passes the velocity that each coordinate's unit rate gives to a point, in the world's axes, to `each(coordinate, v)`: that of the first body, less that
    /// of the second.
    #[inline(always)]
    pub(super) fn each_jacobian_column(
        &self,
        model: &Model<P>,
        i: usize,
        mut each: impl FnMut(usize, Vector3<T>),
    ) {
        let [first, second] = self.bodies(i);
        let place = BodyPoint {
            body: first,
            in_body: &self.points[i].in_body,
        };
        each_jacobian_column(model, self.kinematics, place, &mut each);
        if let (Some(k), Some(_)) = (self.pair(i), second) {
            let place = BodyPoint {
                body: second,
                in_body: self.pairs.in_second(k),
            };
            each_jacobian_column(model, self.kinematics, place, |k, v| each(k, -v));
        }
    }
}

impl<P: Scalar, T: Scalar> Touching<'_, P, T> {
    /// Unit forces along the axes of a point on each of its bodies, in it: zeros on the ground.
    pub(super) fn unit_forces(&self, i: usize, axes: &[Vector3<T>; ROWS]) -> [[Force<T>; ROWS]; 2] {
        [0, 1].map_each(|side| axes.map_each(|axis| self.force(i, side, &axis)))
    }

    /// Unit moments about the axes of a point on each of its bodies, in it: zeros on the ground.
    pub(super) fn unit_couples(
        &self,
        i: usize,
        axes: &[Vector3<T>; ROWS],
    ) -> [[Force<T>; ROWS]; 2] {
        [0, 1].map_each(|side| axes.map_each(|axis| self.couple(i, side, &axis)))
    }

    /// A moment on the first body at a point, in the world, or its opposite on the second one, as a force on the body, in the body; none on the ground.
    pub(super) fn couple(&self, i: usize, side: usize, moment: &Vector3<T>) -> Force<T> {
        let Some(body) = self.bodies(i)[side] else {
            return Force::zero();
        };
        let own = rotate_back(&self.kinematics.pose_of(body).rotation, moment);
        let own = if side == 0 { own } else { -own };
        Force::new(Vector3::zeros(), own)
    }

    /// A force on the first body at a point, in the world, or its opposite on the second one, as one on the body, in the body; none on the ground.
    pub(super) fn force(&self, i: usize, side: usize, force: &Vector3<T>) -> Force<T> {
        let body = self.bodies(i)[side];
        let R = || self.kinematics.pose(body).rotation;
        let pair = self.pair(i).filter(|_| body.is_some());
        match (side, pair) {
            (0, _) => body_force(&R(), &self.points[i].in_body, force),
            (_, Some(k)) => body_force(&R(), self.pairs.in_second(k), &-force),
            (_, None) => Force::zero(),
        }
    }
}
