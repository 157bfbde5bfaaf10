//! Simulators of scenes.

use std::path::Path;

use super::inputs::Drive;
use super::scene::MjcfScene;
use crate::error::LoadError;
use crate::io::ModelOptions;
use crate::model::Model;
use crate::sim::{Actuation, Actuator, FrameActuator, Servo, Simulator, TendonServo};

impl MjcfScene {
    /// Makes a simulator of the scene: time step and integrator, joint limits and friction, constraints, contacts, and an input for each modelled
    /// actuator (its control, as in `MuJoCo`). Inputs of joints come first, then those of sites, then those of tendons and of additional actuators of
    /// a joint, each in the order of the file; [`inputs`](Self::inputs) converts controls to this order.
    ///
    /// | MJCF | simulator |
    /// |---|---|
    /// | joint limits, friction losses | [`Actuation::from_model`] |
    /// | actuators of joints | [`Servo`]s, which Euler steps evaluate at their end |
    /// | actuators of fixed tendons, additional ones of a joint | [`TendonServo`]s |
    /// | filters, integrators and delays of actuators, rounded up to whole time steps | [`Activation`](crate::sim::Activation)s, whose signals are held over a step |
    /// | actuators of sites | [`FrameActuator`]s, with a [servo](FrameActuator::with_servo) if they have a bias or gains |
    /// | `refsite` of an actuator | position and axes of the servo, if the reference is fixed to the world |
    /// | contact | [`RelaxedRigid`](crate::contact::RelaxedRigid) with `solref`, `solimp` and friction of the pair, or mixed from both geoms as in `MuJoCo`, and `impratio`; with `condim` 4 and 6 [torsional and rolling friction](crate::contact::TurningFriction) |
    /// | `margin` | height or distance at which contact begins: of a pair its own, else the sum of both geoms; `gap` has no effect, as in `MuJoCo` |
    /// | contact with the ground, a plane or a height field | one contact model per link: that of its first geom, with the largest friction and margin |
    /// | contact between bodies | `contype`, `conaffinity`, pairs and exclusions; the contact model is that of the first two geoms that can touch, others have [materials](crate::contact::CollisionOptions::pairs) of their pairs, for 64 kinds of geoms |
    ///
    /// Reads meshes with contact.
    ///
    /// # Limitations
    /// With active contacts and limits, accelerations differ from those of `MuJoCo`, because the formulations differ: the regularisation uses the
    /// exact Delassus matrix, not an estimate; cones are elliptic; joint limits are springs.
    ///
    /// # Panics
    /// If the mass matrix of the model is singular: [`Model::check_mass_matrix`](crate::Model::check_mass_matrix), or if contact points need more memory than
    /// the [limit](crate::memory).
    ///
    /// # Examples
    /// ```
    /// use dualbody::ModelOptions;
    ///
    /// let xml = r#"<mujoco><option timestep="0.001"/><worldbody><body name="cart"><joint name="x" type="slide" axis="1 0 0"/>
    ///   <geom type="box" size="0.1 0.1 0.1" mass="2"/></body></worldbody><actuator><motor joint="x" gear="10" ctrlrange="-1 1"/></actuator></mujoco>"#;
    /// let (scene, _) = ModelOptions::default().load_mjcf_scene_str(xml)?;
    /// let simulator = scene.simulator();
    /// let next = simulator.step(&scene.reference, &[0.4]);
    /// assert!((next.v[0] - 0.001 * 4.0 / 2.0).abs() < 1e-12);
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn simulator(&self) -> Simulator {
        let model = &self.model;
        let drives = self.drives();
        let joints: Vec<&str> = drives.iter().map(|drive| drive.joint).collect();
        let simulator = Simulator::new(model.clone())
            .with_time_step(self.options.time_step)
            .with_sleeping(self.options.sleeping)
            .with_integrator(self.options.integrator)
            .with_actuation(actuation(model, &drives));
        let mut simulator = match simulator.clone().with_actuated_joints(&joints) {
            Ok(simulator) => simulator,
            Err(_) => simulator,
        };
        let thrusters: Vec<FrameActuator> = self.thrusters().map(|(_, own)| own).collect();
        if !thrusters.is_empty() {
            simulator = simulator.with_frame_actuators(thrusters);
        }
        let pulls: Vec<TendonServo> = self.pulls().map(|(_, own)| own).collect();
        if !pulls.is_empty() {
            simulator = simulator.with_tendon_servos(pulls);
        }
        for (index, input) in self.activated() {
            let own = self.actuation[index].activation.clone();
            let activated = own.map(|own| simulator.clone().with_activation(&input, own));
            // That there is such an input is known.
            if let Some(Ok(activated)) = activated {
                simulator = activated;
            }
        }
        if !self.constraints.is_empty() {
            simulator = simulator.with_constraints(self.constraints.clone());
        }
        match self.touching() {
            Some(contacts) => simulator.with_contacts(contacts),
            None => simulator,
        }
    }
}

