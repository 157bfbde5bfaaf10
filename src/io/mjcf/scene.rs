//! Content of an MJCF that a model cannot hold.

use std::collections::HashSet;

use nalgebra::DVector;

use crate::constraint::Constraint;
use crate::io::names::Names;
use crate::model::Model;
use crate::sim::{Activation, Integrator, Sensor, SensorNoise, Sensors, Servo, State};
use crate::spatial::Transform;

/// Everything that an MJCF holds and this library can use.
///
/// What it does not use is in the [`ImportReport`](super::super::ImportReport). Made by
/// [`ModelOptions::load_mjcf_scene_file`](super::super::ModelOptions::load_mjcf_scene_file).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MjcfScene {
    /// Bodies, joints, frames, shapes, gravity.
    pub model: Model,
    /// The configuration in which the file has its bodies, `qpos0`, at rest: references of hinges and slides, poses of free bodies.
    pub reference: State,
    /// Actuators, in the order of the file; [`inputs`](Self::inputs) has the order of the simulator's.
    pub actuation: Vec<MjcfActuator>,
    /// Geoms that touch, the ground, and which pairs of bodies touch or do not.
    pub contacts: MjcfContacts,
    /// Equalities that are active, as rigid constraints.
    pub constraints: Vec<Constraint>,
    /// Fixed tendons, in the order of the file.
    pub tendons: Vec<MjcfTendon>,
    /// Sensors, in the order of the file; [`known_sensors`](Self::known_sensors) reads those that are modelled.
    pub sensors: Vec<MjcfSensor>,
    /// Named states.
    pub keyframes: Vec<MjcfKeyframe>,
    /// Time step and method.
    pub options: MjcfOptions,
}

/// An actuator.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MjcfActuator {
    /// Its name; empty where it has none.
    pub name: String,
    /// Its element: `motor`, `position`, `general`, ….
    pub kind: String,
    /// What it acts on.
    pub transmission: MjcfTransmission,
    /// Its force along what it acts on, gear and ranges included; `None` where that is not modelled. The control is the servo's input.
    pub servo: Option<Servo>,
    /// Delay and dynamics of the control, where it has any that are modelled: what comes out of them is the servo's input.
    pub activation: Option<Activation>,
}

/// What an actuator acts on.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MjcfTransmission {
    /// A joint, by name.
    Joint(String),
    /// A site, by name, with force (N) and moment (N·m) in its axes per unit of the motor's force.
    Site(String, [f64; 6]),
    /// A tendon, by name.
    Tendon(String),
    /// Anything else, by name.
    Other(String),
}

/// Numbers of contact of an MJCF.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MjcfContacts {
    /// Pose in the world of the first plane that stands still: its z axis is the normal.
    pub ground: Option<(Transform<f64>, MjcfGeom)>,
    /// Geoms that touch something, in the order of the bodies of the file.
    pub geoms: Vec<MjcfGeom>,
    /// Pairs of bodies that do not touch: those of the file, and bodies that several joints connect.
    pub excluded: Vec<[String; 2]>,
    /// Pairs of geoms that touch whatever their types are, by name.
    pub pairs: Vec<[String; 2]>,
}

/// Numbers of contact of a geom, as `MuJoCo` calls them.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MjcfGeom {
    /// Its name, where it has one.
    pub name: Option<String>,
    /// The link that it stands on.
    pub link: String,
    /// Coefficients of sliding, of torsion (m) and of rolling (m).
    pub friction: [f64; 3],
    /// Dimensions of the contact force: 1 has no friction.
    pub condim: u8,
    /// The geom of higher priority decides the numbers of a pair.
    pub priority: i32,
    /// Bits that must meet those of the other's `conaffinity`.
    pub contype: u32,
    /// Bits that must meet those of the other's `contype`.
    pub conaffinity: u32,
    /// Time constant (s) and damping ratio; or, negative, stiffness and damping.
    pub solref: [f64; 2],
    /// Impedance: least, largest, width (m), midpoint, power.
    pub solimp: [f64; 5],
    /// Distance from which on contacts are found, m.
    pub margin: f64,
    /// Part of the margin in which there is no force, m.
    pub gap: f64,
    /// Weight in the mean of solref and solimp.
    pub solmix: f64,
}

impl MjcfGeom {
    /// Whether two geoms touch by their types.
    pub fn touches(&self, other: &Self) -> bool {
        self.contype & other.conaffinity != 0 || other.contype & self.conaffinity != 0
    }
}

/// A fixed tendon: its length is Σ cᵢ qᵢ.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MjcfTendon {
    /// Its name; empty where it has none.
    pub name: String,
    /// Joints with their coefficients.
    pub joints: Vec<(String, f64)>,
}

/// A sensor.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MjcfSensor {
    /// Its name; empty where it has none.
    pub name: String,
    /// Its element, such as `framepos`.
    pub kind: String,
    /// Name of the object that it measures at; empty where it names none.
    pub object: String,
    /// The sensor here, which may read more numbers: position and orientation together, force and torque, linear and angular. `None` for what is not modelled.
    pub sensor: Option<Sensor>,
    /// Deviation of its noise, limit, period and delay.
    pub noise: SensorNoise,
}

impl MjcfScene {
    /// The sensors that are modelled, by name: of those without one by kind and place in the file, as `gyro 3`. Noise is not in them:
    /// [`MjcfSensor::noise`] is for [`NoisySensors`](crate::sim::NoisySensors).
    ///
    /// # Examples
    /// ```
    /// use dualbody::ModelOptions;
    ///
    /// let xml = r#"<mujoco><worldbody><body><joint name="j"/><geom size="0.1"/><site name="imu"/></body></worldbody>
    ///   <sensor><jointpos name="encoder" joint="j"/><gyro site="imu"/></sensor></mujoco>"#;
    /// let (scene, _) = ModelOptions::default().load_mjcf_scene_str(xml)?;
    /// assert_eq!(scene.known_sensors().names(), ["encoder", "gyro 1.x", "gyro 1.y", "gyro 1.z"]);
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn known_sensors(&self) -> Sensors {
        let named = self.sensors.iter().map(|own| own.name.as_str());
        let mut names = Names::of(named.filter(|name| !name.is_empty()));
        let mut taken = HashSet::new();
        let own = self.sensors.iter().enumerate().filter_map(|(k, own)| {
            let sensor = own.sensor?;
            let name = match !own.name.is_empty() && taken.insert(own.name.as_str()) {
                true => own.name.clone(),
                false => names.fresh(format!("{} {k}", own.kind)),
            };
            Some((name, sensor))
        });
        Sensors::new(&self.model, own)
    }
}

/// A named state.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MjcfKeyframe {
    /// Its name; empty where it has none.
    pub name: String,
    /// Time, s.
    pub time: f64,
    /// Configuration, velocity, and activations of actuators that are modelled; inputs that are delayed are 0.
    pub state: State,
    /// Controls, an entry for each actuator; empty where none are given.
    pub control: DVector<f64>,
}

/// Settings of the simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MjcfOptions {
    /// s.
    pub time_step: f64,
    /// The method here that is nearest to that of the file.
    pub integrator: Integrator,
    /// Whether friction cones are elliptic, as here, not pyramids.
    pub has_elliptic_cones: bool,
    /// Ratio of the impedances of friction and of normal force.
    pub impratio: f64,
}
