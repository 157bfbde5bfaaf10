//! A robot that `urdf-rs` has read, or a program put together: its parts, what of it is not used, and what its zeros
//! mean.

use urdf_rs::{Joint, JointLimit, JointType, Link, Robot};

use super::joint::{DEFAULT_AXIS, DOES_NOT_MOVE, NO_LIMIT, check_limits};
use super::parts::{JointPart, LinkPart, Material, Parts};
use super::{inertia_of, pose};
use crate::io::context::Context;
use crate::io::mesh_path::MeshFinder;
use crate::io::motion::{Axis, check_friction, is_bounded};
use crate::io::place::Place;
use crate::io::shapes::check_shape;
use crate::joint::JointKind;
use crate::model::{Collision, Geometry, JointSpec, Limits, Mimic};
use crate::scalar::MapEach;
use crate::spatial::Transform;

/// Takes over the parts of a robot.
pub(super) fn read<'a>(
    context: &mut Context<'_>,
    robot: &'a Robot,
    meshes: &mut MeshFinder,
) -> Parts<'a> {
    let name = Some(&*robot.name).filter(|name| !name.is_empty());
    let place = Place::Part("robot", name.unwrap_or("robot"));
    let mut parts = Parts::new(context, place, name);
    let joints = robot.joints.iter().map(|own| joint(context, own));
    parts.joints = joints.collect();
    let links = robot.links.iter().map(|own| link(context, own, meshes));
    parts.links = links.collect();
    let materials = robot.materials.iter();
    let materials =
        materials.map(|own| read_material(context, Place::Part("robot", &robot.name), own));
    parts.materials = materials.collect();
    parts
}

fn link<'a>(context: &mut Context<'_>, link: &'a Link, meshes: &mut MeshFinder) -> LinkPart<'a> {
    let at = |path| Place::Part(path, &link.name);
    let (mass, i) = (link.inertial.mass.value, &link.inertial.inertia);
    let entries = [i.ixx, i.ixy, i.ixz, i.iyy, i.iyz, i.izz];
    let inertia = inertia_of(mass, entries, &transform(&link.inertial.origin));
    let mut out = LinkPart::new(context, at("robot/link/inertial"), &link.name, inertia);
    for own in &link.visual {
        let place = at("robot/link/visual/material");
        let material = own.material.as_ref();
        let material = material.map(|material| read_material(context, place, material));
        let places = ["robot/link/visual/geometry", "robot/link/visual"].map_each(at);
        let geometry = geometry(context, &own.geometry, places, meshes);
        let visual = shape(own.name.as_ref(), &own.origin, geometry);
        out.visuals.push((visual, material));
    }
    for own in &link.collision {
        let places = ["robot/link/collision/geometry", "robot/link/collision"].map_each(at);
        let geometry = geometry(context, &own.geometry, places, meshes);
        let collision = shape(own.name.as_ref(), &own.origin, geometry);
        out.collisions.push(collision);
    }
    out
}

fn shape(name: Option<&String>, origin: &urdf_rs::Pose, geometry: Geometry) -> Collision {
    Collision {
        name: name.cloned(),
        placement: transform(origin),
        geometry,
    }
}

fn transform(of: &urdf_rs::Pose) -> Transform<f64> {
    pose(of.xyz.0, of.rpy.0)
}

fn geometry(
    context: &mut Context<'_>,
    shape: &urdf_rs::Geometry,
    places: [Place<'_>; 2],
    meshes: &mut MeshFinder,
) -> Geometry {
    let geometry = match *shape {
        urdf_rs::Geometry::Box { size } => Geometry::Box { size: size.0 },
        urdf_rs::Geometry::Cylinder { radius, length } => Geometry::Cylinder { radius, length },
        urdf_rs::Geometry::Capsule { radius, length } => Geometry::Capsule { radius, length },
        urdf_rs::Geometry::Sphere { radius } => Geometry::Sphere { radius },
        urdf_rs::Geometry::Mesh {
            ref filename,
            scale,
        } => meshes.geometry(filename, scale.map(|scale| scale.0)),
    };
    check_shape(context, &geometry, meshes, places);
    geometry
}

/// A colour that is none costs the colour, not the robot.
fn read_material<'a>(
    context: &mut Context<'_>,
    place: Place<'a>,
    material: &'a urdf_rs::Material,
) -> Material<'a> {
    let name = &*material.name;
    let given = material.color.as_ref().map(|color| color.rgba.0);
    let color = given.filter(|rgba| rgba.iter().all(|x| x.is_finite()));
    if color != given {
        let reason = format!("no colour: that of the material \"{name}\" is not finite");
        context.warn(place, reason);
    }
    if material.texture.is_some() {
        context.ignore(place, "textures are not shown");
    }
    Material {
        place,
        name,
        color,
        is_reference: material.texture.is_none(),
    }
}

