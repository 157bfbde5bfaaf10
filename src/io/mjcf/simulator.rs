//! Simulators of scenes.

use std::collections::HashSet;
use std::path::Path;

use nalgebra::DVector;

use super::scene::{MjcfActuator, MjcfKeyframe, MjcfScene, MjcfTransmission};
use crate::constraint::Anchor;
use crate::error::LoadError;
use crate::io::ModelOptions;
use crate::model::Model;
use crate::scalar::MapEach;
use crate::sim::{
    Activation, Actuation, Actuator, FrameActuator, Interval, Servo, Simulator, TendonServo,
};
use crate::spatial::{Force, Representation};

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
    /// | filters, integrators and delays of actuators, rounded up to whole time steps | [`Activation`]s, whose signals are held over a step |
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

    /// Converts controls, one per actuator in the order of the file, to the inputs of the [simulator](Self::simulator). Controls of actuators that
    /// are not modelled are dropped. Allocates.
    ///
    /// # Panics
    /// If the number of controls is wrong.
    pub fn inputs(&self, control: &[f64]) -> Vec<f64> {
        let n = self.actuation.len();
        assert_eq!(control.len(), n, "a control for each actuator of the file");
        let drives = self.drives();
        let joints = drives.iter().map(|drive| drive.index);
        let sites = self.thrusters().map(|(index, _)| index);
        let tendons = self.pulls().map(|(index, _)| index);
        let all = joints.chain(sites).chain(tendons);
        all.map(|index| control[index]).collect()
    }

    /// Actuators whose inputs have activations, in the order of the file, with the names of these inputs.
    fn activated(&self) -> Vec<(usize, String)> {
        let drives = self.drives().into_iter();
        let joints = drives.map(|drive| (drive.index, drive.joint.to_owned()));
        let others = self.thrusters().map(|(index, _)| index);
        let others = others.chain(self.pulls().map(|(index, _)| index));
        let others = others.map(|index| (index, self.input_name(index)));
        let mut out: Vec<_> = joints.chain(others).collect();
        out.retain(|(index, _)| self.actuation[*index].activation.is_some());
        out.sort_unstable();
        out
    }

    /// Gives states the activations of the simulator, and takes over keyframes.
    ///
    /// * `keyframes` – with the activations of all actuators that have one
    /// * `has_dynamics` – whether an actuator has one
    pub(super) fn activate(&mut self, keyframes: Vec<MjcfKeyframe>, has_dynamics: &[bool]) {
        let own: Vec<usize> = self
            .activated()
            .into_iter()
            .map(|(index, _)| index)
            .collect();
        let place = |index: usize| has_dynamics[..index].iter().filter(|has| **has).count();
        let of_states = |given: &[f64]| {
            let mut out = Vec::new();
            for &index in &own {
                let activation = self.actuation[index].activation.as_ref();
                out.resize(out.len() + activation.map_or(0, Activation::states), 0.0);
                if let Some((own, x)) = out.last_mut().zip(given.get(place(index)))
                    && has_dynamics[index]
                {
                    *own = *x;
                }
            }
            DVector::from_vec(out)
        };
        let reference = of_states(&[]);
        let keyframes = keyframes.into_iter().map(|mut keyframe| {
            keyframe.state.activation = of_states(keyframe.state.activation.as_slice());
            keyframe
        });
        self.keyframes = keyframes.collect();
        self.reference.activation = reference;
    }

    /// Actuators of joints: of each joint, unless it is locked, the first.
    fn drives(&self) -> Vec<Drive<'_>> {
        let mut drives: Vec<Drive<'_>> = Vec::new();
        let mut driven = HashSet::new();
        for (index, own) in self.actuation.iter().enumerate() {
            let (MjcfTransmission::Joint(joint), Some(servo)) = (&own.transmission, &own.servo)
            else {
                continue;
            };
            if self.model.joint(joint).is_some() && driven.insert(joint) {
                drives.push(Drive {
                    index,
                    joint,
                    servo,
                });
            }
        }
        drives
    }

    /// Actuators of sites with their indices.
    fn thrusters(&self) -> impl Iterator<Item = (usize, FrameActuator)> {
        let all = self.actuation.iter().enumerate();
        all.filter_map(|(index, own)| Some((index, self.thruster(own, self.input_name(index))?)))
    }

    /// Actuators of fixed tendons, and those of joints that have one before, with their indices.
    fn pulls(&self) -> impl Iterator<Item = (usize, TendonServo)> {
        let first: HashSet<usize> = self.drives().iter().map(|drive| drive.index).collect();
        let all = self.actuation.iter().enumerate();
        let others = all.filter(move |(index, _)| !first.contains(index));
        others.filter_map(|(index, own)| Some((index, self.pull(own, self.input_name(index))?)))
    }

    /// Name of the input of an actuator of a site or tendon: its own, unless it has none or another one has it, too.
    fn input_name(&self, index: usize) -> String {
        let own = &self.actuation[index];
        let alike = self.actuation.iter().filter(|other| other.name == own.name);
        match own.name.is_empty() || alike.count() > 1 {
            true => format!("{}{index}", own.kind),
            false => own.name.clone(),
        }
    }
}

