//! The kinds of sensors, with names and units of their readings.

use super::scan::{self, ScanAngles};
use crate::joint::JointKind;
use crate::model::{FrameId, JointId, Model};
use crate::scalar::Scalar;
use crate::spatial::Representation;

/// A sensor of a robot. Sensors with several readings state their order.
///
/// Axes and origin of a sensor on a frame are those of the frame; links are frames.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Sensor {
    /// An encoder: the position of a joint, rad or m; of joints with several coordinates all coordinates q. A mimic joint shows its own position.
    JointPosition(JointId),
    /// The velocity of a joint, rad/s or m/s; of joints with several coordinates all coordinates v. A mimic joint shows its own velocity.
    JointVelocity(JointId),
    /// A torque sensor at the output of a joint's gear: the force that the joint transmits along its axes, N·m or N. It is the sum of motor, spring,
    /// damper, friction and limit forces, less the force that accelerates the rotor.
    JointForce(JointId),
    /// A gyroscope: the angular velocity of a frame, along its axes (3), rad/s.
    Gyro(FrameId),
    /// An accelerometer: the acceleration of the origin of a frame minus gravity, along its axes (3), m/s². At rest it reads 9.81 upward.
    Accelerometer(FrameId),
    /// A magnetometer: a field that is constant in the world, along the axes of a frame (3), in the unit of the field.
    Magnetometer {
        /// The frame.
        frame: FrameId,
        /// The field in the world, in any unit.
        field: [f64; 3],
    },
    /// The pose of a frame in the world: position (3), m, and quaternion w, x, y, z (4).
    FramePose(FrameId),
    /// The velocity of a frame (6), linear then angular, m/s and rad/s.
    FrameVelocity {
        /// The frame.
        frame: FrameId,
        /// Axes and origin.
        representation: Representation,
    },
    /// The acceleration of a frame (6), without gravity, linear then angular, m/s² and rad/s²; see
    /// [`frame_acceleration`](crate::dynamics::frame_acceleration).
    FrameAcceleration {
        /// The frame.
        frame: FrameId,
        /// Axes and origin.
        representation: Representation,
    },
    /// A force–torque sensor between the link of a frame and its parent link, connected by a joint or fixed: the force and torque on the link from
    /// its parent (6), along the axes of the frame about its origin, N and N·m. The parent of a root link is the world.
    ///
    /// Contact forces and forces on frames act on their link. Forces of tendons, couplers and joint limits act along joints. If fixed links form one
    /// body, the share of each follows from its inertia in the description.
    Wrench(FrameId),
    /// A touch sensor: the sum of the normal forces of contact on the link of a frame, N.
    Touch(FrameId),
    /// The force and torque of contact on the link of a frame (6), along the axes of the frame about its origin, N and N·m.
    ContactForce(FrameId),
    /// A range finder: the distance from the origin of a frame to the terrain, or to the nearest shape of another body, along a direction, m.
    ///
    /// It sees the shapes for collision, the surfaces and the terrain of the simulator's contacts. Of a mesh it sees the triangles of the file, from
    /// both sides, not the convex hull that contact uses. On terrain that is not a plane it searches 128 steps along the ray, so it may miss
    /// narrower ridges; below the ground it reads 0. The derivative is that at the surface it hits. Meshes and surfaces cannot be recorded in graphs.
    RangeFinder {
        /// The frame.
        frame: FrameId,
        /// Direction in the frame, of any length but zero.
        direction: [f64; 3],
        /// The largest distance, which is read where nothing is nearer, m.
        range: f64,
    },
    /// A scanning range finder: the distance of a [`RangeFinder`](Self::RangeFinder) along each of several directions, m. For each elevation, from the first
    /// to the last, it has the readings of all horizontal angles, from the first to the last.
    Lidar {
        /// The frame.
        frame: FrameId,
        /// Angles about the z axis of the frame, from its x axis.
        horizontal: ScanAngles,
        /// Elevations above the xy-plane of the frame.
        vertical: ScanAngles,
        /// The largest distance, which is read where nothing is nearer, m.
        range: f64,
    },
    /// The centre of mass of the robot in the world (3), m.
    CenterOfMass,
    /// Its velocity in the world (3), m/s.
    CenterOfMassVelocity,
    /// The momentum of the robot about its centre of mass, along the axes of the world (6): linear, kg·m/s, then angular, kg·m²/s.
    Momentum,
}

/// Names of the numbers of vectors.
const XYZ: [&str; 3] = ["x", "y", "z"];
const POSE: [&str; 7] = ["x", "y", "z", "qw", "qx", "qy", "qz"];
const MOTION: [&str; 6] = ["vx", "vy", "vz", "wx", "wy", "wz"];
const ACCELERATION: [&str; 6] = ["ax", "ay", "az", "wx", "wy", "wz"];
const WRENCH: [&str; 6] = ["fx", "fy", "fz", "nx", "ny", "nz"];
const MOMENTUM: [&str; 6] = ["px", "py", "pz", "lx", "ly", "lz"];

