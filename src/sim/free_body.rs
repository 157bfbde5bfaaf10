//! Pose and velocity of the floating base of a robot, and of free bodies in a world.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::state::State;
use crate::error::UnknownName;
use crate::joint::JointKind;
use crate::model::manifold::{q_range, v_range};
use crate::model::{BASE_JOINT, Body, BodyId, Model};
use crate::scalar::{Over, Scalar, from_each};
use crate::spatial::{Motion, Quaternion, Representation, Transform};

/// Entries of q that a floating base has: position and quaternion.
pub(super) const BASE_POSE: usize = 7;

/// The body that a floating joint on the world moves, by the name of the joint or of its link.
fn find<'m, P: Scalar>(model: &'m Model<P>, joint: &str) -> Result<&'m Body<P>, UnknownName> {
    let found = match model.joint(joint) {
        Some(id) => Some(model.joint_body(id)),
        None if joint == BASE_JOINT && floats(model) => Some(BodyId(0)),
        None => body_of_link(model, joint),
    };
    let free = found.map(|id| model.body(id)).filter(|body| is_free(body));
    free.ok_or_else(|| UnknownName {
        model: model.name().into(),
        element: "floating joint on the world".into(),
        name: joint.into(),
        known: names(model),
    })
}

/// The body whose own link has a name: other links on it may have other poses.
fn body_of_link<P: Scalar>(model: &Model<P>, link: &str) -> Option<BodyId> {
    let body = model.frames()[model.frame(link)?.0].body?;
    (model.body_name(body) == link).then_some(body)
}

fn names<P: Scalar>(model: &Model<P>) -> Vec<String> {
    let joints = model.joints().iter();
    let free = joints.filter(|joint| is_free(model.body(joint.body)));
    let named = free.map(|joint| joint.name.clone());
    let base = floats(model).then(|| BASE_JOINT.to_owned());
    base.into_iter().chain(named).collect()
}

/// Whether the robot has a floating base, whose joint has no name in the model.
fn floats<P: Scalar>(model: &Model<P>) -> bool {
    model.has_floating_base() && model.body_joint(BodyId(0)).is_none()
}

/// Whether a joint lets a body move freely in the world.
pub(super) fn is_free<P>(body: &Body<P>) -> bool {
    body.joint == JointKind::Floating && body.parent.is_none()
}

impl<T: Scalar> State<T> {
    /// Pose `X_WB` in the world of a body on a floating joint: of the floating base of a robot, or of an object or a floating robot of a
    /// [`World`](crate::model::World). Does not allocate.
    ///
    /// * `joint` – name of the joint: `floating_base` for the base of a robot, in a world `{prefix}floating_base`; for an object its name. If no floating
    ///   joint has the name, that of the link that it moves, as for a `<freejoint/>` without a name in an MJCF file
    ///
    /// # Errors
    /// If the model has no floating joint of this name, for example if the base is fixed; the error lists its floating joints.
    ///
    /// # Panics
    /// If the state has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::{Mass, Object, World};
    /// use dualbody::{State, spatial::{Motion, Representation, Transform}};
    ///
    /// let at = |z: f64| Transform::from_translation([0.0, 0.0, z].into());
    /// let mut world = World::default();
    /// world.add_sphere("ball", 0.1, &Object::free(Mass::Kilograms(1.0)).at(at(1.0)))?;
    /// let model = world.build()?;
    /// let mut state = State::neutral(&model);
    /// assert_eq!(state.free_pose(&model, "ball")?, at(1.0));
    /// state.set_free_pose(&model, "ball", &at(3.0))?;
    /// let thrown = Motion::from_array([0.0, 0.0, 2.0, 0.0, 0.0, 0.0]);
    /// state.set_free_velocity(&model, "ball", &thrown, Representation::Mixed)?;
    /// assert_eq!((state.q[2], state.v[2]), (2.0, 2.0)); // 2 m above its place
    /// # Ok::<(), dualbody::EditError>(())
    /// ```
    pub fn free_pose<P: Scalar>(
        &self,
        model: &Model<P>,
        joint: &str,
    ) -> Result<Transform<T>, UnknownName>
    where
        T: Over<P>,
    {
        model.check_q(self.q.as_slice());
        Ok(find(model, joint)?.place(self.q.as_slice()))
    }

    /// Sets the pose `X_WB` in the world of a body on a floating joint. The velocity coordinates stay as they are, so the velocity rotates with the body.
    ///
    /// # Errors
    /// As for [`free_pose`](Self::free_pose).
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn set_free_pose<P: Scalar>(
        &mut self,
        model: &Model<P>,
        joint: &str,
        X_WB: &Transform<T>,
    ) -> Result<(), UnknownName>
    where
        T: Over<P>,
    {
        model.check_q(self.q.as_slice());
        let body = find(model, joint)?;
        let X_JB = body.placement.inverse().lift::<T>() * *X_WB;
        write_pose(&mut self.q.as_mut_slice()[q_range(body)], &X_JB);
        Ok(())
    }

    /// Velocity of a body on a floating joint in a representation, m/s and rad/s. Does not allocate.
    ///
    /// # Errors
    /// As for [`free_pose`](Self::free_pose).
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn free_velocity<P: Scalar>(
        &self,
        model: &Model<P>,
        joint: &str,
        representation: Representation,
    ) -> Result<Motion<T>, UnknownName>
    where
        T: Over<P>,
    {
        model.check_v(self.v.as_slice());
        let X_WB = self.free_pose(model, joint)?;
        let first = find(model, joint)?.v;
        let V_WB_B = Motion::from_array(from_each(|k| self.v[first + k]));
        Ok(representation.velocity_from_body(&X_WB, &V_WB_B))
    }

    /// Sets the velocity of a body on a floating joint from a representation, m/s and rad/s, at its current pose. Does not allocate.
    ///
    /// # Errors
    /// As for [`free_pose`](Self::free_pose).
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn set_free_velocity<P: Scalar>(
        &mut self,
        model: &Model<P>,
        joint: &str,
        velocity: &Motion<T>,
        representation: Representation,
    ) -> Result<(), UnknownName>
    where
        T: Over<P>,
    {
        model.check_v(self.v.as_slice());
        let X_WB = self.free_pose(model, joint)?;
        let own = v_range(find(model, joint)?);
        write_velocity(
            &mut self.v.as_mut_slice()[own],
            &X_WB,
            velocity,
            representation,
        );
        Ok(())
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
