//! Points at which a rolling shape meets curved ground.
//!
//! On a plane the normal is known, and with it the lowest point of a shape. On curved ground each depends on the other: p(n) is the point of
//! the shape that is lowest along the normal n of the ground at its foot y = (f, h(f)), the point of the ground nearest to it, which is where
//!
//! > F(f) = xy(p − y) + ∇h z(p − y) = 0.
//!
//! Newton's method finds f on plain values, lane by lane, with the slope of F by dual numbers. Over a scalar with derivatives, f has them by the
//! implicit function theorem: each step with the slope of F at the solution makes those of one order more exact. Other parts of a scalar,
//! such as bounds or a graph, come from one such step: to first order about the solution.
//!
//! On an outer edge of the ground, where its slope jumps, the normal is one between those of the two sides: unknown are the place along the
//! edge and the share of the jump.
//!
//! In an inner edge, and in a valley narrower than the shape, there is a foot on each side. That one counts in which the shape is deeper, so that
//! the depth has no jump, only the normal; where contact acts over a step, deeper at its end: else a shape that rolls fast enters the other
//! side without a force, and comes out of it with energy from nowhere.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix2, Matrix4x2, Vector2, Vector3, Vector4};

use super::point::{ContactPoint, velocity_at};
use super::terrain::{Ground, PlanarDual, Terrain};
use crate::numbers::Numbers;
use crate::scalar::{MapEach, Over, Scalar, is_more_than_values};
use crate::spatial::linear::{dot, rotate, rotate_back};
use crate::spatial::{Motion, Transform};

/// Most steps of Newton's method; three to five are usual.
const STEPS: usize = 16;

/// A step is the last one if it is shorter than this, by the radius and the distance from the origin.
const PRECISION: f64 = 1e-12;

/// The most by which the foot may move with the shape: beyond, the ground is as curved as the shape, and the nearest point not the only one.
const MOST_SENSITIVE: f64 = 1e3;

/// Halvings of the distance between two sides of an edge.
const BISECTIONS: usize = 50;

/// The least square of a jump of the slope that makes an edge.
const LEAST_JUMP: f64 = 1e-9;

/// Distance from an edge at which the slope is that of its side, m.
const SIDE: f64 = 1e-9;

/// Minimum unexplained jump of the slope that triggers a search for another foot: a smaller jump moves the surface of a shape by less than 1e-4 of its radius.
const FOLD: f64 = 1e-2;

/// A body in motion.
pub(crate) struct BodyMotion<'a, T> {
    /// Its pose in the world.
    pub(crate) X_WB: &'a Transform<T>,
    /// Its velocity, in the body.
    pub(crate) V_B: &'a Motion<T>,
    /// Duration of contact, s: of two sides that a shape may touch, the one counts that is deeper after this time. 0 for that of this
    /// instant.
    pub(crate) duration: T,
}

/// A rolling point over curved ground.
pub(super) struct Rolling<'a, P, T> {
    point: &'a ContactPoint<P>,
    body: &'a BodyMotion<'a, T>,
    radius: T,
    /// Normal of the ground under the centre, in the world.
    above: Vector3<T>,
    /// Weight of the normal at the foot against that under the centre, from 0 to 1.
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

/// Solution for the foot on plain values: f, and the correction of the slope of the ground there.
type FootUnknowns = Vector4<f64>;

/// Gain K of a Newton step: the unknowns change by −K F.
type Gain = Matrix4x2<f64>;

/// Solution for a foot without derivatives.
struct Solution<T> {
    /// See [`FootUnknowns`].
    unknowns: [T; 4],
    /// See [`Gain`].
    gain: [[T; 2]; 4],
    /// 1 where a nearest point was found; 0 where the point is that below the centre, with the ground under it.
    found: T,
}

/// A foot in one lane.
struct Nearest {
    unknowns: FootUnknowns,
    gain: Gain,
    /// Depth of the shape at the foot after the duration of contact with its present velocity, m.
    depth: f64,
}

