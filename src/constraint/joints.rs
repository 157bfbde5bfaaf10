//! Constraints on positions of joints, φ = Σ cᵢ qᵢ − length: couplers and tendons.

use super::{Constraint, ConstraintKind, ConstraintRow};
use crate::model::{Body, BodyId, Model};
use crate::scalar::{Over, Scalar};

/// A joint with its coefficient cᵢ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TiedJoint<P> {
    pub(crate) body: BodyId,
    pub(crate) coefficient: P,
}

/// Position and rate of a joint, rad or m, including mimic joints.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointMotion<T> {
    pub(crate) position: T,
    pub(crate) rate: T,
}

impl<T: Scalar> JointMotion<T> {
    pub(crate) fn of<P: Scalar>(body: &Body<P>, q: &[T], v: &[T]) -> Self
    where
        T: Over<P>,
    {
        let x = body.scaled(q[body.q]);
        Self {
            position: body.coupling.map_or(x, |coupling| x + coupling.offset),
            rate: body.scaled(v[body.v]),
        }
    }
}

impl<P: Scalar> ConstraintKind<P> {
    /// The joints that it ties; none for constraints between anchors.
    pub(crate) fn joints(&self) -> impl Iterator<Item = TiedJoint<P>> {
        let tied = |(&body, coefficient)| TiedJoint { body, coefficient };
        let coupled = match self {
            Self::Coupler { bodies, ratio, .. } => Some(bodies.iter().zip([P::one(), -*ratio])),
            _ => None,
        };
        let of_tendon = match self {
            Self::Tendon {
                joints,
                coefficients,
                ..
            } => Some(joints.iter().zip(coefficients.iter().copied())),
            _ => None,
        };
        let coupled = coupled.into_iter().flatten().map(tied);
        coupled.chain(of_tendon.into_iter().flatten().map(tied))
    }

    /// Σ cᵢ qᵢ where φ = 0, of constraints that tie joints.
    fn tied_length(&self) -> Option<P> {
        match *self {
            Self::Coupler { offset, .. } => Some(offset),
            Self::Tendon { length, .. } => Some(length),
            _ => None,
        }
    }
}

impl<P: Scalar> Constraint<P> {
    /// The row of a constraint that ties joints; `None` for others.
    pub(super) fn row_of_joints<T: Over<P>>(
        &self,
        model: &Model<P>,
        q: &[T],
        v: &[T],
        dt: T,
    ) -> Option<ConstraintRow<T>> {
        let length: T = self.kind().tied_length()?.into();
        let (mut position, mut rate) = (T::zero(), T::zero());
        for TiedJoint { body, coefficient } in self.kind().joints() {
            let (c, motion) = (
                T::from(coefficient),
                JointMotion::of(model.body(body), q, v),
            );
            position += c * motion.position;
            rate += c * motion.rate;
        }
        let error = position - length;
        let holds = self.hold.at(|| [error * error, T::zero()], dt);
        Some(self.row([error, rate, T::zero()], &holds, false))
    }
}
