//! Parts of a model.

use std::path::PathBuf;

use nalgebra::Vector3;

use super::{BodyId, FrameId, JointId, UpAxis};
use crate::joint::JointKind;
use crate::numbers::numbers;
use crate::spatial::Transform;

/// Limits of a joint; `None` for unlimited.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Least position, rad or m.
    pub lower: Option<f64>,
    /// Largest position, rad or m.
    pub upper: Option<f64>,
    /// Largest speed, rad/s or m/s.
    pub velocity: Option<f64>,
    /// Largest effort of the actuator, N·m or N.
    pub effort: Option<f64>,
}

/// A spring along one velocity coordinate: τ = −stiffness (q − rest).
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Spring<P> {
    /// N·m/rad or N/m; zero means no spring.
    pub stiffness: P,
    /// Position without force, rad or m.
    pub rest: P,
}

numbers! { struct Spring {
    stiffness: NotNegative("stiffness", "spring stiffness"),
    rest: Finite("rest", "rest position of a spring"),
} }

/// Coupling of a mimic joint: q = multiplier · `q_leader` + offset.
#[derive(Clone, Debug, PartialEq)]
pub struct Mimic {
    /// Name of the leader.
    pub leader: String,
    /// Ratio of the rates.
    pub multiplier: f64,
    /// Position at the leader's zero, rad or m.
    pub offset: f64,
}

/// The second axis of a universal joint, with limits and forces as [`JointSpec`](super::JointSpec) has for the first.
#[derive(Clone, Debug, PartialEq)]
pub struct SecondAxis {
    /// The axis in the joint frame with the joint at zero; it rotates with the first axis. Not parallel to the first.
    pub axis: Vector3<f64>,
    /// Position, velocity and effort limits.
    pub limits: Limits,
    /// Viscous damping, N·m·s/rad.
    pub damping: f64,
    /// Coulomb friction, N·m.
    pub friction: f64,
    /// Reflected rotor inertia, kg·m².
    pub armature: f64,
    /// The spring along it.
    pub spring: Spring<f64>,
}

impl SecondAxis {
    /// Makes an axis of any length except zero, without limits and forces.
    pub fn about(axis: [f64; 3]) -> Self {
        Self {
            axis: axis.into(),
            limits: Limits::default(),
            damping: 0.0,
            friction: 0.0,
            armature: 0.0,
            spring: Spring::default(),
        }
    }
}

/// A named joint, with the properties that do not enter the equations of motion of a free mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name of the joint in the description.
    pub name: String,
    /// The body that it moves; of a universal joint, the outer one of two.
    pub body: BodyId,
    /// Kind of the joint.
    pub kind: JointKind,
    /// The axis (or the plane's normal) in the frame of the child link, a unit vector.
    pub axis: Vector3<f64>,
    /// Position, velocity and effort limits; of a universal joint, those of its first axis.
    pub limits: Limits,
    /// Coulomb friction, N·m or N; of a universal joint, that of its first axis.
    pub friction: f64,
    /// The second axis of a universal joint, as in the description but of unit length.
    pub second: Option<SecondAxis>,
    /// Leader of a mimic joint in the description.
    pub mimic: Option<Mimic>,
    /// Whether it has no input by default, see [`JointSpec::passive`](super::JointSpec::passive).
    pub is_passive: bool,
}

impl Joint {
    /// Numbers of its bodies.
    pub(crate) fn bodies(&self) -> std::ops::Range<usize> {
        let end = self.body.0 + 1;
        end - self.kind.n_bodies()..end
    }
}

/// A body with its part of a named joint: all of it, or one axis of a universal joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointPart<'a> {
    pub(crate) id: JointId,
    pub(crate) body: BodyId,
    pub(crate) limits: &'a Limits,
    pub(crate) friction: f64,
}

/// A named pose on a body, or on the world; each link is also a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame<P> {
    /// Name of the frame; links and frames share one name space.
    pub name: String,
    /// The body that carries it; `None` is the world.
    pub body: Option<BodyId>,
    /// Pose `X_BF` in the body frame (or the world).
    pub placement: Transform<P>,
}

numbers! { struct Frame { name: kept(), body: kept(), placement: part(Transform) } }

/// A link of the description. Several links can make up one body.
///
/// Its inertia is a part of that of its body, which may have been changed since; [`Model::to_builder`](super::Model::to_builder) returns the inertia
/// of each link.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Frame of the link, which has the name of the link.
    pub frame: FrameId,
    /// Visual shapes, to show.
    pub visuals: Vec<Visual>,
    /// Collision shapes, to touch.
    pub collisions: Vec<Collision>,
    /// A bitmask of each collision shape, in their order, all bits where there is none: two shapes collide where these have a bit in common.
    pub collide_bitmasks: Vec<u16>,
}

/// A shape in its own frame, centred at the origin; lengths along z, in m.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Geometry {
    /// A box with edges along the axes.
    Box {
        /// Full edge lengths.
        size: [f64; 3],
    },
    /// A cylinder about z.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Full length.
        length: f64,
    },
    /// A cylinder about z with hemispheres at its ends.
    Capsule {
        /// Radius.
        radius: f64,
        /// Length of the cylinder, without the half spheres.
        length: f64,
    },
    /// A sphere.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// An ellipsoid along the axes.
    Ellipsoid {
        /// Full lengths along the axes.
        size: [f64; 3],
    },
    /// A mesh from a file.
    Mesh {
        /// The reference as written in the description. One that begins with `data:model/obj` contains the mesh, as the text of an OBJ file after a
        /// comma [RFC 2397]; so are vertices in an MJCF file.
        uri: String,
        /// The file, where there is one and it was found.
        path: Option<PathBuf>,
        /// Scale along the axes.
        scale: [f64; 3],
        /// Treatment of the up axis that the file states.
        up_axis: UpAxis,
    },
}

/// A reference to a mesh for messages: without the content of a `data:` reference.
pub(crate) fn short_reference(uri: &str) -> &str {
    match (uri.starts_with("data:"), uri.split_once(',')) {
        (true, Some((kind, _))) => kind,
        _ => uri,
    }
}

/// A visual shape of a link, without effect on the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Visual {
    /// Name of the shape, where it has one.
    pub name: Option<String>,
    /// Pose in the frame of the link.
    pub placement: Transform<f64>,
    /// The shape.
    pub geometry: Geometry,
    /// Red, green, blue, opacity in 0..1.
    pub color: Option<[f64; 4]>,
}

/// A collision shape of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
    /// Name of the shape, where it has one.
    pub name: Option<String>,
    /// Pose in the frame of the link.
    pub placement: Transform<f64>,
    /// The shape.
    pub geometry: Geometry,
}

/// Base of a robot, fixed in the world or floating.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Base {
    /// Fixed if the root link is called `world`, otherwise floating.
    #[default]
    Auto,
    /// The root link does not move.
    Fixed,
    /// The root link moves freely. If it is called `world`, the robot must be connected to it by one fixed joint: the frame of the floating base is
    /// then that of the link `world`, which moves with the robot, and the placement of this joint remains.
    Floating,
}