impl<'a, P: Scalar, T: Over<P>> Rolling<'a, P, T> {
    /// A point of a body, over ground with a normal under its centre; `None` for a point that does not roll.
    pub(super) fn new(
        point: &'a ContactPoint<P>,
        body: &'a BodyMotion<'a, T>,
        above: Vector3<T>,
    ) -> Option<Self> {
        let radius = point.rolling_radius()?.into();
        let follows = point.follows(&rotate_back(&body.X_WB.rotation, &above));
        Some(Self {
            point,
            body,
            radius,
            above,
            follows,
        })
    }

    /// The foot on a terrain.
    #[inline(never)]
    pub(super) fn foot(&self, terrain: &Terrain<P>) -> Foot<T> {
        let mut solution = self.solve(terrain);
        for _ in 0..T::ORDER.max(usize::from(is_more_than_values::<T>())) {
            let ground = solution.ground(terrain);
            let residual = self.residual(solution.at(), &ground, solution.found);
            solution.newton_step(residual);
        }
        let ground = solution.ground(terrain);
        Foot {
            at: solution.at(),
            ground,
            in_body: self.lowest(&ground.normal(), solution.found),
        }
    }

    /// p(n), in the body; for the normal at the foot, or that under the centre where no foot is `found`.
    fn lowest(&self, normal: &Vector3<T>, found: T) -> Vector3<T> {
        let share = self.follows * found;
        let seen = self
            .above
            .zip_map(normal, |above, own| above + (own - above) * share);
        let R_WB = &self.body.X_WB.rotation;
        self.point.locate(&rotate_back(R_WB, &seen))
    }

    /// F where a foot is `found`, else xy(p − y). Where p is farther from the ground than the radius, it counts as that far: F = 0 has one
    /// solution then however high the shape is.
    fn residual(&self, at: [T; 2], ground: &Ground<T>, found: T) -> [T; 2] {
        let lowest = self.lowest(&ground.normal(), found);
        let p = self.body.X_WB.point(&lowest);
        let gap = (p.z - ground.height).max(-self.radius).min(self.radius) * found;
        [
            p.x - at[0] + ground.slope[0] * gap,
            p.y - at[1] + ground.slope[1] * gap,
        ]
    }

    fn solve(&self, terrain: &Terrain<P>) -> Solution<T> {
        let lowest = self.lowest(&self.above, T::zero());
        let below = self.body.X_WB.point(&lowest);
        let mut out = Solution::below(&below);
        for lane in 0..T::LANES {
            let start = Vector2::new(below.x.value(lane), below.y.value(lane));
            if let Some(nearest) = self.solve_lane(lane, terrain, start) {
                out.set(lane, &nearest);
            }
        }
        out
    }

    fn solve_lane(
        &self,
        lane: usize,
        terrain: &Terrain<P>,
        start: Vector2<f64>,
    ) -> Option<Nearest> {
        let number = |x: T| PlanarDual::from(x.value(lane));
        let BodyMotion {
            X_WB,
            V_B,
            duration,
        } = *self.body;
        let pose = Transform::new(X_WB.rotation.map(number), X_WB.translation.map(number));
        let velocity = Motion::new(V_B.linear.map(number), V_B.angular.map(number));
        let own = Rolling {
            point: &self.point.map_numbers(&mut |x| T::from(x).value(lane)),
            body: &BodyMotion {
                X_WB: &pose,
                V_B: &velocity,
                duration: number(duration),
            },
            radius: number(self.radius),
            above: self.above.map(number),
            follows: number(self.follows),
        };
        let ground = |at: Vector2<f64>| terrain.surface_in_lane::<T>(lane, at.into());
        let starts = std::iter::once(start).chain(behind_folds(start, own.radius.re, &ground));
        let found = starts.filter_map(|start| own.find_from(start, &ground));
        found.reduce(|one, other| if other.depth > one.depth { other } else { one })
    }
}

