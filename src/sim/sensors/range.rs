//! The reading of a range finder: the distance along a ray to shapes and terrain.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::ray::{LocalRay, PARALLEL, Shape};
use crate::contact::{Contacts, Terrain};
use crate::scalar::{Over, Scalar};
use crate::spatial::Transform;
use crate::spatial::linear::{rotate_back, scale};

/// Places along a ray at which the height above curved terrain is compared: what is narrower than this share of the range may be missed.
const PLACES: u32 = 128;

/// Halvings of the interval in which the ray passes the terrain, to 2⁻⁴⁰ of it.
const HALVINGS: u32 = 40;

/// Steps of Newton's method over the scalar after these: each gives one more order of derivatives.
const NEWTON_STEPS: u32 = 3;

/// A ray in the world.
pub(super) struct Ray<T> {
    pub(super) origin: Vector3<T>,
    /// A unit vector.
    pub(super) direction: Vector3<T>,
    /// The largest distance, m.
    pub(super) range: f64,
}

impl<T: Scalar> Ray<T> {
    /// The distance to the nearest surface, at most the range.
    ///
    /// * `shapes` – with the pose of the body of each
    /// * `contacts` – with terrain and surfaces
    pub(super) fn distance<'s, P: Scalar>(
        &self,
        shapes: impl Iterator<Item = (&'s Shape, Transform<T>)>,
        contacts: Option<&Contacts<P>>,
    ) -> T
    where
        T: Over<P>,
    {
        let mut nearest = T::constant(self.range);
        for (shape, X_WB) in shapes {
            let X_BS = Transform::new(
                shape.placement.rotation.map(T::constant),
                shape.placement.translation.map(T::constant),
            );
            let X_WS = X_WB * X_BS;
            let local = LocalRay {
                origin: X_WS.inverse().point(&self.origin),
                direction: rotate_back(&X_WS.rotation, &self.direction),
                nearest,
            };
            nearest = local.hit(&shape.solid);
        }
        let Some(contacts) = contacts else {
            return nearest;
        };
        if let Some(surfaces) = contacts.surface_triangles() {
            let in_world = LocalRay {
                origin: self.origin,
                direction: self.direction,
                nearest,
            };
            nearest = in_world.with_triangles(surfaces.tree, |k| surfaces.corners(k));
        }
        self.to_ground(contacts.terrain(), nearest)
    }

    /// The distance to the terrain, if it is nearer than what has been found; zero below it.
    fn to_ground<P: Scalar>(&self, terrain: &Terrain<P>, nearest: T) -> T
    where
        T: Over<P>,
    {
        let zero = T::zero();
        let (mut t, missed) = match terrain {
            Terrain::Plane(_) => (zero, zero),
            _ => self.crossing(terrain),
        };
        for _ in 0..NEWTON_STEPS {
            let [h, slope] = self.above(terrain, t);
            let least = T::constant(-PARALLEL);
            t -= h / slope.min(least);
        }
        let ahead = t.select_lt(zero, nearest, t.min(nearest));
        let ahead = zero.select_lt(missed, nearest, ahead);
        let [start, _] = self.above(terrain, zero);
        start.select_lt(zero, zero, ahead)
    }

    /// The first place within the range at which the ray passes curved terrain, without derivatives, and 1 where it does not.
    fn crossing<P: Scalar>(&self, terrain: &Terrain<P>) -> (T, T)
    where
        T: Over<P>,
    {
        let (zero, one) = (T::zero(), T::one());
        let height = |t: T| self.above(terrain, t)[0].detached();
        let (mut above, mut below, mut missed) = (zero, T::constant(self.range), one);
        for k in 1..=PLACES {
            let t = T::constant(self.range * f64::from(k) / f64::from(PLACES));
            let h = height(t);
            let open = |yes: T, no: T| zero.select_lt(missed, yes, no);
            let (next_above, next_below) = (
                open(h.select_lt(zero, above, t), above),
                open(h.select_lt(zero, t, below), below),
            );
            missed = h.select_lt(zero, zero, missed);
            (above, below) = (next_above, next_below);
        }
        for _ in 0..HALVINGS {
            let middle = (above + below) * 0.5;
            let h = height(middle);
            (above, below) = (
                h.select_lt(zero, above, middle),
                h.select_lt(zero, middle, below),
            );
        }
        ((above + below) * 0.5, missed)
    }

    /// Height of the place at a distance above the terrain, and how it changes along the ray.
    fn above<P: Scalar>(&self, terrain: &Terrain<P>, t: T) -> [T; 2]
    where
        T: Over<P>,
    {
        let (at, d) = (self.origin + scale(&self.direction, t), &self.direction);
        let ground = terrain.surface(&at.x, &at.y);
        let slope = d.z - ground.slope[0] * d.x - ground.slope[1] * d.y;
        [at.z - ground.height, slope]
    }
}
