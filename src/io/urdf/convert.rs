//! From the checked text, through the `urdf-rs` reader, to the parts of a model.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::{HashMap, HashSet};

use nalgebra::Vector3;

use super::document::{Document, JointEntry, LinkEntry};
use crate::error::LoadError;
use crate::io::context::{Context, Node, child};
use crate::io::mesh_path::MeshFinder;
use crate::io::report::missing_leader;
use crate::io::rotation::rotation_from_rpy;
use crate::model::{
    Collision, Geometry, JointSpec, Limits, LinkSpec, Mimic, Mimicry, ModelBuilder, Visual,
    inertia_flaw,
};
use crate::spatial::{Inertia, Symmetric3, Transform};

/// Parses a checked text.
pub(super) fn parse(file: &str, text: &str) -> Result<urdf_rs::Robot, LoadError> {
    urdf_rs::read_from_string(text).map_err(|error| LoadError::Refused {
        file: file.into(),
        reason: error.to_string(),
    })
}

/// Makes the parts of the model.
pub(super) fn convert(
    context: &mut Context<'_>,
    document: &Document<'_>,
    robot: &urdf_rs::Robot,
    meshes: &mut MeshFinder,
    mimicry: Mimicry,
) -> ModelBuilder {
    let mut builder = ModelBuilder::new(&robot.name)
        .with_source(context.file)
        .with_mimicry(mimicry);
    let mut parts = Parts {
        context,
        meshes,
        colors: colors(robot),
    };
    for (link, entry) in robot.links.iter().zip(&document.links) {
        builder.add_link(parts.link(link, entry));
    }
    let joints: HashSet<&str> = (robot.joints.iter())
        .map(|joint| joint.name.as_str())
        .collect();
    for (joint, entry) in robot.joints.iter().zip(&document.joints) {
        let mut spec = convert_joint(joint, entry);
        if let Some(mimic) = &joint.mimic {
            let leads = joints.contains(mimic.joint.as_str());
            if leads || mimicry == Mimicry::Coupled {
                spec = spec.with_mimic(convert_mimic(mimic));
            } else {
                parts.warn_of_missing_leader(mimic, entry);
            }
        }
        builder.add_joint(spec);
    }
    builder
}

/// Converter of URDF links to link specifications, with the colours of named materials.
struct Parts<'c, 'f> {
    context: &'c mut Context<'f>,
    meshes: &'c mut MeshFinder,
    colors: HashMap<String, [f64; 4]>,
}

/// The colours by the names of their materials: those of the robot, then those that links define.
fn colors(robot: &urdf_rs::Robot) -> HashMap<String, [f64; 4]> {
    let of_links = robot.links.iter().flat_map(|link| &link.visual);
    let materials = robot.materials.iter();
    let mut colors = HashMap::new();
    for material in materials.chain(of_links.filter_map(|visual| visual.material.as_ref())) {
        if let Some(color) = material
            .color
            .as_ref()
            .filter(|_| !material.name.is_empty())
        {
            let name = material.name.clone();
            colors.entry(name).or_insert(color.rgba.0);
        }
    }
    colors
}

impl Parts<'_, '_> {
    fn link(&mut self, link: &urdf_rs::Link, entry: &LinkEntry<'_>) -> LinkSpec {
        let mut spec = LinkSpec::new(&link.name);
        if let Some(node) = entry.inertial {
            let inertia = convert_inertia(&link.inertial);
            if let Some(flaw) = inertia_flaw(&inertia) {
                self.context.warn(node, flaw.to_string());
            }
            spec = spec.with_inertia(inertia);
        }
        for (visual, &node) in link.visual.iter().zip(&entry.visuals) {
            spec = spec.with_visual(Visual {
                name: visual.name.clone(),
                placement: pose(&visual.origin),
                geometry: self.geometry(&visual.geometry, node),
                color: self.color(visual.material.as_ref(), node),
            });
        }
        for (collision, &node) in link.collision.iter().zip(&entry.collisions) {
            spec = spec.with_collision(Collision {
                name: collision.name.clone(),
                placement: pose(&collision.origin),
                geometry: self.geometry(&collision.geometry, node),
            });
        }
        spec
    }

