//! Simulators whose inputs are the command interfaces of a description.

use std::path::Path;

use super::{ImportReport, ModelOptions};
use crate::error::LoadError;
use crate::model::Model;
use crate::sim::{Actuation, Simulator};

impl ImportReport {
    /// Makes a simulator of the model of this report: with limits and friction of its joints, as by [`Actuation::from_model`], and with the inputs of
    /// [`commands`](Self::commands). Joints without a command interface have no input; if the file states none at all, all joints have one.
    ///
    /// An input is a quantity of the joint, as for controllers of ROS: the effort (N·m or N), or the target of a servo, a position or velocity. A
    /// reduction n of a simple transmission is the [gear](crate::sim::Servo::gear) of the servo, whose gains are then those of the motor, at the same law at the joint.
    ///
    /// | URDF | input |
    /// |---|---|
    /// | `<command_interface name="effort">`, `EffortJointInterface` | the effort |
    /// | `position` with gains | target of [`Servo::position`](crate::sim::Servo::position) |
    /// | `velocity` with gains | target of [`Servo::velocity`](crate::sim::Servo::velocity) |
    /// | `position`, `velocity` without gains in the file | the effort, with a warning |
    /// | `min`, `max` | range of the input |
    ///
    /// Gains are read from the parameters `kp`, `kd`, `p`, `d`, `pos_kp`, `vel_kp`, `position_kp`, … of the interface or its joint. Integral gains are reported.
    ///
    /// # Panics
    /// If the mass matrix of the model is singular: [`Model::check_mass_matrix`].
    ///
    /// # Examples
    /// ```
    /// use dualbody::ModelOptions;
    ///
    /// let text = std::fs::read_to_string("assets/cartpole.urdf")?.replace("</robot>", r#"
    ///   <ros2_control name="cart" type="system"><joint name="linear">
    ///     <command_interface name="position"><param name="kp">400</param><param name="kd">40</param></command_interface>
    ///   </joint></ros2_control></robot>"#);
    /// let (model, report) = ModelOptions::default().load_urdf_str(&text)?;
    /// let simulator = report.simulator(model).with_time_step(0.01);
    /// assert_eq!(simulator.input_names(), ["linear"]);
    /// let moved = simulator.rollout(&simulator.neutral_state(), 500, |_, _, u| u[0] = 0.5);
    /// assert!((moved.last().q[0] - 0.5).abs() < 0.05);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn simulator(&self, model: Model) -> Simulator {
        let actuation = Actuation::from_model(&model);
        let mut actuators = actuation.actuators().to_vec();
        let mut actuated = Vec::new();
        for (joint, servo) in self.commands.iter().flatten() {
            // Options may have locked it.
            let own = model.joint(joint).map(|id| model.joint_v(id));
            if let Some(own) = own.filter(|own| own.len() == 1) {
                actuators[own.start].servo = *servo;
                actuated.push(joint.as_str());
            }
        }
        let simulator = Simulator::new(model).with_actuation(actuation.with_actuators(&actuators));
        if self.commands.is_none() {
            return simulator;
        }
        // The model has all of these joints.
        let all = simulator.clone();
        all.with_actuated_joints(&actuated).unwrap_or(simulator)
    }
}

impl Simulator<f64> {
    /// Makes a simulator of a URDF file with the default [`ModelOptions`]; see [`ImportReport::simulator`].
    ///
    /// # Errors
    /// See [`LoadError`].
    ///
    /// # Panics
    /// If the mass matrix of the model is singular.
    pub fn from_urdf_file(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        let (model, report) = ModelOptions::default().load_urdf_file(path)?;
        Ok(report.simulator(model))
    }
}