/// A number that is read.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Channel {
    /// Name with that of the sensor before it.
    pub(super) name: String,
    pub(super) unit: &'static str,
}

impl Sensor {
    /// The frame that it is on, if it is on one.
    pub(super) fn frame(&self) -> Option<FrameId> {
        match *self {
            Self::Gyro(frame)
            | Self::Accelerometer(frame)
            | Self::Magnetometer { frame, .. }
            | Self::FramePose(frame)
            | Self::FrameVelocity { frame, .. }
            | Self::FrameAcceleration { frame, .. }
            | Self::Wrench(frame)
            | Self::Touch(frame)
            | Self::ContactForce(frame)
            | Self::RangeFinder { frame, .. }
            | Self::Lidar { frame, .. } => Some(frame),
            _ => None,
        }
    }

    /// Names and units of its numbers.
    pub(super) fn channels<P: Scalar>(&self, name: &str, model: &Model<P>) -> Vec<Channel> {
        let each = |parts: &[&str], units: [&'static str; 2]| {
            let channel = |(k, part): (usize, &&str)| Channel {
                name: format!("{name}.{part}"),
                unit: units[usize::from(k >= 3)],
            };
            parts.iter().enumerate().map(channel).collect()
        };
        match self {
            Self::JointPosition(joint) => of_joint(name, model, *joint, POSITION),
            Self::JointVelocity(joint) => of_joint(name, model, *joint, VELOCITY),
            Self::JointForce(joint) => of_joint(name, model, *joint, FORCE),
            Self::Gyro(_) => each(&XYZ, ["rad/s"; 2]),
            Self::Accelerometer(_) => each(&XYZ, ["m/s²"; 2]),
            Self::Magnetometer { .. } => each(&XYZ, [""; 2]),
            Self::FramePose(_) => each(&POSE, ["m", ""]),
            Self::FrameVelocity { .. } => each(&MOTION, ["m/s", "rad/s"]),
            Self::FrameAcceleration { .. } => each(&ACCELERATION, ["m/s²", "rad/s²"]),
            Self::Wrench(_) | Self::ContactForce(_) => each(&WRENCH, ["N", "N·m"]),
            Self::Touch(_) => one(name, "N"),
            Self::RangeFinder { .. } => one(name, "m"),
            Self::Lidar {
                horizontal,
                vertical,
                ..
            } => numbered(name, vec!["m"; scan::count(*horizontal, *vertical)]),
            Self::CenterOfMass => each(&XYZ, ["m"; 2]),
            Self::CenterOfMassVelocity => each(&XYZ, ["m/s"; 2]),
            Self::Momentum => each(&MOMENTUM, ["kg·m/s", "kg·m²/s"]),
        }
    }
}

/// The single number of a sensor.
fn one(name: &str, unit: &'static str) -> Vec<Channel> {
    vec![Channel {
        name: name.to_owned(),
        unit,
    }]
}

/// A quantity of a joint: whether its numbers are those of q, and its units along and about an axis.
struct JointQuantity {
    is_position: bool,
    linear: &'static str,
    angular: &'static str,
}

const POSITION: JointQuantity = JointQuantity {
    is_position: true,
    linear: "m",
    angular: "rad",
};
const VELOCITY: JointQuantity = JointQuantity {
    is_position: false,
    linear: "m/s",
    angular: "rad/s",
};
const FORCE: JointQuantity = JointQuantity {
    is_position: false,
    linear: "N",
    angular: "N·m",
};

impl JointQuantity {
    /// The unit of each number of a joint.
    fn units(&self, kind: JointKind) -> Vec<&'static str> {
        let (linear, angular) = (self.linear, self.angular);
        match kind {
            JointKind::Fixed => Vec::new(),
            JointKind::Revolute | JointKind::Continuous | JointKind::Screw(_) => vec![angular],
            JointKind::Prismatic => vec![linear],
            JointKind::Universal => vec![angular; 2],
            JointKind::Planar => vec![linear, linear, angular],
            JointKind::Spherical if self.is_position => vec![""; 4],
            JointKind::Spherical => vec![angular; 3],
            JointKind::Floating if self.is_position => [[linear; 3].as_slice(), &[""; 4]].concat(),
            JointKind::Floating => [[linear; 3], [angular; 3]].concat(),
        }
    }
}

/// Names and units of a quantity of a joint: numbered where there are several.
fn of_joint<P: Scalar>(
    name: &str,
    model: &Model<P>,
    joint: JointId,
    quantity: JointQuantity,
) -> Vec<Channel> {
    let units = quantity.units(model.joints()[joint.0].kind);
    if let [unit] = units[..] {
        return one(name, unit);
    }
    numbered(name, units)
}

/// Names and units of several numbers.
fn numbered(name: &str, units: Vec<&'static str>) -> Vec<Channel> {
    let channel = |(k, unit)| Channel {
        name: format!("{name}.{k}"),
        unit,
    };
    units.into_iter().enumerate().map(channel).collect()
}
