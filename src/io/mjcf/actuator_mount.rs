//! Actuators on the frames and tendons of a model.

use super::actuator::ActuatorEntry;
use super::scene::{MjcfActuator, MjcfTendon, MjcfTransmission};
use super::sections::Names;
use crate::io::context::Context;
use crate::model::Model;

impl ActuatorEntry {
    /// Finds its target: the frame of a site, a fixed tendon; the remaining things of motors act on joints only.
    pub(super) fn mount(
        &mut self,
        names: &Names,
        tendons: &[MjcfTendon],
        model: &Model,
        context: &mut Context<'_>,
    ) {
        let lack = match &mut self.actuator.transmission {
            MjcfTransmission::Site(site, _) => names.locate(site),
            MjcfTransmission::SiteFrom {
                site, reference, ..
            } => {
                let lack = names.locate(site).or_else(|| names.locate(reference));
                lack.or_else(|| moving(reference, model))
            }
            MjcfTransmission::Tendon(tendon) => {
                let is_fixed = tendons.iter().any(|own| own.name == *tendon);
                (!is_fixed).then(|| format!("\"{tendon}\" is not a fixed tendon"))
            }
            _ => return,
        };
        let has_servo = self.actuator.servo.is_some();
        if let Some(lack) = lack.filter(|_| has_servo) {
            self.actuator.servo = None;
            self.actuator.activation = None;
            let reason = format!("{lack}; kept in the scene");
            context.ignore(&self.place, reason);
        } else if has_servo && self.of_motor != [0.0; 2] {
            let reason = "armature and damping of the motor count on joints only";
            context.ignore(&self.place, reason);
        }
    }

    /// Makes the velocity gain of a damping ratio ζ: 2 ζ √(`k_p` I / n²), with the inertia I that joint or tendon feel where the file has the bodies.
    ///
    /// # References
    /// The attribute `dampratio` in the XML reference of `MuJoCo`; that the other joints are free was measured.
    pub(super) fn damp(
        &mut self,
        model: &Model,
        tendons: &[MjcfTendon],
        inertia: &impl Fn(&[(usize, f64)]) -> f64,
    ) {
        let Some(along) = self.actuator.along(model, tendons) else {
            return;
        };
        let (ratio, inertia) = (self.damping_ratio.unwrap_or_default(), inertia(&along));
        if let Some(servo) = &mut self.actuator.servo {
            let seen = inertia / (servo.gear * servo.gear);
            servo.velocity_gain = 2.0 * ratio * (servo.position_gain * seen).sqrt();
        }
    }
}

impl Names {
    /// Replaces the name of a site by that of its frame, or says that there is none.
    fn locate(&self, site: &mut String) -> Option<String> {
        let Some(frame) = self.sites.get(site.as_str()) else {
            return Some(format!("there is no frame of the site \"{site}\""));
        };
        site.clone_from(frame);
        None
    }
}

/// Why a site cannot be a reference, if it cannot.
fn moving(reference: &str, model: &Model) -> Option<String> {
    let frame = model.frame(reference)?;
    model.frames()[frame.0].body?;
    Some(format!(
        "its refsite \"{reference}\" moves: only one that is fixed to the world is modelled"
    ))
}

impl MjcfActuator {
    /// Coordinates along which it acts with their coefficients, on a joint or a fixed tendon of the model.
    fn along(&self, model: &Model, tendons: &[MjcfTendon]) -> Option<Vec<(usize, f64)>> {
        let coordinate = |joint: &str| Some(model.joint_v(model.joint(joint)?).start);
        match &self.transmission {
            MjcfTransmission::Joint(joint) => Some(vec![(coordinate(joint)?, 1.0)]),
            MjcfTransmission::Tendon(name) => {
                let tendon = tendons.iter().find(|own| own.name == *name)?;
                let joints = tendon.joints.iter();
                joints
                    .map(|(joint, c)| Some((coordinate(joint)?, *c)))
                    .collect()
            }
            _ => None,
        }
    }
}
