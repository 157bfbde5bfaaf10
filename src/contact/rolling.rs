//! Where a rolling shape meets curved ground.
//!
//! On a plane the normal is known, and with it the lowest point of a shape. On curved ground each depends on the other: p(n) is the point of
//! the shape that is lowest along the normal n of the ground at its foot y = (f, h(f)), the point of the ground nearest to it, which is where
//!
//! > F(f) = xy(p − y) + ∇h z(p − y) = 0.
//!
//! Newton's method finds f on plain values, lane by lane, with the slope of F by dual numbers. Over a scalar with derivatives, f has them by the
//! implicit function theorem: each step with the slope of F at the solution makes those of one order more exact.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix2, Vector2, Vector3};

use super::point::ContactPoint;
use super::terrain::{Ground, Local, Terrain};
use crate::scalar::{Over, Scalar};
use crate::spatial::Transform;
use crate::spatial::linear::rotate_back;

/// Most steps of Newton's method; three to five are usual.
const STEPS: usize = 16;

/// A step is the last one if it is shorter than this, by the radius and the distance from the origin.
const PRECISION: f64 = 1e-12;

/// The most by which the foot may move with the shape: beyond, the ground is as curved as the shape, and the nearest point not the only one.
const MOST_SENSITIVE: f64 = 1e3;

/// A rolling point over curved ground.
pub(super) struct Rolling<'a, P, T> {
    point: &'a ContactPoint<P>,
    X_WB: &'a Transform<T>,
    radius: T,
    /// Normal of the ground under the centre, in the world.
    above: Vector3<T>,
    /// How far the normal at the foot decides instead, from 0 to 1.
    follows: T,
}

/// The foot of a rolling point.
pub(super) struct Foot<T> {
    /// f, in the world, m.
    pub(super) at: [T; 2],
    /// The ground there.
    pub(super) ground: Ground<T>,
    /// p in the body.
    pub(super) in_body: Vector3<T>,
}

/// What is known of a foot without derivatives.
struct Solution<T> {
    at: [T; 2],
    /// (∂F/∂f)⁻¹, row by row.
    inverse: [T; 4],
    /// 1 where a nearest point was found; 0 where the point is that below the centre, with the ground under it.
    found: T,
}

impl<'a, P: Scalar, T: Over<P>> Rolling<'a, P, T> {
    /// A point of a body with the pose `X_WB`, over ground with a normal under its centre; `None` for a point that does not roll.
    pub(super) fn new(
        point: &'a ContactPoint<P>,
        X_WB: &'a Transform<T>,
        above: Vector3<T>,
    ) -> Option<Self> {
        let radius = point.rolling_radius()?.into();
        let follows = point.follows(&rotate_back(&X_WB.rotation, &above));
        Some(Self {
            point,
            X_WB,
            radius,
            above,
            follows,
        })
    }

    /// The foot on a terrain.
    #[inline(never)]
    pub(super) fn foot(&self, terrain: &Terrain<P>) -> Foot<T> {
        let Solution {
            mut at,
            inverse,
            found,
        } = self.solve(terrain);
        for _ in 0..T::ORDER {
            let miss = self.miss(at, &terrain.surface(&at[0], &at[1]), found);
            at = [0, 1].map(|k| at[k] - inverse[2 * k] * miss[0] - inverse[2 * k + 1] * miss[1]);
        }
        let ground = terrain.surface(&at[0], &at[1]);
        Foot {
            at,
            ground,
            in_body: self.lowest(&ground.normal(), found),
        }
    }

    /// p(n), in the body; for the normal at the foot, or that under the centre where no foot is `found`.
    fn lowest(&self, normal: &Vector3<T>, found: T) -> Vector3<T> {
        let share = self.follows * found;
        let seen = self
            .above
            .zip_map(normal, |above, own| above + (own - above) * share);
        self.point.locate(&rotate_back(&self.X_WB.rotation, &seen))
    }

    /// F where a foot is `found`, else xy(p − y). Where p is farther from the ground than the radius, it counts as that far: F = 0 has one
    /// solution then however high the shape is.
    fn miss(&self, at: [T; 2], ground: &Ground<T>, found: T) -> [T; 2] {
        let p = self.X_WB.point(&self.lowest(&ground.normal(), found));
        let gap = (p.z - ground.height).max(-self.radius).min(self.radius) * found;
        [
            p.x - at[0] + ground.slope[0] * gap,
            p.y - at[1] + ground.slope[1] * gap,
        ]
    }

    fn solve(&self, terrain: &Terrain<P>) -> Solution<T> {
        let (zero, one) = (T::zero(), T::one());
        let below = self.X_WB.point(&self.lowest(&self.above, zero));
        let mut out = Solution {
            at: [below.x, below.y].map(|x| T::from_values(|lane| x.value(lane))),
            inverse: [-one, zero, zero, -one],
            found: zero,
        };
        for lane in 0..T::LANES {
            let start = Vector2::new(below.x.value(lane), below.y.value(lane));
            if let Some((at, inverse)) = self.solve_lane(lane, terrain, start) {
                out.set(lane, at, inverse);
            }
        }
        out
    }

    fn solve_lane(
        &self,
        lane: usize,
        terrain: &Terrain<P>,
        start: Vector2<f64>,
    ) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        let number = |x: T| Local::from(x.value(lane));
        let X_WB = Transform::new(
            self.X_WB.rotation.map(number),
            self.X_WB.translation.map(number),
        );
        let own = Rolling {
            point: &self.point.map(|x| T::from(x).value(lane)),
            X_WB: &X_WB,
            radius: number(self.radius),
            above: self.above.map(number),
            follows: number(self.follows),
        };
        own.descend(start, |at| terrain.around::<T>(lane, at))
    }
}

impl Rolling<'_, f64, Local> {
    /// f and (∂F/∂f)⁻¹ from a start on; `None` where there is no nearest point, or more than one.
    fn descend(
        &self,
        start: Vector2<f64>,
        ground: impl Fn([f64; 2]) -> Ground<Local>,
    ) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        let (mut at, radius) = (start, self.radius.re);
        for _ in 0..STEPS {
            let here = [Local::variable(at.x, 0), Local::variable(at.y, 1)];
            let [x, y] = self.miss(here, &ground([at.x, at.y]), Local::from(1.0));
            let slope = Matrix2::new(x.eps[0], x.eps[1], y.eps[0], y.eps[1]);
            let inverse = slope.try_inverse()?;
            let step = -(inverse * Vector2::new(x.re, y.re));
            let length = step.norm();
            if !length.is_finite() {
                return None;
            }
            at += step * (radius / length).min(1.0);
            if length <= PRECISION * (radius + at.norm()) {
                let is_nearest = slope.trace() < 0.0 && slope.determinant() > 0.0;
                return (is_nearest && inverse.norm() < MOST_SENSITIVE).then_some((at, inverse));
            }
        }
        None
    }
}

impl<T: Scalar> Solution<T> {
    fn set(&mut self, lane: usize, at: Vector2<f64>, inverse: Matrix2<f64>) {
        let put = |out: &mut T, x: f64| {
            *out = T::from_values(|other| if other == lane { x } else { out.value(other) });
        };
        for k in 0..2 {
            put(&mut self.at[k], at[k]);
            put(&mut self.inverse[2 * k], inverse[(k, 0)]);
            put(&mut self.inverse[2 * k + 1], inverse[(k, 1)]);
        }
        put(&mut self.found, 1.0);
    }
}
