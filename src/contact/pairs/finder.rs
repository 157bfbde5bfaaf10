//! Finds the features of shapes that could touch within a step, on plain values.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use crate::collision::{Bounds, BroadPhase, Manifold, PairFeature, Shape, features};
use crate::contact::activation::ActivationMargin;
use crate::contact::point::velocity_at;
use crate::contact::shape_pairs::ShapePairs;
use crate::contact::{Contacts, LinkShapes};
use crate::dynamics::Kinematics;
use crate::model::BodyId;
use crate::numbers::Numbers as _;
use crate::scalar::{MapEach, Over, Scalar};
use crate::spatial::{Motion, Transform};

/// Features of a pair of shapes that could touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairPoint {
    /// The shapes; the first one is on a body that moves.
    pub(crate) shapes: [usize; 2],
    pub(crate) feature: PairFeature,
}

/// The pairs of bodies of which points are found.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FoundPairs<'a> {
    /// Those of which neither body sleeps; empty for a world in which none does.
    Awake(&'a [bool]),
    /// Those of a sleeping body and one that is awake and may move.
    Waking(&'a [bool]),
}

impl FoundPairs<'_> {
    /// Whether no body sleeps, and no pair is left out.
    fn are_all(self) -> bool {
        matches!(self, Self::Awake([]))
    }

    fn have(self, bodies: [Option<BodyId>; 2]) -> bool {
        let sleeps = |asleep: &[bool], body: Option<BodyId>| body.map(|body| asleep[body.0]);
        match self {
            Self::Awake(asleep) => !bodies.iter().any(|&own| sleeps(asleep, own) == Some(true)),
            Self::Waking(asleep) => match bodies.map_each(|own| sleeps(asleep, own)) {
                [Some(a), Some(b)] => a != b,
                _ => false,
            },
        }
    }
}

/// Finds points between bodies. Decisions are on plain values, lane by lane.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairFinder {
    shapes: Vec<PlacedShape>,
    bounds: Vec<Bounds>,
    broad_phase: BroadPhase,
    /// Pairs whose boxes overlap, in order.
    near: Vec<[usize; 2]>,
    manifold: Manifold,
}

/// Pose of a shape, and the distance within which it could touch another one.
#[derive(Clone, Debug)]
struct PlacedShape {
    shape: Shape,
    X_WS: Transform<f64>,
    /// Its part of the margin of a pair, m.
    margin: f64,
}

impl PairFinder {
    /// Finds the points of some pairs that could touch within a step of `dt` (s), pair after pair; those of all lanes together. Whether there was memory
    /// for all.
    pub(crate) fn find<P: Scalar, T: Over<P>>(
        &mut self,
        contacts: &Contacts<P>,
        kinematics: &Kinematics<T>,
        dt: P,
        among: FoundPairs<'_>,
        out: &mut Vec<PairPoint>,
    ) -> bool {
        let pairs = contacts.shape_pairs();
        let Some(plain) = &pairs.plain else {
            return true;
        };
        if const { !T::HAS_VALUES } {
            pairs.each_recorded(plain, |shapes, feature| {
                out.push(PairPoint { shapes, feature });
            });
            return true;
        }
        let margin = contacts.pair_margin(dt);
        let mut fits = true;
        for lane in 0..T::LANES {
            let margin = ActivationMargin {
                duration: T::from(margin.duration).value(lane),
                approach: T::from(margin.approach).value(lane),
                reach: margin.reach,
            };
            self.place(pairs, plain, kinematics, &margin, lane);
            let still = margin.half_height(0.0);
            let value = |x: P| T::from(x).value(lane);
            fits &= self.find_near(
                pairs,
                plain,
                among,
                still + pairs.margin_of_triangles(value),
            );
            self.find_in_lane(pairs, plain, (still, value), lane, out);
        }
        if T::LANES > 1 {
            out.sort_by_key(|point| point.shapes);
        }
        fits
    }

    fn place<P: Scalar, T: Over<P>>(
        &mut self,
        pairs: &ShapePairs<P>,
        plain: &LinkShapes,
        kinematics: &Kinematics<T>,
        margin: &ActivationMargin,
        lane: usize,
    ) {
        self.shapes.clear();
        self.bounds.clear();
        let solids = &plain.shapes()[..pairs.surfaces.first];
        for (k, (own, sized)) in solids.iter().zip(&pairs.shapes).enumerate() {
            // Sizes are parameters: those of now count.
            let shape: Shape = sized.shape.map_numbers(&mut |x| T::from(x).value(lane));
            let X_WB = plain_pose(&kinematics.pose(own.body), lane);
            let X_WS = X_WB * own.placement;
            let speed = if margin.duration > 0.0 {
                let V = kinematics.velocity(own.body).to_array();
                let V = Motion::from_array(V.map_each(|x| x.value(lane)));
                most_speed(&shape, &own.placement.translation, &V)
            } else {
                0.0
            };
            let margin = margin.half_height(speed).max(own.margin);
            let margin = margin + pairs.margin_of(k, |x| T::from(x).value(lane));
            self.bounds.push(Bounds::of(&shape, &X_WS, margin));
            self.shapes.push(PlacedShape {
                shape,
                X_WS,
                margin,
            });
        }
    }