/// The joint settings of the description, and the servos of actuators.
fn actuation(model: &Model, drives: &[Drive<'_>]) -> Actuation {
    let mut actuation = Actuation::from_model(model);
    for drive in drives
        .iter()
        .filter(|drive| *drive.servo != Servo::torque(1.0))
    {
        let Some(id) = model.joint(drive.joint) else {
            continue;
        };
        let own = actuation.actuators()[model.joint_v(id).start];
        let servo = Some(*drive.servo);
        // That the joint is there is known, and its kind was checked as it was read.
        if let Ok(changed) =
            (actuation.clone()).with_actuator(model, drive.joint, Actuator { servo, ..own })
        {
            actuation = changed;
        }
    }
    actuation
}

impl Simulator<f64> {
    /// Makes a simulator of the supported content of an MJCF file; see [`MjcfScene::simulator`]. What it does not use of the file is in
    /// [`Model::remarks`] of its [model](Simulator::model), one line each; [`ModelOptions::load_mjcf_scene_file`] returns an
    /// [`ImportReport`](crate::io::ImportReport) of it.
    ///
    /// # Errors
    /// See [`LoadError`]. A sensor, actuator, tendon, equality or pair that names something that the file does not have is an error, as in `MuJoCo`.
    ///
    /// # Panics
    /// If the mass matrix of the model is singular.
    pub fn from_mjcf_file(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        let options = ModelOptions::default();
        Ok(options.load_mjcf_scene_file(path)?.0.simulator())
    }

    /// Makes a simulator of the supported content of an MJCF text, as [`from_mjcf_file`](Self::from_mjcf_file) does of a file.
    ///
    /// # Errors
    /// See [`from_mjcf_file`](Self::from_mjcf_file).
    ///
    /// # Panics
    /// If the mass matrix of the model is singular.
    ///
    /// # Examples
    /// ```
    /// use dualbody::Simulator;
    ///
    /// let xml = r#"<mujoco><worldbody><body><joint name="j"/><geom size="0.1"/><site name="tip"/></body></worldbody>
    ///   <sensor><gyro site="tip"/><clock/></sensor></mujoco>"#;
    /// let simulator = Simulator::from_mjcf_str(xml)?;
    /// let unused = simulator.model().remarks();
    /// assert!(unused.iter().any(|line| line.contains("clock")), "{unused:?}");
    /// let error = Simulator::from_mjcf_str(&xml.replace("gyro site=\"tip\"", "gyro site=\"top\"")).unwrap_err();
    /// assert!(error.to_string().contains("there is no site of that name"), "{error}");
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn from_mjcf_str(xml: &str) -> Result<Self, LoadError> {
        let options = ModelOptions::default();
        Ok(options.load_mjcf_scene_str(xml)?.0.simulator())
    }
}
