//! Forces along joints and on frames, given by name.

use nalgebra::DVector;

use super::external::add_frame_force;
use super::kinematics::Kinematics;
use crate::error::UnknownName;
use crate::model::{FrameId, JointId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Representation};

/// Forces along joints and on frames, collected by name; [`joint_forces`] and [`external_forces`] convert them to arguments of the dynamics.
///
/// A force on a frame keeps its representation: a force in the *mixed* representation keeps its direction in the world when the robot moves.
///
/// # Examples
/// ```
/// use dualbody::dynamics::{NamedForces, external_forces, forward_kinematics, joint_forces};
/// use dualbody::model::samples;
/// use dualbody::spatial::{Force, Representation};
///
/// let model = samples::double_pendulum();
/// let mut forces = NamedForces::default();
/// forces.set_joint_forces(&model, &[("elbow", &[2.0])])?;
/// let tip = model.link_names()[2];
/// let push = Force::from_array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
/// forces.add_frame_force(&model, tip, &push, Representation::Mixed)?;
/// assert_eq!(joint_forces(&model, &forces).as_slice(), [0.0, 2.0]);
/// let kinematics = forward_kinematics(&model, &[0.1, 0.2], &[0.0, 0.0]);
/// let external = external_forces(&model, &kinematics, &forces);
/// assert!((external[1].linear.norm() - 1.0).abs() < 1e-15);
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NamedForces<T = f64> {
    joints: Vec<(JointId, Vec<T>)>,
    frames: Vec<(FrameId, Force<T>, Representation)>,
}

impl<T> Default for NamedForces<T> {
    fn default() -> Self {
        Self {
            joints: Vec::new(),
            frames: Vec::new(),
        }
    }
}

impl<T: Scalar> NamedForces<T> {
    /// Sets the forces of some joints (N·m or N, as many as the joint has degrees of freedom); other joints keep their forces, initially zero. A
    /// mimic joint has its own force, which acts on the leader with the ratio of their rates.
    ///
    /// # Errors
    /// If a joint does not exist; then no force is set.
    ///
    /// # Panics
    /// If a force has the wrong length.
    pub fn set_joint_forces<P: Scalar>(
        &mut self,
        model: &Model<P>,
        forces: &[(&str, &[T])],
    ) -> Result<(), UnknownName> {
        let find = |&(name, force): &(&str, &[T])| Ok((model.find_joint(name)?, force.to_vec()));
        let found: Vec<(JointId, Vec<T>)> = forces.iter().map(find).collect::<Result<_, _>>()?;
        for (joint, force) in found {
            let (given, nv) = (force.len(), model.joint_v(joint).len());
            let name = &model.joints()[joint.0].name;
            assert_eq!(given, nv, "the force of joint \"{name}\" has {nv} entries");
            self.joints.retain(|(other, _)| *other != joint);
            self.joints.push((joint, force));
        }
        Ok(())
    }

    /// Adds a force (N, N·m) on a link or any other frame, in a representation as in
    /// [`add_frame_force`](super::add_frame_force), to the forces on it.
    ///
    /// # Errors
    /// If there is no frame with this name.
    pub fn add_frame_force<P: Scalar>(
        &mut self,
        model: &Model<P>,
        name: &str,
        force: &Force<T>,
        representation: Representation,
    ) -> Result<(), UnknownName> {
        let frame = model.find_frame(name)?;
        self.frames.push((frame, *force, representation));
        Ok(())
    }

    /// The forces on frames.
    pub(crate) fn on_frames(&self) -> impl Iterator<Item = (FrameId, &Force<T>, Representation)> {
        let frames = self.frames.iter();
        frames.map(|(frame, force, representation)| (*frame, force, *representation))
    }
}

/// Collects the joint forces τ of named forces, length `nv`. Allocates its result.
///
/// # Panics
/// If the forces are those of another model.
pub fn joint_forces<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    forces: &NamedForces<T>,
) -> DVector<T> {
    let mut tau = DVector::zeros(model.nv());
    for (joint, force) in &forces.joints {
        // Of two bodies none follows.
        let body = model.body(model.joint_body(*joint));
        for (k, &force) in model.joint_v(*joint).zip(force) {
            tau[k] += body.scaled(force);
        }
    }
    tau
}

/// Collects the external force on each body, in its body frame, length `n_bodies`, as
/// [`inverse_dynamics_into`](super::inverse_dynamics_into) and [`forward_dynamics_into`](super::forward_dynamics_into) take it.
/// Allocates its result.
///
/// # Panics
/// If the kinematics or the forces are those of another model.
pub fn external_forces<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
    forces: &NamedForces<T>,
) -> Vec<Force<T>> {
    let mut bodies = vec![Force::zero(); model.n_bodies()];
    for (frame, force, representation) in &forces.frames {
        add_frame_force(
            model,
            kinematics,
            *frame,
            force,
            *representation,
            &mut bodies,
        );
    }
    bodies
}