/// Positions at a distance (m) from another one, along x and y, where the slope differs from its linear extrapolation.
fn behind_folds(
    at: Vector2<f64>,
    distance: f64,
    ground: &dyn Fn(Vector2<f64>) -> Ground<PlanarDual>,
) -> impl Iterator<Item = Vector2<f64>> {
    let slope = ground(at).slope;
    let sides = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
    let steps = sides.map_each(|(x, y)| Vector2::new(x, y) * distance);
    let is_behind = move |step: &Vector2<f64>| {
        let there = ground(at + step).slope;
        let explained = |s: &PlanarDual| s.re + s.eps[0] * step.x + s.eps[1] * step.y;
        let mut both = there.iter().zip(&slope);
        both.any(|(there, here)| (there.re - explained(here)).abs() > FOLD)
    };
    steps
        .into_iter()
        .filter(is_behind)
        .map(move |step| at + step)
}

impl Rolling<'_, f64, PlanarDual> {
    /// The foot found from a start; `None` without a unique nearest point.
    fn find_from(
        &self,
        start: Vector2<f64>,
        ground: &dyn Fn(Vector2<f64>) -> Ground<PlanarDual>,
    ) -> Option<Nearest> {
        let (mut at, radius) = (start, self.radius.re);
        let mut before = at;
        for _ in 0..STEPS {
            let here = ground(at);
            let [x, y] = self.residual_at(at, &here);
            let slope = Matrix2::new(x.eps[0], x.eps[1], y.eps[0], y.eps[1]);
            let inverse = inverse(&slope)?;
            let step = -(inverse * Vector2::new(x.re, y.re));
            let length = step.norm();
            if !length.is_finite() {
                return None;
            }
            before = at;
            at += step * (radius / length).min(1.0);
            if length <= PRECISION * (radius + at.norm()) {
                let is_nearest = slope.trace() < 0.0 && slope.determinant() > 0.0;
                let gain = Gain::identity() * inverse;
                let unknowns = FootUnknowns::new(at.x, at.y, 0.0, 0.0);
                return (is_nearest && inverse.norm() < MOST_SENSITIVE)
                    .then(|| self.nearest(unknowns, gain, &ground(at)));
            }
        }
        self.find_on_edge(before, at, ground)
    }

    /// The foot on an edge of the ground between two positions, each of which leads to the other.
    fn find_on_edge(
        &self,
        mut a: Vector2<f64>,
        mut b: Vector2<f64>,
        ground: &dyn Fn(Vector2<f64>) -> Ground<PlanarDual>,
    ) -> Option<Nearest> {
        let across = (b - a).try_normalize(0.0)?;
        let towards_b = |at: Vector2<f64>| {
            let [x, y] = self.residual_at(at, &ground(at));
            Vector2::new(x.re, y.re).dot(&across)
        };
        if !(towards_b(a) > 0.0 && towards_b(b) < 0.0) {
            return None;
        }
        for _ in 0..BISECTIONS {
            let middle = (a + b) * 0.5;
            *if towards_b(middle) > 0.0 {
                &mut a
            } else {
                &mut b
            } = middle;
        }
        let slope = |at: Vector2<f64>| Vector2::from(ground(at).slope.map_each(|s| s.re));
        let jump = slope(b) - slope(a);
        let side = (jump * jump.dot(&across)).try_normalize(LEAST_JUMP)? * SIDE;
        let along = Vector2::new(-side.y, side.x) / SIDE;
        // f = a + t · along, and the slope is that of one side and a share of the jump.
        let (mut t, mut share) = (0.0, 0.5);
        for _ in 0..STEPS {
            let at = a + along * t;
            let (here, from) = (ground(at), slope(at - side));
            let jump = slope(at + side) - from;
            let own = slope(at);
            let mixed = from + jump * share;
            let edge = Ground {
                height: PlanarDual::new(here.height.re, [own.dot(&along), 0.0]),
                slope: [0, 1].map_each(|k| PlanarDual::new(mixed[k], [0.0, jump[k]])),
            };
            let on_edge = [0, 1].map_each(|k| PlanarDual::new(at[k], [along[k], 0.0]));
            let [x, y] = self.residual(on_edge, &edge, PlanarDual::from(1.0));
            let inverse = inverse(&Matrix2::new(x.eps[0], x.eps[1], y.eps[0], y.eps[1]))?;
            let step = -(inverse * Vector2::new(x.re, y.re));
            if step.norm() <= PRECISION * (1.0 + at.norm()) {
                let (shift, lies_between) = (mixed - own, (0.0..=1.0).contains(&share));
                let unknowns = FootUnknowns::new(at.x, at.y, shift.x, shift.y);
                let gain =
                    Gain::new(along.x, 0.0, along.y, 0.0, 0.0, jump.x, 0.0, jump.y) * inverse;
                return lies_between.then(|| self.nearest(unknowns, gain, &edge));
            }
            t += step.x;
            share += step.y;
        }
        None
    }

    /// F at a point of the plane, with its slope.
    fn residual_at(&self, at: Vector2<f64>, ground: &Ground<PlanarDual>) -> [PlanarDual; 2] {
        let here = [PlanarDual::variable(at.x, 0), PlanarDual::variable(at.y, 1)];
        self.residual(here, ground, PlanarDual::from(1.0))
    }

    fn nearest(&self, unknowns: FootUnknowns, gain: Gain, ground: &Ground<PlanarDual>) -> Nearest {
        let normal = ground.normal();
        let lowest = self.lowest(&normal, PlanarDual::from(1.0));
        let BodyMotion {
            X_WB,
            V_B,
            duration,
        } = *self.body;
        let y = Vector3::new(unknowns.x.into(), unknowns.y.into(), ground.height);
        let velocity = rotate(&X_WB.rotation, &velocity_at(V_B, &lowest));
        let above = X_WB.point(&lowest) + velocity * duration - y;
        let depth = -dot(&above, &normal).re;
        Nearest {
            unknowns,
            gain,
            depth,
        }
    }
}

