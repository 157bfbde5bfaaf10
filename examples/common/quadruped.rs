//! The quadruped on position servos that several examples push.

use std::error::Error;

use dualbody::constraint::Anchor;
use dualbody::contact::{ContactLaw, RelaxedRigid, Terrain};
use dualbody::sim::{Actuation, Actuator, FrameActuator, Servo};
use dualbody::spatial::Representation;
use dualbody::{Contacts, Model, Simulator};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/quadruped.urdf");
const FEET: [&str; 4] = ["FR_foot", "FL_foot", "RR_foot", "RL_foot"];

/// A position servo in each joint, regularised ground under the feet, and a hand at the trunk.
///
/// * `gains` – stiffness and damping of the servos, N·m/rad and N·m·s/rad
/// * `time_step` – s
pub(crate) fn on_servos(gains: [f64; 2], time_step: f64) -> Result<Simulator, Box<dyn Error>> {
    let model = Model::from_urdf_file(FILE)?;
    let mut actuation = Actuation::from_model(&model);
    for joint in model.joint_names() {
        let own = actuation.actuators()[model.joint_v(model.find_joint(joint)?).start];
        let servo = Some(Servo::position(gains[0], gains[1]));
        actuation = actuation.with_actuator(&model, joint, Actuator { servo, ..own })?;
    }
    let law = ContactLaw::RelaxedRigid(RelaxedRigid {
        friction: 0.8,
        ..RelaxedRigid::default()
    });
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law).with_links(&model, &FEET)?;
    let trunk = Anchor::frame(&model, "trunk")?;
    let hand = FrameActuator::wrench("hand", trunk, Representation::Mixed);
    Ok(Simulator::new(model)
        .with_time_step(time_step)
        .with_actuation(actuation)
        .with_contacts(contacts)
        .with_frame_actuators(hand.to_vec()))
}
