//! Which features of which shapes could touch within a step, on plain values.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::{BodyShape, ShapePairs};
use crate::collision::{Manifold, PairFeature, Shape, features};
use crate::contact::Contacts;
use crate::contact::activation::ActivationMargin;
use crate::contact::point::velocity_at;
use crate::dynamics::Kinematics;
use crate::numbers::Numbers as _;
use crate::scalar::{Over, Scalar};
use crate::spatial::{Motion, Transform};

/// Features of a pair of shapes that could touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairPoint {
    /// The pair of shapes.
    pub(crate) pair: usize,
    pub(crate) feature: PairFeature,
}

/// Finds points between bodies. Decisions are on plain values, lane by lane.
#[derive(Clone, Debug)]
pub(crate) struct PairFinder {
    shapes: Vec<PlainShape>,
    manifold: Manifold,
}

/// A shape as plain values, and where it is.
#[derive(Clone, Debug)]
struct PlainShape {
    X_BS: Transform<f64>,
    shape: Shape,
    /// Of a ball about its origin that holds it, m; infinite for a half-space.
    reach: f64,
    X_WS: Transform<f64>,
    /// Greatest speed of a point of it, m/s.
    speed: f64,
}

impl PairFinder {
    /// For the shapes of contacts. Allocates.
    pub(crate) fn new<P: Scalar>(contacts: Option<&Contacts<P>>) -> Self {
        let shapes = contacts.map_or(&[][..], |contacts| &contacts.shape_pairs().shapes);
        Self {
            shapes: shapes.iter().map(PlainShape::new).collect(),
            manifold: Manifold::default(),
        }
    }

    /// Finds the points that could touch within a step of `dt` (s), pair after pair; those of all lanes together.
    pub(crate) fn find<P: Scalar, T: Over<P>>(
        &mut self,
        contacts: &Contacts<P>,
        kinematics: &Kinematics<T>,
        dt: P,
        out: &mut Vec<PairPoint>,
    ) {
        let pairs = contacts.shape_pairs();
        if pairs.pairs.is_empty() {
            return;
        }
        assert!(
            T::HAS_VALUES,
            "contact between bodies cannot be recorded: which features touch is decided on values"
        );
        let margin = contacts.activation_margin(dt);
        for lane in 0..T::LANES {
            self.place(pairs, kinematics, lane);
            let margin = ActivationMargin {
                duration: margin.duration.value(lane),
                approach: margin.approach.value(lane),
                reach: margin.reach,
            };
            self.find_in_lane(pairs, &margin, lane, out);
        }
        if T::LANES > 1 {
            out.sort_by_key(|point| point.pair);
        }
    }

    fn place<P: Scalar, T: Over<P>>(
        &mut self,
        pairs: &ShapePairs<P>,
        kinematics: &Kinematics<T>,
        lane: usize,
    ) {
        for (plain, own) in self.shapes.iter_mut().zip(&pairs.shapes) {
            let X_WB = plain_pose(&kinematics.pose(own.body), lane);
            let V = kinematics.velocity(own.body).to_array();
            let V = Motion::from_array(V.map(|x| x.value(lane)));
            plain.X_WS = X_WB * plain.X_BS;
            let center = velocity_at(&V, &plain.X_BS.translation).norm();
            // A half-space that turns has no greatest speed; it does not turn.
            let turning = V.angular.norm();
            plain.speed = center
                + if turning > 0.0 {
                    turning * plain.reach
                } else {
                    0.0
                };
        }
    }

    fn find_in_lane<P: Scalar>(
        &mut self,
        pairs: &ShapePairs<P>,
        margin: &ActivationMargin,
        lane: usize,
        out: &mut Vec<PairPoint>,
    ) {
        for (pair, &[i, j]) in pairs.pairs.iter().enumerate() {
            let (a, b) = (&self.shapes[i], &self.shapes[j]);
            let margin = margin.height(a.speed + b.speed);
            if a.is_farther_than(b, margin) {
                continue;
            }
            let manifold = &mut self.manifold;
            features(&a.shape, &a.X_WS, &b.shape, &b.X_WS, margin, manifold);
            for &feature in manifold.pairs() {
                let is_same = |own: &PairPoint| own.pair == pair && own.feature.id == feature.id;
                if lane == 0 || !out.iter().any(is_same) {
                    out.push(PairPoint { pair, feature });
                }
            }
        }
    }
}

impl PlainShape {
    fn new<P: Scalar>(own: &BodyShape<P>) -> Self {
        let shape: Shape = own.shape.map_numbers(&mut |x| x.value(0));
        Self {
            X_BS: plain_pose(&own.X_BS, 0),
            reach: reach(&shape),
            shape,
            X_WS: Transform::identity(),
            speed: 0.0,
        }
    }

    /// Whether the balls around two shapes are farther apart; never for a half-space.
    fn is_farther_than(&self, other: &Self, margin: f64) -> bool {
        let apart = (self.X_WS.translation - other.X_WS.translation).norm();
        apart - self.reach - other.reach > margin
    }
}

fn plain_pose<T: Scalar>(X: &Transform<T>, lane: usize) -> Transform<f64> {
    Transform::new(
        X.rotation.map(|x| x.value(lane)),
        X.translation.map(|x| x.value(lane)),
    )
}

/// Radius of a ball about the origin that holds a shape, m.
fn reach(shape: &Shape) -> f64 {
    let largest = |lengths: [f64; 3]| lengths.into_iter().fold(0.0, f64::max);
    match shape {
        Shape::Sphere { radius } => *radius,
        Shape::Capsule {
            radius,
            half_length,
        } => radius + half_length,
        Shape::Box { half_extents } => Vector3::from(*half_extents).norm(),
        Shape::Cylinder {
            radius,
            half_length,
        } => radius.hypot(*half_length),
        Shape::Ellipsoid { semi_axes } => largest(*semi_axes),
        Shape::Hull { hull, scale } => {
            let scaled = |v: &Vector3<f64>| v.component_mul(&Vector3::from(*scale)).norm();
            hull.vertices().iter().map(scaled).fold(0.0, f64::max)
        }
        Shape::HalfSpace => f64::INFINITY,
    }
}