/// The inverse in closed form. nalgebra's brings those of all sizes up to four along.
fn inverse(m: &Matrix2<f64>) -> Option<Matrix2<f64>> {
    let determinant = m.determinant();
    (determinant != 0.0).then(|| Matrix2::new(m.m22, -m.m12, -m.m21, m.m11) / determinant)
}

impl<T: Scalar> Solution<T> {
    /// That in which the point is the one below the centre, and the ground is that under it.
    fn below(point: &Vector3<T>) -> Self {
        let (zero, one) = (T::zero(), T::one());
        let [x, y] = [point.x, point.y].map_each(|x| T::from_values(|lane| x.value(lane)));
        Self {
            unknowns: [x, y, zero, zero],
            gain: [[-one, zero], [zero, -one], [zero; 2], [zero; 2]],
            found: zero,
        }
    }

    fn set(&mut self, lane: usize, nearest: &Nearest) {
        let put = |out: &mut T, x: f64| {
            *out = T::from_values(|other| if other == lane { x } else { out.value(other) });
        };
        for k in 0..4 {
            put(&mut self.unknowns[k], nearest.unknowns[k]);
            put(&mut self.gain[k][0], nearest.gain[(k, 0)]);
            put(&mut self.gain[k][1], nearest.gain[(k, 1)]);
        }
        put(&mut self.found, 1.0);
    }

    fn at(&self) -> [T; 2] {
        [self.unknowns[0], self.unknowns[1]]
    }

    fn ground<P: Scalar>(&self, terrain: &Terrain<P>) -> Ground<T>
    where
        T: Over<P>,
    {
        let mut ground = terrain.surface(&self.unknowns[0], &self.unknowns[1]);
        ground.slope[0] += self.unknowns[2];
        ground.slope[1] += self.unknowns[3];
        ground
    }

    /// A step of Newton's method.
    fn newton_step(&mut self, residual: [T; 2]) {
        for (x, gain) in self.unknowns.iter_mut().zip(&self.gain) {
            *x -= gain[0] * residual[0] + gain[1] * residual[1];
        }
    }
}
