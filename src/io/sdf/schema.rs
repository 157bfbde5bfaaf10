//! Attributes and child elements of an SDF that are read; all others are reported as ignored.

use crate::io::schema::{Known, known};
use crate::io::shapes::Shapes;

pub(super) const ROOT: Known = known("version", "", "model world");
pub(super) const WORLD: Known = known(
    "name",
    "gravity magnetic_field",
    "model include frame joint",
);
pub(super) const MODEL: Known = known(
    "name canonical_link placement_frame",
    "pose static",
    "link joint frame model include",
);
pub(super) const INCLUDE: Known = known(
    "merge placement_frame",
    "uri name pose static placement_frame",
    "",
);
pub(super) const FRAME: Known = known("name attached_to", "pose", "");
pub(super) const LINK: Known = known("name", "pose inertial gravity", "visual collision sensor");
pub(super) const INERTIAL: Known = known("auto", "pose mass inertia", "");
/// An inertia that is computed from the collisions.
pub(super) const AUTO_INERTIAL: Known = known("auto", "density", "");
pub(super) const INERTIA: Known = children("ixx ixy ixz iyy iyz izz");
pub(super) const VISUAL: Known = known("name", "pose geometry material", "");
pub(super) const COLLISION: Known = known("name", "pose geometry density surface", "");
pub(super) const SURFACE: Known = children("contact");
pub(super) const SURFACE_CONTACT: Known = children("collide_bitmask");
pub(super) const MATERIAL: Known = known("", "diffuse", "");
const fn children(once: &'static str) -> Known {
    known("", once, "")
}

pub(super) static SHAPES: Shapes = Shapes {
    names: known("", "", "box cylinder capsule sphere ellipsoid mesh"),
    shapes: &[
        ("box", children("size")),
        ("cylinder", children("radius length")),
        ("capsule", children("radius length")),
        ("sphere", children("radius")),
        ("ellipsoid", children("radii")),
        ("mesh", children("uri scale")),
    ],
    file: "uri",
};
pub(super) const JOINT: Known = known(
    "name type",
    "pose parent child axis axis2 screw_thread_pitch thread_pitch",
    "sensor",
);
pub(super) const AXIS: Known = children("xyz limit dynamics mimic");
pub(super) const OLD_AXIS: Known = children("xyz use_parent_model_frame limit dynamics");
pub(super) const LIMIT: Known = children("lower upper effort velocity");
pub(super) const DYNAMICS: Known = children("damping friction spring_stiffness spring_reference");
pub(super) const MIMIC: Known = known("joint axis", "multiplier offset reference", "");
