//! Inputs of simulators of scenes: which actuator each belongs to.

use std::collections::HashSet;

use nalgebra::DVector;

use super::scene::{MjcfActuator, MjcfKeyframe, MjcfScene, MjcfTransmission};
use crate::constraint::Anchor;
use crate::scalar::MapEach;
use crate::sim::{Activation, FrameActuator, Interval, Servo, TendonServo};
use crate::spatial::{Force, Representation};

impl MjcfScene {
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
    pub(super) fn activated(&self) -> Vec<(usize, String)> {
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
    pub(super) fn drives(&self) -> Vec<Drive<'_>> {
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
    pub(super) fn thrusters(&self) -> impl Iterator<Item = (usize, FrameActuator)> {
        let all = self.actuation.iter().enumerate();
        all.filter_map(|(index, own)| Some((index, self.thruster(own, self.input_name(index))?)))
    }

    /// Actuators of fixed tendons, and those of joints that have one before, with their indices.
    pub(super) fn pulls(&self) -> impl Iterator<Item = (usize, TendonServo)> {
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
pub(super) struct Drive<'a> {
    /// Place in the file.
    index: usize,
    pub(super) joint: &'a str,
    pub(super) servo: &'a Servo,
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
