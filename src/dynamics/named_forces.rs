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

    /// The force of a joint, N·m or N; zero by default.
    ///
    /// # Errors
    /// If there is no joint with this name.
    pub fn joint_force<P: Scalar>(
        &self,
        model: &Model<P>,
        name: &str,
    ) -> Result<DVector<T>, UnknownName> {
        let joint = model.find_joint(name)?;
        let own = self.joints.iter().find(|(other, _)| *other == joint);
        Ok(match own {
            Some((_, force)) => DVector::from_column_slice(force),
            None => DVector::zeros(model.joint_v(joint).len()),
        })
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

    /// Replaces the forces on a link or any other frame; forces on other frames of the body are unchanged.
    ///
    /// # Errors
    /// If there is no frame with this name.
    pub fn set_frame_force<P: Scalar>(
        &mut self,
        model: &Model<P>,
        name: &str,
        force: &Force<T>,
        representation: Representation,
    ) -> Result<(), UnknownName> {
        let frame = model.find_frame(name)?;
        self.frames.retain(|(other, ..)| *other != frame);
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
pub fn joint_forces<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    forces: &NamedForces<T>,
) -> DVector<T> {
    let mut tau = DVector::zeros(model.nv());
    joint_forces_into(model, forces, tau.as_mut_slice());
    tau
}

/// [`joint_forces`] without allocation.
///
/// * `tau` – output, length `nv` (N·m or N)
///
/// # Panics
/// If `tau` has the wrong length, or the forces are those of another model.
pub fn joint_forces_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    forces: &NamedForces<T>,
    tau: &mut [T],
) {
    model.check_v(tau);
    tau.fill(T::zero());
    for (joint, force) in &forces.joints {
        // Of two bodies none follows.
        let body = model.body(model.joint_body(*joint));
        for (k, &force) in model.joint_v(*joint).zip(force) {
            tau[k] += body.scaled(force);
        }
    }
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
    external_forces_into(model, kinematics, forces, &mut bodies);
    bodies
}

/// [`external_forces`] without allocation.
///
/// * `bodies` – output, length `n_bodies`
///
/// # Panics
/// As there, and if `bodies` has the wrong length.
pub fn external_forces_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    kinematics: &Kinematics<T>,
    forces: &NamedForces<T>,
    bodies: &mut [Force<T>],
) {
    bodies.fill(Force::zero());
    for (frame, force, representation) in &forces.frames {
        add_frame_force(model, kinematics, *frame, force, *representation, bodies);
    }
}