    /// Finds the pairs whose boxes overlap, in order: of shapes, and of these with the triangles of surfaces. Whether there are not too many.
    ///
    /// * `still` – part of the margin of a pair that what is at rest has, m
    fn find_near<P: Scalar>(
        &mut self,
        pairs: &ShapePairs<P>,
        plain: &LinkShapes,
        among: FoundPairs<'_>,
        still: f64,
    ) -> bool {
        let may_touch = |i: usize, j: usize| {
            pairs.may_touch(plain, i, j)
                && (among.are_all() || among.have([pairs.body(i), pairs.body(j)]))
        };
        self.near.clear();
        match self.broad_phase.pairs(&self.bounds, may_touch) {
            Ok(found) => self.near.extend_from_slice(found),
            Err(_) => return false,
        }
        let (first, near) = (pairs.surfaces.first, &mut self.near);
        if first == plain.shapes().len() {
            return true;
        }
        let most = BroadPhase::most_pairs(self.bounds.len());
        let moving = (0..first).filter(|&i| pairs.body(i).is_some());
        for i in moving {
            let bounds = self.bounds[i].widened(still);
            pairs.surfaces.tree.each_near(&bounds, |triangle| {
                let j = first + triangle;
                if may_touch(i, j) {
                    near.push([i, j]);
                }
                near.len() <= most
            });
        }
        near.sort_unstable();
        let fits = near.len() <= most;
        if !fits {
            near.clear();
        }
        fits
    }

    fn find_in_lane<P: Scalar>(
        &mut self,
        pairs: &ShapePairs<P>,
        plain: &LinkShapes,
        (still, value): (f64, impl Fn(P) -> f64 + Copy),
        lane: usize,
        out: &mut Vec<PairPoint>,
    ) {
        for &[i, j] in &self.near {
            let shapes = if pairs.body(i).is_none() {
                [j, i]
            } else {
                [i, j]
            };
            let triangle = plain.shapes().get(shapes[1]);
            let triangle = triangle.filter(|_| shapes[1] >= pairs.surfaces.first);
            let triangle = triangle.map(|own| PlacedShape {
                shape: own.shape.clone(),
                X_WS: own.placement,
                margin: still.max(own.margin) + pairs.margin_of(shapes[1], value),
            });
            let a = &self.shapes[shapes[0]];
            let b = triangle.as_ref().unwrap_or_else(|| &self.shapes[shapes[1]]);
            let (margin, manifold) = (a.margin + b.margin, &mut self.manifold);
            features(&a.shape, &a.X_WS, &b.shape, &b.X_WS, margin, manifold);
            let sides = plain.shapes()[shapes[1]].sides.as_ref();
            let admitted = |feature: &&PairFeature| {
                let out = || b.X_WS.rotation.tr_mul(&-feature.seed);
                sides.is_none_or(|sides| sides.admit(&out()))
            };
            for &feature in manifold.pairs().iter().filter(admitted) {
                let is_same =
                    |own: &PairPoint| own.shapes == shapes && own.feature.id == feature.id;
                if lane == 0 || !out.iter().any(is_same) {
                    out.push(PairPoint { shapes, feature });
                }
            }
        }
    }
}

/// The largest speed of a point of a shape at a place of a body with a velocity, or more, m/s.
fn most_speed(shape: &Shape, center: &Vector3<f64>, V: &Motion<f64>) -> f64 {
    let turning = V.angular.norm();
    // A shape fixed to the world may be unbounded, and does not rotate.
    let turns = if turning > 0.0 {
        turning * shape.reach()
    } else {
        0.0
    };
    velocity_at(V, center).norm() + turns
}

/// The values of a pose in a lane.
pub(in crate::contact) fn plain_pose<T: Scalar>(X: &Transform<T>, lane: usize) -> Transform<f64> {
    Transform::new(
        X.rotation.map(|x| x.value(lane)),
        X.translation.map(|x| x.value(lane)),
    )
}
