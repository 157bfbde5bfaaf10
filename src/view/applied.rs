//! External forces and frame actuators as arrows.

use nalgebra::Vector3;

use super::track::{ForceTrack, Track};
use crate::sim::Simulator;

impl Track {
    /// Draws the forces on frames in a simulator: an arrow from the origin of each frame with [external forces](crate::sim::ExternalForce) or
    /// [actuators](crate::sim::FrameActuator), with their sum under the recorded inputs. A thruster on its own link or frame has its own arrow.
    ///
    /// Unknown inputs, for example at the last time, keep the last known value. Moments are not drawn.
    ///
    /// # Panics
    /// If the simulator belongs to another robot, or has other inputs than the recording.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, constraint::Anchor, model::{LinkSpec, ModelBuilder}, sim::FrameActuator, view::Recording};
    ///
    /// let mut builder = ModelBuilder::new("rocket");
    /// builder.add_link(LinkSpec::new("hull").with_mass(2.0, [0.0; 3], [0.1; 3]));
    /// let model = builder.build()?;
    /// let nozzle = FrameActuator::thruster("nozzle", Anchor::frame(&model, "hull")?, [0.0, 0.0, 1.0], 0.0);
    /// let rocket = Simulator::new(model).with_frame_actuators(vec![nozzle]);
    /// let flight = rocket.rollout(&rocket.neutral_state(), 100, |_, _, u| u[0] = 25.0);
    /// let mut recording = Recording::from_rollout(rocket.model(), &flight);
    /// recording.robot_mut(0).add_applied_forces(&rocket);
    /// assert_eq!(recording.robots()[0].forces()[0].values[100].z, 25.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn add_applied_forces(&mut self, simulator: &Simulator) -> &mut Self {
        let (own, other) = (self.model(), simulator.model());
        let same = own.frames().len() == other.frames().len() && own.name() == other.name();
        let (own, other) = (own.name(), other.name());
        assert!(same, "a simulator of \"{other}\" for a track of \"{own}\"");
        if simulator.frame_terms().is_empty() {
            return self;
        }
        let (given, nu) = (self.nu(), simulator.nu());
        assert_eq!(given, nu, "the recorded inputs are not those of \"{own}\"");
        let mut arrows: Vec<ForceTrack> = Vec::new();
        let (mut u, length) = (vec![0.0; nu], self.len());
        for k in 0..length {
            if self.u(k).iter().all(|u| u.is_finite()) {
                u.copy_from_slice(self.u(k));
            }
            let state = simulator.state(self.q(k), self.v(k));
            for applied in simulator.applied_forces(&state, &u) {
                let known = arrows.iter().position(|a| a.frame == applied.frame);
                let at = known.unwrap_or(arrows.len());
                if at == arrows.len() {
                    arrows.push(ForceTrack {
                        frame: applied.frame,
                        values: vec![Vector3::zeros(); length],
                    });
                }
                arrows[at].values[k] += applied.force.linear;
            }
        }
        self.forces.append(&mut arrows);
        self
    }
}
