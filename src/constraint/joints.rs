//! Constraints on positions of joints, φ = Σ gᵢ(qᵢ) − length: couplers and tendons. gᵢ is cᵢ qᵢ, except that of the second joint of a coupler,
//! which may be a polynomial.

use super::{Constraint, ConstraintKind, ConstraintRow};
use crate::model::{Body, BodyId, Model};
use crate::scalar::{Over, Scalar};

/// A joint with its function g(q) = c q − Σ hₙ qⁿ, n ≥ 2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TiedJoint<'a, P> {
    pub(crate) body: BodyId,
    pub(crate) coefficient: P,
    /// hₙ; mostly none.
    pub(crate) higher: &'a [P],
}

impl<P: Scalar> TiedJoint<'_, P> {
    pub(crate) fn is_linear(&self) -> bool {
        self.higher.is_empty()
    }

    /// g and its first three derivatives at a position of the joint.
    pub(crate) fn at<T: Over<P>>(&self, position: T) -> [T; 4] {
        let (c, zero) = (T::from(self.coefficient), T::zero());
        if self.is_linear() {
            return [c * position, c, zero, zero];
        }
        // Horner's rule for each.
        let step = |[g, first, second, third]: [T; 4], c: T| {
            [
                g * position + c,
                first * position + g,
                second * position + first * 2.0,
                third * position + second * 3.0,
            ]
        };
        let higher = self.higher.iter().rev().map(|&h| -T::from(h));
        higher.chain([c, zero]).fold([zero; 4], step)
    }
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
        Self {
            position: joint_position(body, q),
            rate: body.scaled(v[body.v]),
        }
    }
}

/// Position of a joint of one degree of freedom, rad or m, including mimic joints.
pub(super) fn joint_position<P: Scalar, T: Over<P>>(body: &Body<P>, q: &[T]) -> T {
    let x = body.scaled(q[body.q]);
    body.coupling.map_or(x, |coupling| x + coupling.offset)
}

impl<P: Scalar> ConstraintKind<P> {
    /// The joints that it ties; none for constraints between anchors.
    pub(crate) fn joints(&self) -> impl Iterator<Item = TiedJoint<'_, P>> {
        let tied = |(&body, coefficient)| TiedJoint {
            body,
            coefficient,
            higher: &[],
        };
        let coupled = match self {
            Self::Coupler {
                bodies: [first, second],
                ratio,
                higher,
                ..
            } => {
                let follower = TiedJoint {
                    higher,
                    ..tied((second, -*ratio))
                };
                Some([tied((first, P::one())), follower])
            }
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
        let coupled = coupled.into_iter().flatten();
        coupled.chain(of_tendon.into_iter().flatten().map(tied))
    }

    /// Σ gᵢ where φ = 0, of constraints that tie joints.
    fn tied_length(&self) -> Option<P> {
        match self {
            Self::Coupler { offset, .. } => Some(*offset),
            Self::Tendon { length, .. } => Some(*length),
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
        let (mut position, mut rate, mut bias) = (T::zero(), T::zero(), T::zero());
        for tied in self.kind().joints() {
            let motion = JointMotion::of(model.body(tied.body), q, v);
            let [g, first, second, _] = tied.at(motion.position);
            position += g;
            rate += first * motion.rate;
            if !tied.is_linear() {
                bias += second * motion.rate * motion.rate;
            }
        }
        let error = position - length;
        let holds = self.hold.at(|| [error * error, T::zero()], dt);
        Some(self.row([error, rate, bias], &holds, false))
    }
}