/// An actuator of a joint.
struct Drive<'a> {
    /// Place in the file.
    index: usize,
    joint: &'a str,
    servo: &'a Servo,
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

impl MjcfScene {
    /// The actuator of a site: its gear times the control, or times the force of a servo. That has a position only as seen from another site, as in `MuJoCo`.
    fn thruster(&self, own: &MjcfActuator, name: String) -> Option<FrameActuator> {
        let (site, gear, origin) = match &own.transmission {
            MjcfTransmission::Site(site, gear) => (site, gear, None),
            MjcfTransmission::SiteFrom {
                site,
                reference,
                gear,
            } => {
                let frame = self.model.frame(reference)?;
                (site, gear, Some(self.model.frames()[frame.0].placement))
            }
            _ => return None,
        };
        let mut servo = own.servo?;
        servo.gear = 1.0;
        if origin.is_none() {
            servo.position_gain = 0.0;
        }
        let place = Anchor::frame(&self.model, site).ok()?;
        let moves = self.moves(site);
        let is_force = [servo.bias, servo.velocity_gain, servo.position_gain] == [0.0; 3];
        let gain = if is_force { servo.gain } else { 1.0 };
        let wrench = Force::from_array(gear.map_each(|x| x * gain));
        if !moves || wrench == Force::zero() {
            return None;
        }
        let actuator = match origin {
            None => FrameActuator::new(name, place, wrench, Representation::Body),
            Some(origin) => {
                let [force, moment] =
                    [wrench.linear, wrench.angular].map_each(|x| origin.rotation * x);
                let wrench = Force::new(force, moment);
                FrameActuator::new(name, place, wrench, Representation::Mixed).with_origin(origin)
            }
        };
        if !is_force {
            return Some(actuator.with_servo(servo));
        }
        let Interval { lower, upper } = inputs_of(&servo);
        let is_limited = lower > f64::NEG_INFINITY || upper < f64::INFINITY;
        Some(match lower < upper && is_limited {
            true => actuator.with_limits(lower, upper),
            false => actuator,
        })
    }

    /// The servo of a fixed tendon whose joints are there, or of a joint.
    fn pull(&self, own: &MjcfActuator, name: String) -> Option<TendonServo> {
        let servo = own.servo?;
        let joints: Vec<(&str, f64)> = match &own.transmission {
            MjcfTransmission::Joint(joint) => vec![(joint, 1.0)],
            MjcfTransmission::Tendon(tendon) => {
                let found = self.tendons.iter().find(|own| own.name == *tendon)?;
                found
                    .joints
                    .iter()
                    .map(|(joint, c)| (joint.as_str(), *c))
                    .collect()
            }
            _ => return None,
        };
        TendonServo::new(&self.model, name, &joints, servo).ok()
    }
}

/// The inputs of a motor that its ranges of input and force allow.
fn inputs_of(servo: &Servo) -> Interval {
    let all = Interval {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
    };
    let Interval { lower, upper } = servo.input_range.unwrap_or(all);
    let force = servo.force_range.unwrap_or(all);
    let [a, b] = [force.lower, force.upper].map_each(|force| force / servo.gain);
    Interval {
        lower: lower.max(a.min(b)),
        upper: upper.min(a.max(b)),
    }
}

impl Simulator<f64> {
    /// Makes a simulator of the supported content of an MJCF file; see [`MjcfScene::simulator`].
    ///
    /// # Errors
    /// See [`LoadError`].
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
    /// See [`LoadError`].
    ///
    /// # Panics
    /// If the mass matrix of the model is singular.
    pub fn from_mjcf_str(xml: &str) -> Result<Self, LoadError> {
        let options = ModelOptions::default();
        Ok(options.load_mjcf_scene_str(xml)?.0.simulator())
    }
}
