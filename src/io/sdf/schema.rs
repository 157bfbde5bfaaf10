//! Attributes and child elements of an SDF that are read; all others are reported as ignored.

use crate::io::schema::{Known, leaf};
use crate::io::shapes::Shapes;

pub(super) const ROOT: Known = Known {
    attributes: &["version"],
    once: &[],
    repeated: &["model", "world"],
};
pub(super) const WORLD: Known = Known {
    attributes: &["name"],
    once: &["gravity"],
    repeated: &["model", "include", "frame", "joint"],
};
pub(super) const MODEL: Known = Known {
    attributes: &["name", "canonical_link", "placement_frame"],
    once: &["pose", "static"],
    repeated: &["link", "joint", "frame", "model", "include"],
};
pub(super) const INCLUDE: Known = Known {
    attributes: &["merge", "placement_frame"],
    once: &["uri", "name", "pose", "static", "placement_frame"],
    repeated: &[],
};
pub(super) const FRAME: Known = Known {
    attributes: &["name", "attached_to"],
    once: &["pose"],
    repeated: &[],
};
pub(super) const LINK: Known = Known {
    attributes: &["name"],
    once: &["pose", "inertial"],
    repeated: &["visual", "collision"],
};
pub(super) const INERTIAL: Known = Known {
    attributes: &["auto"],
    once: &["pose", "mass", "inertia"],
    repeated: &[],
};
/// An inertia that is computed from the collisions.
pub(super) const AUTO_INERTIAL: Known = Known {
    attributes: &["auto"],
    once: &["density"],
    repeated: &[],
};
pub(super) const INERTIA: Known = Known {
    attributes: &[],
    once: &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"],
    repeated: &[],
};
pub(super) const VISUAL: Known = Known {
    attributes: &["name"],
    once: &["pose", "geometry", "material"],
    repeated: &[],
};
pub(super) const COLLISION: Known = Known {
    attributes: &["name"],
    once: &["pose", "geometry", "density"],
    repeated: &[],
};
pub(super) const MATERIAL: Known = Known {
    attributes: &[],
    once: &["diffuse"],
    repeated: &[],
};
const fn children(once: &'static [&'static str]) -> Known {
    Known { once, ..leaf(&[]) }
}

pub(super) static SHAPES: Shapes = Shapes {
    shapes: [
        ("box", children(&["size"])),
        ("cylinder", children(&["radius", "length"])),
        ("capsule", children(&["radius", "length"])),
        ("sphere", children(&["radius"])),
        ("mesh", children(&["uri", "scale"])),
    ],
    file: "uri",
};
pub(super) const JOINT: Known = Known {
    attributes: &["name", "type"],
    once: &[
        "pose",
        "parent",
        "child",
        "axis",
        "axis2",
        "screw_thread_pitch",
        "thread_pitch",
    ],
    repeated: &[],
};
pub(super) const AXIS: Known = children(&["xyz", "limit", "dynamics", "mimic"]);
pub(super) const OLD_AXIS: Known =
    children(&["xyz", "use_parent_model_frame", "limit", "dynamics"]);
pub(super) const LIMIT: Known = children(&["lower", "upper", "effort", "velocity"]);
pub(super) const DYNAMICS: Known = children(&[
    "damping",
    "friction",
    "spring_stiffness",
    "spring_reference",
]);
pub(super) const MIMIC: Known = Known {
    attributes: &["joint", "axis"],
    once: &["multiplier", "offset", "reference"],
    repeated: &[],
};
