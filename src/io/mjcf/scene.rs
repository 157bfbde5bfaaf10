//! Content of an MJCF file that a model cannot contain.

use nalgebra::DVector;

use super::scenery::Scenery;
use crate::constraint::Constraint;
use crate::contact::HeightField;
use crate::io::sensors::{self, ImportedSensor};
use crate::model::Model;
use crate::sim::{Activation, Integrator, Sensors, Servo, Sleeping, State};
use crate::spatial::Transform;

/// The supported content of an MJCF file.
///
/// The [`ImportReport`](super::super::ImportReport) lists other content. Made by
/// [`ModelOptions::load_mjcf_scene_file`](super::super::ModelOptions::load_mjcf_scene_file).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MjcfScene {
    /// Bodies, joints, frames, shapes, gravity.
    pub model: Model,
    /// The configuration `qpos0` at rest: references of hinges and slides, poses of free bodies.
    pub reference: State,
    /// Actuators, in the order of the file; [`inputs`](Self::inputs) converts controls to the order of the simulator.
    pub actuation: Vec<MjcfActuator>,
    /// Geoms with contact, the ground, and pairs of bodies with or without contact; none if a flag disables contact.
    pub contacts: MjcfContacts,
    /// Active equalities, as regularised constraints, then springs and dampers of fixed tendons.
    pub constraints: Vec<Constraint>,
    /// Fixed tendons, in the order of the file.
    pub tendons: Vec<MjcfTendon>,
    /// Sensors, in the order of the file; [`known_sensors`](Self::known_sensors) returns those that are modelled.
    pub sensors: Vec<ImportedSensor>,
    /// Named states.
    pub keyframes: Vec<MjcfKeyframe>,
    /// Time step and integrator.
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
    /// The joint, site or tendon on which it acts.
    pub transmission: MjcfTransmission,
    /// Its force, with gear and ranges; `None` if it is not modelled. The control is the input of the servo.
    pub servo: Option<Servo>,
    /// Delay and dynamics of the control, where it has any that are modelled: what comes out of them is the servo's input.
    pub activation: Option<Activation>,
}

/// Transmission of an actuator.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MjcfTransmission {
    /// A joint, by name.
    Joint(String),
    /// A site, by name, with force (N) and moment (N·m) in its axes per unit of the motor's force.
    Site(String, [f64; 6]),
    /// A site as seen from another one (`refsite`), with force (N) and moment (N·m) in the axes of the latter per unit of the motor's force. It is
    /// modelled if the reference is fixed to the world.
    SiteFrom {
        /// The site, by name.
        site: String,
        /// The reference, by name.
        reference: String,
        /// Force and moment per unit.
        gear: [f64; 6],
    },
    /// A tendon, by name.
    Tendon(String),
    /// Another element, by name.
    Other(String),
}

/// Contact parameters of an MJCF file.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MjcfContacts {
    /// Pose of the first plane that faces upwards or level height field of the world: the z axis of a plane is the normal.
    pub ground: Option<(Transform<f64>, MjcfGeom)>,
    /// Its heights over the world, if it is a height field. Between the points they follow a smooth surface, and beyond the border they continue, see
    /// [`HeightField`]; those of `MuJoCo` are triangles, and end there.
    pub heights: Option<HeightField>,
    /// Geoms with contact, in the order of the bodies of the file; at the end those of other planes and height fields of the world.
    pub geoms: Vec<MjcfGeom>,
    /// The shapes of these last geoms.
    pub(crate) scenery: Vec<Scenery>,
    /// Whether bodies touch that joints connect: the flag `filterparent` is off. Otherwise only those touch of which one is fixed to the world.
    pub neighbours_touch: bool,
    /// Pairs of bodies without contact: those of the file, and bodies connected by several joints.
    pub excluded: Vec<[String; 2]>,
    /// Pairs of geoms with contact independent of their types.
    pub pairs: Vec<MjcfPair>,
}

/// A pair of geoms with its own contact parameters, with their `MuJoCo` names.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MjcfPair {
    /// Both geoms, by name.
    pub geoms: [String; 2],
    /// Friction coefficients: sliding along both tangents, torsion (m), rolling about both tangents (m). Simulators use the first one of each kind.
    pub friction: [f64; 5],
    /// Dimension of the contact force: see [`MjcfGeom::condim`].
    pub condim: u8,
    /// Time constant (s) and damping ratio; or, negative, stiffness and damping.
    pub solref: [f64; 2],
    /// Impedance: least, largest, width (m), midpoint, power.
    pub solimp: [f64; 5],
    /// Distance at which contact begins, m.
    pub margin: f64,
    /// Distance beyond the margin within which `MuJoCo` lists contacts without force, m: without effect on the motion.
    pub gap: f64,
}

/// Contact parameters of a geom, with their `MuJoCo` names.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MjcfGeom {
    /// Its name, where it has one.
    pub name: Option<String>,
    /// Its link.
    pub link: String,
    /// Friction coefficients: sliding, torsion (m), rolling (m).
    pub friction: [f64; 3],
    /// Dimension of the contact force: 1 is without friction, 4 adds torsional and 6 rolling friction.
    pub condim: u8,
    /// The geom of higher priority determines the parameters of a pair.
    pub priority: i32,
    /// Bit mask that is compared with `conaffinity` of the other geom.
    pub contype: u32,
    /// Bit mask that is compared with `contype` of the other geom.
    pub conaffinity: u32,
    /// Time constant (s) and damping ratio; or, negative, stiffness and damping.
    pub solref: [f64; 2],
    /// Impedance: least, largest, width (m), midpoint, power.
    pub solimp: [f64; 5],
    /// Its part of the distance at which contact begins, m: of two geoms both count together.
    pub margin: f64,
    /// Its part of the distance beyond the margin within which `MuJoCo` lists contacts without force, m: without effect on the motion.
    pub gap: f64,
    /// Weight in the mean of solref and solimp.
    pub solmix: f64,
}

impl MjcfGeom {
    /// Whether two geoms touch by their types.
    pub(crate) fn touches(&self, other: &Self) -> bool {
        self.contype & other.conaffinity != 0 || other.contype & self.conaffinity != 0
    }
}

/// A fixed tendon: its length is Σ cᵢ qᵢ.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MjcfTendon {
    /// Its name; empty without.
    pub name: String,
    /// Joints with their coefficients.
    pub joints: Vec<(String, f64)>,
}

impl MjcfScene {
    /// Returns the modelled sensors, by name; sensors without a name are called by kind and index in the file, as in `gyro 3`. Noise is not included:
    /// use [`ImportedSensor::noise`] with [`NoisySensors`](crate::sim::NoisySensors).
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
        sensors::known(&self.sensors, &self.model)
    }
}

/// A named state.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MjcfKeyframe {
    /// Its name; empty without.
    pub name: String,
    /// Time, s.
    pub time: f64,
    /// Configuration, velocity, and activations of actuators that are modelled; inputs that are delayed are 0.
    pub state: State,
    /// Controls, one entry per actuator; empty if not given.
    pub control: DVector<f64>,
}

/// Settings of the simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MjcfOptions {
    /// s.
    pub time_step: f64,
    /// The integrator nearest to that of the file.
    pub integrator: Integrator,
    /// Whether friction cones are elliptic, as in this library, not pyramidal.
    pub has_elliptic_cones: bool,
    /// Ratio of frictional to normal impedance.
    pub impratio: f64,
    /// When resting islands sleep, if the file enables it: ten steps at rest, as there. Rates of rotation there count by the sizes of bodies.
    pub sleeping: Option<Sleeping>,
}
