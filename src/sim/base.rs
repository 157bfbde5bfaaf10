//! Pose and velocity of the floating base in a state.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::state::State;
use crate::model::{BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Motion, Quaternion, Representation, SPATIAL, Transform};

/// Entries of q that a floating base has: position and quaternion.
pub(super) const BASE_POSE: usize = 7;

impl<T: Scalar> State<T> {
    /// Pose `X_WB` of a floating base in the world; `None` if the base is fixed.
    ///
    /// # Panics
    /// If the state has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{State, model::{LinkSpec, ModelBuilder}, spatial::{Motion, Representation, Transform}};
    /// use nalgebra::Vector3;
    ///
    /// let mut builder = ModelBuilder::new("ball");
    /// builder.add_link(LinkSpec::new("ball").with_mass(1.0, [0.0; 3], [0.1; 3]));
    /// let ball = builder.build()?;
    /// let mut state = State::neutral(&ball);
    /// state.set_base_pose(&ball, &Transform::from_translation(Vector3::new(0.0, 0.0, 0.5)));
    /// state.set_base_velocity(&ball, &Motion::from_array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0]), Representation::Mixed);
    /// assert_eq!((state.q[2], state.v[2]), (0.5, -1.0));
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn base_pose<P: Scalar>(&self, model: &Model<P>) -> Option<Transform<T>>
    where
        T: Over<P>,
    {
        model.check_q(self.q.as_slice());
        let floats = model.has_floating_base();
        floats.then(|| model.body(BodyId(0)).place(self.q.as_slice()))
    }

    /// Sets the pose `X_WB` of a floating base. The velocity coordinates stay as they are, so the velocity rotates with the base.
    ///
    /// # Panics
    /// If the base is fixed, or the state has the wrong length.
    pub fn set_base_pose<P: Scalar>(&mut self, model: &Model<P>, X_WB: &Transform<T>) {
        model.check_q(self.q.as_slice());
        assert_floating(model);
        write_pose(&mut self.q.as_mut_slice()[..BASE_POSE], X_WB);
    }

    /// Velocity of a floating base in a representation (m/s, rad/s); `None` if the base is fixed. Does not allocate.
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn base_velocity<P: Scalar>(
        &self,
        model: &Model<P>,
        representation: Representation,
    ) -> Option<Motion<T>>
    where
        T: Over<P>,
    {
        model.check_v(self.v.as_slice());
        let X_WB = self.base_pose(model)?;
        let V_WB_B = Motion::from_array(std::array::from_fn(|k| self.v[k]));
        Some(representation.velocity_from_body(&X_WB, &V_WB_B))
    }

    /// Sets the velocity of a floating base from a representation (m/s, rad/s), at its current pose. Does not allocate.
    ///
    /// # Panics
    /// If the base is fixed, or the state has the wrong length.
    pub fn set_base_velocity<P: Scalar>(
        &mut self,
        model: &Model<P>,
        velocity: &Motion<T>,
        representation: Representation,
    ) where
        T: Over<P>,
    {
        model.check_q(self.q.as_slice());
        model.check_v(self.v.as_slice());
        assert_floating(model);
        let X_WB = model.body(BodyId(0)).place(self.q.as_slice());
        let own = &mut self.v.as_mut_slice()[..SPATIAL];
        write_velocity(own, &X_WB, velocity, representation);
    }
}

/// Writes a pose as the configuration of a floating joint.
pub(super) fn write_pose<T: Scalar>(q: &mut [T], X: &Transform<T>) {
    q[..3].copy_from_slice(X.translation.as_slice());
    Quaternion::from_matrix(&X.rotation).write_to(&mut q[3..]);
}

/// Writes the velocity of a floating joint, given in a representation at a pose.
pub(super) fn write_velocity<T: Scalar>(
    v: &mut [T],
    X_WB: &Transform<T>,
    velocity: &Motion<T>,
    representation: Representation,
) {
    let V_WB_B = representation.velocity_to_body(X_WB, velocity);
    v.copy_from_slice(&V_WB_B.to_array());
}

fn assert_floating<P: Scalar>(model: &Model<P>) {
    assert!(
        model.has_floating_base(),
        "the base of \"{}\" is fixed: it has no pose and no velocity to set",
        model.name()
    );
}
