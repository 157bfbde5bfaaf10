//! Representations: the frame in which a spatial velocity, force or Jacobian is expressed.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::linear::{rotate, rotate_back};
use super::{Force, Motion, Transform};
use crate::scalar::Scalar;

/// The three usual representations of the velocity of a frame F in the world W.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Representation {
    /// Origin of F, axes of F (left-trivialised, Pinocchio's `LOCAL`).
    Body,
    /// Origin of F, axes of W (Pinocchio's `LOCAL_WORLD_ALIGNED`): the linear part is ṗ, the velocity of F's origin.
    ///
    /// The linear part of an *acceleration* in this representation is p̈, the classical acceleration of F's origin (Pinocchio's
    /// `getFrameClassicalAcceleration`): the rate of the coordinates of the velocity. In the other two representations it is the spatial
    /// acceleration, p̈ − ω × ṗ of the point at the origin. Pinocchio's `getFrameAcceleration` in `LOCAL_WORLD_ALIGNED` is spatial: it equals this
    /// one minus (ω × ṗ, 0).
    Mixed,
    /// Origin of W, axes of W (right-trivialised, Pinocchio's `WORLD`).
    Inertial,
}

impl Representation {
    /// Array of all representations, for tests and tables.
    pub const ALL: [Self; 3] = [Self::Body, Self::Mixed, Self::Inertial];

    /// Converts a velocity of F from the body representation to this one; `X_WF` is the pose of F.
    // Out of line it costs a frame Jacobian a tenth more instructions.
    #[inline(always)]
    pub(crate) fn velocity_from_body<T: Scalar>(
        self,
        X_WF: &Transform<T>,
        V_F: &Motion<T>,
    ) -> Motion<T> {
        let R = &X_WF.rotation;
        match self {
            Self::Body => *V_F,
            Self::Mixed => Motion::new(rotate(R, &V_F.linear), rotate(R, &V_F.angular)),
            Self::Inertial => X_WF.motion(V_F),
        }
    }

    /// Converts a velocity of F from this representation to the body representation.
    #[inline]
    pub(crate) fn velocity_to_body<T: Scalar>(
        self,
        X_WF: &Transform<T>,
        V: &Motion<T>,
    ) -> Motion<T> {
        let R = &X_WF.rotation;
        match self {
            Self::Body => *V,
            Self::Mixed => Motion::new(rotate_back(R, &V.linear), rotate_back(R, &V.angular)),
            Self::Inertial => X_WF.motion_inverse(V),
        }
    }

    /// Converts a force on F from the body representation to this one, with equal power.
    #[inline]
    pub(crate) fn force_from_body<T: Scalar>(
        self,
        X_WF: &Transform<T>,
        F_F: &Force<T>,
    ) -> Force<T> {
        let R = &X_WF.rotation;
        match self {
            Self::Body => *F_F,
            Self::Mixed => Force::new(rotate(R, &F_F.linear), rotate(R, &F_F.angular)),
            Self::Inertial => X_WF.force(F_F),
        }
    }

    /// Converts a force on F from this representation to the body representation.
    #[inline]
    pub(crate) fn force_to_body<T: Scalar>(self, X_WF: &Transform<T>, F: &Force<T>) -> Force<T> {
        let R = &X_WF.rotation;
        match self {
            Self::Body => *F,
            Self::Mixed => Force::new(rotate_back(R, &F.linear), rotate_back(R, &F.angular)),
            Self::Inertial => X_WF.force_inverse(F),
        }
    }

    /// Converts an acceleration of F from the body representation to this one, the rate of its velocity here; `V_F` is the velocity of F in the body
    /// representation.
    #[inline]
    pub(crate) fn acceleration_from_body<T: Scalar>(
        self,
        X_WF: &Transform<T>,
        V_F: &Motion<T>,
        A_F: &Motion<T>,
    ) -> Motion<T> {
        self.velocity_from_body(X_WF, &(*A_F + self.turning(V_F).cross(V_F)))
    }

    /// Converts an acceleration of F from this representation to the body representation; `V_F` is the velocity of F in the body representation.
    #[inline]
    pub(crate) fn acceleration_to_body<T: Scalar>(
        self,
        X_WF: &Transform<T>,
        V_F: &Motion<T>,
        A: &Motion<T>,
    ) -> Motion<T> {
        self.velocity_to_body(X_WF, A) - self.turning(V_F).cross(V_F)
    }

    /// Velocity of F with respect to the axes of expression, in F.
    #[inline]
    pub(crate) fn turning<T: Scalar>(self, V_F: &Motion<T>) -> Motion<T> {
        match self {
            Self::Body => Motion::zero(),
            Self::Mixed => Motion::new(Vector3::zeros(), V_F.angular),
            Self::Inertial => *V_F,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::Quaternion;
    use crate::tests::ROUNDING;

    fn pose() -> Transform<f64> {
        Transform::new(
            Quaternion::exp(&Vector3::new(0.4, -1.0, 0.6)).to_matrix(),
            Vector3::new(1.0, -2.0, 0.5),
        )
    }

    const VELOCITY: [f64; 6] = [0.3, -1.0, 0.7, 2.0, 0.1, -0.4];
    const FORCE: [f64; 6] = [1.3, 0.2, -0.6, -1.0, 0.9, 0.5];

    fn assert_same(a: [f64; 6], b: [f64; 6]) {
        assert!(
            a.iter()
                .zip(b)
                .all(|(a, b)| (a - b).abs() < 10.0 * ROUNDING),
            "{a:?} against {b:?}"
        );
    }

    #[test]
    fn converters_to_and_from_the_body_are_inverse() {
        let (X, V, F, A) = (
            pose(),
            Motion::from_array(VELOCITY),
            Force::from_array(FORCE),
            Motion::from_array(FORCE),
        );
        for r in Representation::ALL {
            assert_same(
                r.velocity_to_body(&X, &r.velocity_from_body(&X, &V))
                    .to_array(),
                V.to_array(),
            );
            assert_same(
                r.force_to_body(&X, &r.force_from_body(&X, &F)).to_array(),
                F.to_array(),
            );
            let there = r.acceleration_from_body(&X, &V, &A);
            assert_same(
                r.acceleration_to_body(&X, &V, &there).to_array(),
                A.to_array(),
            );
        }
    }

    #[test]
    fn power_is_the_same_in_every_representation() {
        let (X, V, F) = (
            pose(),
            Motion::from_array(VELOCITY),
            Force::from_array(FORCE),
        );
        for r in Representation::ALL {
            let power = r
                .velocity_from_body(&X, &V)
                .power(&r.force_from_body(&X, &F));
            assert!((power - V.power(&F)).abs() < 1e-13, "{r:?}");
        }
    }
}
