//! Contact between bodies: the shapes that can touch each other, and where they do.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

mod choice;
mod finder;

use nalgebra::Vector3;

pub use choice::CollisionOptions;
pub(crate) use finder::{PairFinder, PairPoint};

use super::contacts::Contacts;
use super::point::velocity_at;
use super::point_state::PointState;
use crate::collision::{PairFeature, Shape, witness};
use crate::model::{BodyId, FrameId};
use crate::numbers::Numbers;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::rotate;
use crate::spatial::{Motion, Transform};

/// The most sizes that a shape has.
pub(crate) const SHAPE_NUMBERS: usize = <Shape as Numbers<f64>>::COUNT;

/// A convex shape on a body.
#[derive(Clone, Debug)]
pub(super) struct BodyShape<P> {
    pub(super) link: FrameId,
    /// `None` for what is fixed to the world.
    pub(super) body: Option<BodyId>,
    /// Its pose in the body.
    pub(super) X_BS: Transform<P>,
    pub(super) shape: Shape<P>,
}

/// The shapes of a robot or a world, and the pairs of them that can touch.
#[derive(Clone, Debug)]
pub(super) struct ShapePairs<P> {
    pub(super) shapes: Vec<BodyShape<P>>,
    /// Of a moving body, and of that or of what is fixed to the world.
    pub(super) pairs: Vec<[usize; 2]>,
}

/// A point between bodies in motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairState<T> {
    /// As a point of the first body; its normal points out of the second one, and its velocity is that of the first body less that of the second.
    pub(crate) point: PointState<T>,
    /// Position in the second body, m.
    pub(crate) in_second: Vector3<T>,
}

impl<P: Scalar> ShapePairs<P> {
    /// None.
    pub(super) fn none() -> Self {
        Self {
            shapes: Vec::new(),
            pairs: Vec::new(),
        }
    }

    pub(super) fn cast<Q: Over<P>>(&self) -> ShapePairs<Q> {
        let shapes = self.shapes.iter();
        let cast = |own: &BodyShape<P>| BodyShape {
            link: own.link,
            body: own.body,
            X_BS: own.X_BS.lift(),
            shape: own.shape.lift(),
        };
        ShapePairs {
            shapes: shapes.map(cast).collect(),
            pairs: self.pairs.clone(),
        }
    }
}

impl<P: Scalar> Contacts<P> {
    /// The bodies of a pair of shapes; `None` is the world.
    pub(crate) fn pair_bodies(&self, pair: usize) -> [Option<BodyId>; 2] {
        let pairs = self.shape_pairs();
        pairs.pairs[pair].map(|shape| pairs.shapes[shape].body)
    }

    /// Computes where a point between bodies is and how it moves: half way between the nearest points of both shapes, where equal and opposite forces keep
    /// the angular momentum.
    ///
    /// * `X`, `V` – poses of both bodies in the world and velocities in themselves
    pub(crate) fn pair_state<T: Over<P>>(
        &self,
        point: &PairPoint,
        X: &[Transform<T>; 2],
        V: &[Motion<T>; 2],
    ) -> PairState<T> {
        let pairs = self.shape_pairs();
        let shapes = pairs.pairs[point.pair].map(|shape| &pairs.shapes[shape]);
        state_of_shapes(&point.feature, shapes, X, V)
    }

    /// [`pair_state`](Self::pair_state) with derivatives in the sizes of one of both shapes alone, where numbers have them.
    pub(crate) fn pair_state_by_sizes<T: Over<P>>(
        &self,
        point: &PairPoint,
        side: usize,
        X: &[Transform<T>; 2],
        V: &[Motion<T>; 2],
    ) -> PairState<T> {
        let pairs = self.shape_pairs();
        let mut shapes = pairs.pairs[point.pair].map(|shape| pairs.shapes[shape].clone());
        let other = &mut shapes[1 - side].shape;
        *other = other.map_numbers(&mut |x| x.detached());
        state_of_shapes(&point.feature, [&shapes[0], &shapes[1]], X, V)
    }
}

fn state_of_shapes<P: Scalar, T: Over<P>>(
    feature: &PairFeature,
    [a, b]: [&BodyShape<P>; 2],
    X: &[Transform<T>; 2],
    V: &[Motion<T>; 2],
) -> PairState<T> {
    {
        let (X_WA, X_WB) = (X[0] * a.X_BS.lift(), X[1] * b.X_BS.lift());
        let found = witness(feature, &a.shape, &X_WA, &b.shape, &X_WB);
        let position = (found.points[0] + found.points[1]) * T::constant(0.5);
        let [in_first, in_second] = [0, 1].map(|side| X[side].inverse().point(&position));
        let velocity = |side: usize, at| rotate(&X[side].rotation, &velocity_at(&V[side], at));
        PairState {
            point: PointState {
                position,
                velocity: velocity(0, &in_first) - velocity(1, &in_second),
                normal: -found.normal,
                depth: -found.distance,
                in_body: in_first,
            },
            in_second,
        }
    }
}
