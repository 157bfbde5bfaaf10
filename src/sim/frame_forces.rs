//! External forces and frame actuators of a simulator.

use super::force::{ExternalForce, FrameActuator, FrameTerms, check};
use super::names::velocity_names;
use super::simulator::Simulator;
use crate::scalar::Scalar;

impl<P: Scalar> Simulator<P> {
    /// Sets the external forces on the robot; without this call there are none. An [`ExternalForce`] is constant or depends on the motion of its
    /// attachment frame.
    ///
    /// All integrators except Runge–Kutta evaluate them at the start of a step.
    ///
    /// # Panics
    /// If an attachment frame belongs to another robot, or is fixed to the world.
    #[must_use]
    pub fn with_external_forces(mut self, forces: Vec<ExternalForce<P>>) -> Self {
        for force in &forces {
            check("an external force", force.place(), &self.model);
        }
        self.frames.forces = forces;
        self
    }

    /// Sets actuators that act on frames: thrusters of a drone, reaction jets, pushes. Each has one input; these follow the inputs of the joints, in this order.
    ///
    /// For a robot with thrusters and unactuated joints, call `with_actuated_joints(&[])`.
    ///
    /// # Panics
    /// If two have the same name, an attachment frame belongs to another model or is fixed to the world, or the integrator is the implicit midpoint rule and one
    /// has a servo.
    #[must_use]
    pub fn with_frame_actuators(mut self, actuators: Vec<FrameActuator<P>>) -> Self {
        for (k, actuator) in actuators.iter().enumerate() {
            let name = actuator.name();
            check(&format!("\"{name}\""), actuator.place(), &self.model);
            let known = actuators[..k].iter().any(|other| other.name() == name);
            assert!(!known, "two frame actuators are called \"{name}\"");
        }
        self.frames.actuators = actuators;
        self.check_integrator();
        self.with_resistance_found().with_activations_placed()
    }

    /// The external forces.
    pub fn external_forces(&self) -> &[ExternalForce<P>] {
        &self.frames.forces
    }

    /// The frame actuators, in the order of their inputs.
    pub fn frame_actuators(&self) -> &[FrameActuator<P>] {
        &self.frames.actuators
    }

    /// The frame actuators that have servos, with their indices among all.
    pub(crate) fn frame_servos(&self) -> impl Iterator<Item = (usize, &FrameActuator<P>)> {
        let all = self.frames.actuators.iter().enumerate();
        all.filter(|(_, own)| own.servo().is_some())
    }

    pub(crate) fn frame_terms(&self) -> &FrameTerms<P> {
        &self.frames
    }

    /// The part of an input that is for frame actuators.
    pub(crate) fn frame_inputs<'u, T>(&self, u: &'u [T]) -> &'u [T] {
        &u[self.actuated().len()..]
    }

    /// Returns the names of the entries of u: joints (`<joint>.<k>` for joints with several coordinates), then frame actuators, then tendon servos. Allocates.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, model::samples};
    ///
    /// assert_eq!(Simulator::new(samples::cartpole()).input_names(), ["linear", "pivot"]);
    /// ```
    pub fn input_names(&self) -> Vec<String> {
        let velocities = velocity_names(self.model());
        let joints = self.actuated().iter().map(|&k| velocities[k].clone());
        let frames = self.frames.actuators.iter();
        let tendons = self.tendon_servos().iter();
        joints
            .chain(frames.map(|actuator| actuator.name().to_owned()))
            .chain(tendons.map(|servo| servo.name().to_owned()))
            .collect()
    }
}
