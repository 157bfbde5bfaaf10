//! Kinematics of a contact point: position, depth and velocity.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use super::point::velocity_at;
use crate::scalar::Scalar;
use crate::spatial::Motion;
use crate::spatial::linear::{rotate, scale};

/// Position, velocity, normal and depth of a contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointState<T> {
    /// Position in the world, m.
    pub position: Vector3<T>,
    /// Velocity of the body there, in the world, m/s.
    pub velocity: Vector3<T>,
    /// Outward unit normal of the ground there, in the world.
    pub normal: Vector3<T>,
    /// Depth of the point below the ground, along the normal, m; negative above. With a [margin](crate::contact::Contacts::with_margin), below that height.
    pub depth: T,
    /// Position in its body, m.
    pub in_body: Vector3<T>,
}

impl<T: Scalar> PointState<T> {
    /// At the world origin, at rest.
    pub fn zero() -> Self {
        Self {
            position: Vector3::zeros(),
            velocity: Vector3::zeros(),
            normal: Vector3::z(),
            depth: T::zero(),
            in_body: Vector3::zeros(),
        }
    }

    /// Two unit vectors across the normal that make a right-handed frame (t₁, t₂, n) with it, in the world.
    ///
    /// They rotate smoothly with the normal while it points upwards [Duff et al. 2017].
    pub(crate) fn tangents(&self) -> [Vector3<T>; 2] {
        let n = &self.normal;
        let a = -(T::one() / (n.z + 1.0));
        let b = n.x * n.y * a;
        [
            Vector3::new(n.x * n.x * a + 1.0, b, -n.x),
            Vector3::new(b, n.y * n.y * a + 1.0, -n.y),
        ]
    }

    /// The axes in which laws see the point: normal, tangent, tangent, in the world.
    pub(crate) fn axes(&self) -> [Vector3<T>; 3] {
        let [t_1, t_2] = self.tangents();
        [self.normal, t_1, t_2]
    }

    /// [`axes`](Self::axes) for a normal that may point anywhere: those of the opposite one below, the last of them reversed. The choice of the half
    /// has no derivatives.
    pub(crate) fn axes_of_any_normal(&self) -> [Vector3<T>; 3] {
        let n = &self.normal;
        let up = (n.z.detached()).select_lt(T::zero(), -T::one(), T::one());
        let upwards = Self {
            normal: scale(n, up),
            ..*self
        };
        let [t_1, t_2] = upwards.tangents();
        [*n, t_1, scale(&t_2, up)]
    }

    /// The velocity of the body at the point, in the world, when it moves with `V_B` (in the body, whose axes are `R_WB`).
    #[inline(always)]
    pub(crate) fn velocity_of(&self, R_WB: &Matrix3<T>, V_B: &Motion<T>) -> Vector3<T> {
        rotate(R_WB, &velocity_at(V_B, &self.in_body))
    }
}
