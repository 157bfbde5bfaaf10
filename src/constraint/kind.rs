//! Kinds of constraints.

use super::{Anchor, AnchorMotion};
use crate::model::{BodyId, Model};
use crate::numbers::{Domain, Numbers, numbers};
use crate::scalar::{Over, Scalar};
use crate::spatial::Transform;

/// Kinds of constraints with their attachment frames and parameters.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ConstraintKind<P = f64> {
    /// Two attachment frames coincide in position and orientation. Six rows: m, in the world's axes; then rad, in the world's axes, the rotation vector from
    /// the first to the second.
    Weld([Anchor<P>; 2]),
    /// The origins of two attachment frames coincide: a ball joint. Three rows: m, in the world's axes, from the first to the second.
    Ball([Anchor<P>; 2]),
    /// The origins of two attachment frames keep a distance: a massless rod. One row, m.
    Distance {
        /// The two anchors at the ends of the rod.
        anchors: [Anchor<P>; 2],
        /// m, positive.
        length: P,
    },
    /// The position of a joint follows that of another one: q₁ = ratio q₂ + offset + Σ hₙ q₂ⁿ, n ≥ 2. One row, rad or m.
    Coupler {
        /// The bodies that the two joints move.
        bodies: [BodyId; 2],
        /// Transmission ratio: displacement of the first joint per displacement of the second.
        ratio: P,
        /// Position of the first where that of the second is 0, rad or m.
        offset: P,
        /// h₂, h₃ and h₄, as many as there are.
        higher: Vec<P>,
    },
    /// A weighted sum of joint positions is constant, Σ cᵢ qᵢ = length: a fixed tendon. One row, in the unit of that sum.
    Tendon {
        /// The bodies that the joints move.
        joints: Vec<BodyId>,
        /// cᵢ of each joint, as the moment arm of a pulley (m).
        coefficients: Vec<P>,
        /// Sum where the tendon is neither stretched nor slack.
        length: P,
    },
}

/// A number hₙ of a coupler, in messages.
pub(super) const POWER: &str = "coefficient of a power";

numbers! { pub enum ConstraintKind {
    Weld(anchors: part(Anchor)),
    Ball(anchors: part(Anchor)),
    Distance { anchors: part(Anchor), length: Positive("length", "distance") },
    Coupler {
        bodies: kept(),
        ratio: Finite("ratio", "ratio of a coupler"),
        offset: Finite("offset", "offset of a coupler"),
        higher: hidden(),
    },
    Tendon {
        joints: kept(),
        coefficients: hidden(),
        length: Finite("length", "length of a tendon"),
    },
} }

impl<P: Scalar> ConstraintKind<P> {
    pub(super) fn rows(&self) -> usize {
        match self {
            Self::Weld(_) => 6,
            Self::Ball(_) => 3,
            Self::Distance { .. } | Self::Coupler { .. } | Self::Tendon { .. } => 1,
        }
    }

    /// Motions of the attachment frames at (q, v); identities at rest for constraints between joints.
    pub(super) fn motions<T: Over<P>>(
        &self,
        model: &Model<P>,
        q: &[T],
        v: &[T],
    ) -> [AnchorMotion<T>; 2] {
        let anchors = self.anchors();
        std::array::from_fn(|i| {
            let still = || AnchorMotion::at_rest(Transform::identity());
            anchors.get(i).map_or_else(still, |a| a.motion(model, q, v))
        })
    }

    pub(crate) fn anchors(&self) -> &[Anchor<P>] {
        match self {
            Self::Weld(anchors) | Self::Ball(anchors) | Self::Distance { anchors, .. } => anchors,
            Self::Coupler { .. } | Self::Tendon { .. } => &[],
        }
    }

    /// # Panics
    /// If a value is out of its domain.
    pub(super) fn check(&self) {
        self.check_numbers();
        for anchor in self.anchors() {
            anchor.placement.map_numbers(&mut |x| {
                Domain::Finite.check("pose of an attachment frame", x);
                x
            });
        }
        for joint in self.joints() {
            Domain::Finite.check("coefficient of a joint", joint.coefficient);
            let higher = joint.higher.iter();
            higher.for_each(|&h| Domain::Finite.check(POWER, h));
        }
    }
}
