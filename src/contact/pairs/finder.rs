//! Finds the features of shapes that could touch within a step, on plain values.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use crate::collision::{Bounds, BroadPhase, Manifold, PairFeature, Shape, features};
use crate::contact::activation::ActivationMargin;
use crate::contact::point::velocity_at;
use crate::contact::shape_pairs::ShapePairs;
use crate::contact::{Contacts, LinkShapes};
use crate::dynamics::Kinematics;
use crate::numbers::Numbers as _;
use crate::scalar::{Over, Scalar};
use crate::spatial::{Motion, Transform};

/// Features of a pair of shapes that could touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairPoint {
    /// The shapes; the first one is on a body that moves.
    pub(crate) shapes: [usize; 2],
    pub(crate) feature: PairFeature,
}

/// Finds points between bodies. Decisions are on plain values, lane by lane.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairFinder {
    shapes: Vec<PlacedShape>,
    bounds: Vec<Bounds>,
    broad_phase: BroadPhase,
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
    /// Finds the points that could touch within a step of `dt` (s), pair after pair; those of all lanes together. Whether there was memory for all.
    pub(crate) fn find<P: Scalar, T: Over<P>>(
        &mut self,
        contacts: &Contacts<P>,
        kinematics: &Kinematics<T>,
        dt: P,
        out: &mut Vec<PairPoint>,
    ) -> bool {
        let pairs = contacts.shape_pairs();
        let Some(plain) = &pairs.plain else {
            return true;
        };
        assert!(
            T::HAS_VALUES,
            "contact between bodies cannot be recorded: which features touch is decided on values"
        );
        let margin = contacts.pair_margin(dt);
        let mut fits = true;
        for lane in 0..T::LANES {
            let margin = ActivationMargin {
                duration: margin.duration.value(lane),
                approach: margin.approach.value(lane),
                reach: margin.reach,
            };
            self.place(pairs, plain, kinematics, &margin, lane);
            fits &= self.find_in_lane(pairs, plain, lane, out);
        }
        if T::LANES > 1 {
            out.sort_by_key(|point| point.shapes);
        }
        fits
    }

    fn place<P: Scalar, T: Scalar>(
        &mut self,
        pairs: &ShapePairs<P>,
        plain: &LinkShapes,
        kinematics: &Kinematics<T>,
        margin: &ActivationMargin,
        lane: usize,
    ) {
        self.shapes.clear();
        self.bounds.clear();
        for (own, sized) in plain.shapes().iter().zip(&pairs.shapes) {
            // Sizes are parameters: those of now count.
            let shape: Shape = sized.shape.map_numbers(&mut |x| x.value(lane));
            let X_WB = plain_pose(&kinematics.pose(own.body), lane);
            let V = kinematics.velocity(own.body).to_array();
            let V = Motion::from_array(V.map(|x| x.value(lane)));
            let X_WS = X_WB * own.placement;
            let center = velocity_at(&V, &own.placement.translation).norm();
            let turning = V.angular.norm();
            // A shape fixed to the world may be unbounded, and does not rotate.
            let turns = if turning > 0.0 {
                turning * shape.reach()
            } else {
                0.0
            };
            let margin = margin.half_height(center + turns).max(own.margin);
            self.bounds.push(Bounds::of(&shape, &X_WS, margin));
            self.shapes.push(PlacedShape {
                shape,
                X_WS,
                margin,
            });
        }
    }

    fn find_in_lane<P: Scalar>(
        &mut self,
        pairs: &ShapePairs<P>,
        plain: &LinkShapes,
        lane: usize,
        out: &mut Vec<PairPoint>,
    ) -> bool {
        let may_touch = |i: usize, j: usize| plain.may_collide(i, j, pairs.self_collision);
        let Ok(near) = self.broad_phase.pairs(&self.bounds, may_touch) else {
            return false;
        };
        for &[i, j] in near {
            let shapes = if pairs.body(i).is_none() {
                [j, i]
            } else {
                [i, j]
            };
            let [a, b] = shapes.map(|k| &self.shapes[k]);
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
        true
    }
}

/// The values of a pose in a lane.
pub(in crate::contact) fn plain_pose<T: Scalar>(X: &Transform<T>, lane: usize) -> Transform<f64> {
    Transform::new(
        X.rotation.map(|x| x.value(lane)),
        X.translation.map(|x| x.value(lane)),
    )
}
