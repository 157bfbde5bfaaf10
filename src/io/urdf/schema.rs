//! Attributes and child elements of a URDF that are read; all others are reported as ignored.

use crate::io::schema::{Known, leaf};
use crate::io::shapes::Shapes;

pub(super) const ROBOT: Known = Known {
    attributes: &["name", "version"],
    once: &[],
    repeated: &["link", "joint", "material"],
};
pub(super) const LINK: Known = Known {
    attributes: &["name"],
    once: &["inertial"],
    repeated: &["visual", "collision"],
};
pub(super) const INERTIAL: Known = Known {
    attributes: &[],
    once: &["origin", "mass", "inertia"],
    repeated: &[],
};
pub(super) const MASS: Known = leaf(&["value"]);
pub(super) const INERTIA: Known = leaf(&["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]);
pub(super) const ORIGIN: Known = leaf(&["xyz", "rpy", "quat_xyzw"]);
pub(super) const VISUAL: Known = Known {
    attributes: &["name"],
    once: &["origin", "geometry", "material"],
    repeated: &[],
};
pub(super) const COLLISION: Known = Known {
    attributes: &["name"],
    once: &["origin", "geometry"],
    repeated: &[],
};
pub(super) const MATERIAL: Known = Known {
    attributes: &["name"],
    once: &["color"],
    repeated: &[],
};
pub(super) const COLOR: Known = leaf(&["rgba"]);
pub(super) const JOINT: Known = Known {
    attributes: &["name", "type"],
    once: &[
        "origin", "parent", "child", "axis", "limit", "dynamics", "mimic",
    ],
    repeated: &[],
};
pub(super) const LINK_REFERENCE: Known = leaf(&["link"]);
pub(super) const AXIS: Known = leaf(&["xyz"]);
pub(super) const LIMIT: Known = leaf(&["lower", "upper", "effort", "velocity"]);
pub(super) const DYNAMICS: Known = leaf(&["damping", "friction"]);
pub(super) const MIMIC: Known = leaf(&["joint", "multiplier", "offset"]);

/// The shapes with their attributes.
pub(super) static SHAPES: Shapes = Shapes {
    shapes: [
        ("box", leaf(&["size"])),
        ("cylinder", leaf(&["radius", "length"])),
        ("capsule", leaf(&["radius", "length"])),
        ("sphere", leaf(&["radius"])),
        ("mesh", leaf(&["filename", "scale"])),
    ],
    file: "filename",
};
