//! Attributes and child elements of a URDF that are read; all others are reported as ignored.

use crate::io::schema::{Known, known, leaf};
use crate::io::shapes::Shapes;

pub(super) const ROBOT: Known = known(
    "name version",
    "",
    "link joint material ros2_control transmission",
);
pub(super) const CONTROL: Known = known(
    "name type rw_rate is_async",
    "",
    "hardware joint transmission",
);
pub(super) const CONTROLLED: Known = known("name", "", "command_interface state_interface param");
pub(super) const LINK: Known = known("name", "inertial", "visual collision");
pub(super) const INERTIAL: Known = known("", "origin mass inertia", "");
pub(super) const MASS: Known = leaf("value");
pub(super) const INERTIA: Known = leaf("ixx ixy ixz iyy iyz izz");
pub(super) const ORIGIN: Known = leaf("xyz rpy quat_xyzw");
pub(super) const VISUAL: Known = known("name", "origin geometry material", "");
pub(super) const COLLISION: Known = known("name", "origin geometry", "");
pub(super) const MATERIAL: Known = known("name", "color", "");
pub(super) const COLOR: Known = leaf("rgba");
pub(super) const JOINT: Known = known(
    "name type",
    "origin parent child axis limit dynamics mimic",
    "",
);
pub(super) const LINK_REFERENCE: Known = leaf("link");
pub(super) const AXIS: Known = leaf("xyz");
pub(super) const LIMIT: Known = leaf("lower upper effort velocity");
pub(super) const DYNAMICS: Known = leaf("damping friction");
pub(super) const MIMIC: Known = leaf("joint multiplier offset");

/// The shapes with their attributes.
pub(super) static SHAPES: Shapes = Shapes {
    names: known("", "", "box cylinder capsule sphere mesh"),
    shapes: &[
        ("box", leaf("size")),
        ("cylinder", leaf("radius length")),
        ("capsule", leaf("radius length")),
        ("sphere", leaf("radius")),
        ("mesh", leaf("filename scale")),
    ],
    file: "filename",
};