fn joint<'a>(context: &mut Context<'_>, joint: &'a Joint) -> JointPart<'a> {
    let (name, at) = (&*joint.name, |path| Place::Part(path, &joint.name));
    let kind = kind(&joint.joint_type);
    report_unused(context, joint, kind);
    let mut spec = JointSpec::new(name, kind, &joint.parent.link, &joint.child.link)
        .with_placement(transform(&joint.origin));
    let mut mimic = None;
    if kind != JointKind::Fixed {
        spec = spec.along(axis(context, joint, kind));
        mimic = joint.mimic.as_ref().map(|mimic| {
            let mimic = Mimic {
                leader: mimic.joint.clone(),
                multiplier: mimic.multiplier.unwrap_or(1.0),
                offset: mimic.offset.unwrap_or_default(),
            };
            (at("robot/joint/mimic"), mimic)
        });
    }
    JointPart {
        name,
        place: at("robot/joint"),
        spec,
        mimic,
    }
}

fn kind(of: &JointType) -> JointKind {
    match of {
        JointType::Revolute => JointKind::Revolute,
        JointType::Continuous => JointKind::Continuous,
        JointType::Prismatic => JointKind::Prismatic,
        JointType::Fixed => JointKind::Fixed,
        JointType::Floating => JointKind::Floating,
        JointType::Planar => JointKind::Planar,
        JointType::Spherical => JointKind::Spherical,
    }
}

fn axis(context: &mut Context<'_>, joint: &Joint, kind: JointKind) -> Axis {
    let direction = if kind.has_axis() {
        joint.axis.xyz.0
    } else {
        DEFAULT_AXIS
    };
    let mut axis = Axis::about(direction);
    axis.limits = limits(context, joint, kind);
    if let Some(dynamics) = &joint.dynamics {
        (axis.damping, axis.friction) = (dynamics.damping, dynamics.friction);
        let place = Place::Part("robot/joint/dynamics", &joint.name);
        check_friction(context, place, axis.friction);
    }
    axis
}

/// Limits whose numbers are all zero, as `urdf-rs` fills in where there are none, are none, as infinite ones are.
fn limits(context: &mut Context<'_>, joint: &Joint, kind: JointKind) -> Limits {
    if joint.limit == JointLimit::default() {
        if is_bounded(kind) {
            context.warn(Place::Part("robot/joint", &joint.name), NO_LIMIT);
        }
        return Limits::default();
    }
    let limit = &joint.limit;
    let below = |x: f64, no_limit: f64| (x != no_limit).then_some(x);
    let limits = Limits {
        lower: below(limit.lower, f64::NEG_INFINITY).filter(|_| is_bounded(kind)),
        upper: below(limit.upper, f64::INFINITY).filter(|_| is_bounded(kind)),
        velocity: below(limit.velocity, f64::INFINITY),
        effort: below(limit.effort, f64::INFINITY),
    };
    let place = Place::Part("robot/joint/limit", &joint.name);
    check_limits(context, place, &limits);
    limits
}

/// Reports the parts of a joint that are not used.
fn report_unused(context: &mut Context<'_>, joint: &Joint, kind: JointKind) {
    let limit = &joint.limit;
    let rates = [limit.acceleration, limit.deceleration, limit.jerk];
    let mut unused = |is_there: bool, path, reason| {
        if is_there {
            context.ignore(Place::Part(path, &joint.name), reason);
        }
    };
    let calibration = "reference positions for calibration are not used";
    unused(joint.calibration.is_some(), "robot/joint", calibration);
    let safety = "safety controllers are not modelled";
    unused(joint.safety_controller.is_some(), "robot/joint", safety);
    let is_limited = rates.iter().any(|x| x.is_finite());
    let rates = "acceleration, deceleration and jerk are not limited";
    unused(is_limited, "robot/joint/limit", rates);
    if kind == JointKind::Fixed {
        let (dynamics, mimic) = (joint.dynamics.is_some(), joint.mimic.is_some());
        unused(dynamics, "robot/joint/dynamics", DOES_NOT_MOVE);
        unused(mimic, "robot/joint/mimic", DOES_NOT_MOVE);
    }
}