    fn geometry(&mut self, geometry: &urdf_rs::Geometry, node: Node<'_>) -> Geometry {
        match *geometry {
            urdf_rs::Geometry::Box { size } => Geometry::Box { size: size.0 },
            urdf_rs::Geometry::Cylinder { radius, length } => Geometry::Cylinder { radius, length },
            urdf_rs::Geometry::Capsule { radius, length } => Geometry::Capsule { radius, length },
            urdf_rs::Geometry::Sphere { radius } => Geometry::Sphere { radius },
            urdf_rs::Geometry::Mesh {
                ref filename,
                scale,
            } => self.mesh(filename, scale.map_or([1.0; 3], |scale| scale.0), node),
        }
    }

    fn mesh(&mut self, uri: &str, scale: [f64; 3], node: Node<'_>) -> Geometry {
        let mesh = self.meshes.mesh(uri, scale);
        if let Some(reason) = self.meshes.flaw(&mesh) {
            self.context.warn(node, reason);
        }
        mesh
    }

    /// For a joint that moves independently, all the same.
    fn warn_of_missing_leader(&mut self, mimic: &urdf_rs::Mimic, entry: &JointEntry<'_>) {
        let place = child(entry.node, "mimic").unwrap_or(entry.node);
        self.context.warn(place, missing_leader(&mimic.joint));
    }

    /// The colour of a visual: its own, or that of the material that it names.
    fn color(&mut self, material: Option<&urdf_rs::Material>, node: Node<'_>) -> Option<[f64; 4]> {
        let material = material?;
        let own = material.color.as_ref().map(|color| color.rgba.0);
        let color = own.or_else(|| self.colors.get(&material.name).copied());
        let place = child(node, "material")?;
        if color.is_none() && place.first_element_child().is_none() {
            let reason = format!("there is no material \"{}\" with a colour", material.name);
            self.context.warn(place, reason);
        }
        color
    }
}

fn convert_joint(joint: &urdf_rs::Joint, entry: &JointEntry<'_>) -> JointSpec {
    let (parent, child) = (&joint.parent.link, &joint.child.link);
    let dynamics = joint.dynamics.as_ref();
    JointSpec::new(&joint.name, entry.kind, parent, child)
        .with_placement(pose(&joint.origin))
        .with_axis(joint.axis.xyz.0)
        .with_limits(limits(&joint.limit, entry))
        .with_damping(dynamics.map_or(0.0, |dynamics| dynamics.damping))
        .with_friction(dynamics.map_or(0.0, |dynamics| dynamics.friction))
}

fn convert_mimic(mimic: &urdf_rs::Mimic) -> Mimic {
    Mimic {
        leader: mimic.joint.clone(),
        multiplier: mimic.multiplier.unwrap_or(1.0),
        offset: mimic.offset.unwrap_or_default(),
    }
}

fn limits(limit: &urdf_rs::JointLimit, entry: &JointEntry<'_>) -> Limits {
    let present = entry.limits;
    Limits {
        lower: present.lower.then_some(limit.lower),
        upper: present.upper.then_some(limit.upper),
        velocity: present.velocity.then_some(limit.velocity),
        effort: present.effort.then_some(limit.effort),
    }
}

/// The inertia in the frame of the link; the file gives it in a frame C at the centre of mass, turned by the `rpy` of its origin.
fn convert_inertia(inertial: &urdf_rs::Inertial) -> Inertia<f64> {
    let i = &inertial.inertia;
    let J_C = Symmetric3::new(i.ixx, i.ixy, i.ixz, i.iyy, i.iyz, i.izz);
    let X_LC = pose(&inertial.origin);
    Inertia::from_com(
        inertial.mass.value,
        &X_LC.translation,
        &J_C.rotated(&X_LC.rotation),
    )
}

fn pose(pose: &urdf_rs::Pose) -> Transform<f64> {
    Transform::new(rotation_from_rpy(pose.rpy.0), Vector3::from(pose.xyz.0))
}
