//! Converts the typed reading to the parts of a model, with remarks on what may not mean what its author wanted.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::{HashMap, HashSet};

use nalgebra::Vector3;

use super::joint::{is_bounded, kind};
use super::part::{Part, Source};
use crate::io::context::Context;
use crate::io::mesh_path::MeshFinder;
use crate::io::rotation::rotation_from_rpy;
use crate::io::{remarks, shapes};
use crate::joint::JointKind;
use crate::model::{
    Collision, Geometry, JointSpec, Limits, LinkSpec, Mimic, Mimicry, ModelBuilder, Visual,
    inertia_flaw,
};
use crate::spatial::{Inertia, Symmetric3, Transform};

/// Makes the parts of the model.
pub(super) fn convert(
    context: &mut Context<'_>,
    robot: &urdf_rs::Robot,
    source: &Source<'_>,
    meshes: &mut MeshFinder,
    mimicry: Mimicry,
) -> ModelBuilder {
    let mut builder = ModelBuilder::new(&robot.name)
        .with_source(context.file)
        .with_mimicry(mimicry);
    let mut converter = Converter {
        robot,
        source,
        context,
        meshes,
        mimicry,
        colors: colors(robot),
        joints: robot.joints.iter().map(|joint| &*joint.name).collect(),
    };
    for l in 0..robot.links.len() {
        builder.add_link(converter.link(l));
    }
    for j in 0..robot.joints.len() {
        builder.add_joint(converter.joint(j));
    }
    builder
}

/// Converter of links and joints of URDF to those of a model.
struct Converter<'c, 'f> {
    robot: &'c urdf_rs::Robot,
    source: &'c Source<'c>,
    context: &'c mut Context<'f>,
    meshes: &'c mut MeshFinder,
    mimicry: Mimicry,
    /// The colours of named materials.
    colors: HashMap<&'c str, [f64; 4]>,
    /// The names of the joints.
    joints: HashSet<&'c str>,
}

/// The colours by the names of their materials: those of the robot, then those that links define.
fn colors(robot: &urdf_rs::Robot) -> HashMap<&str, [f64; 4]> {
    let visuals = robot.links.iter().flat_map(|link| &link.visual);
    let of_links = visuals.filter_map(|visual| visual.material.as_ref());
    let mut colors = HashMap::new();
    for material in robot.materials.iter().chain(of_links) {
        if let (Some(color), false) = (&material.color, material.name.is_empty()) {
            colors.entry(material.name.as_str()).or_insert(color.rgba.0);
        }
    }
    colors
}

impl Converter<'_, '_> {
    fn warn(&mut self, part: Part, reason: impl Into<String>) {
        let note = self
            .source
            .note(self.context, self.robot, part, reason.into());
        self.context.warnings.push(note);
    }

    fn link(&mut self, l: usize) -> LinkSpec {
        let link = &self.robot.links[l];
        let inertia = convert_inertia(&link.inertial);
        if let Some(flaw) = inertia_flaw(&inertia) {
            self.warn(Part::Inertial(l), flaw.to_string());
        }
        let mut spec = LinkSpec::new(&link.name).with_inertia(inertia);
        for (k, visual) in link.visual.iter().enumerate() {
            let places = [Part::Visual(l, k), Part::VisualShape(l, k)];
            spec = spec.with_visual(Visual {
                name: visual.name.clone(),
                placement: pose(&visual.origin),
                geometry: self.geometry(&visual.geometry, places),
                color: self.color(visual.material.as_ref(), Part::Material(l, k)),
            });
        }
        for (k, collision) in link.collision.iter().enumerate() {
            let places = [Part::Collision(l, k), Part::CollisionShape(l, k)];
            spec = spec.with_collision(Collision {
                name: collision.name.clone(),
                placement: pose(&collision.origin),
                geometry: self.geometry(&collision.geometry, places),
            });
        }
        spec
    }

    fn geometry(&mut self, shape: &urdf_rs::Geometry, [whole, size]: [Part; 2]) -> Geometry {
        let geometry = self.meshes.geometry(shape);
        if let Some(reason) = shapes::flaw(&geometry) {
            self.warn(size, reason);
        }
        if let Some(reason) = self.meshes.flaw(&geometry) {
            self.warn(whole, reason);
        }
        geometry
    }

    /// The colour of a visual: its own, or that of the material that it names.
    fn color(&mut self, material: Option<&urdf_rs::Material>, part: Part) -> Option<[f64; 4]> {
        let material = material?;
        let own = material.color.as_ref().map(|color| color.rgba.0);
        let color = own.or_else(|| self.colors.get(&*material.name).copied());
        if color.is_none() && self.source.only_names(part, material) {
            let reason = format!("there is no material \"{}\" with a colour", material.name);
            self.warn(part, reason);
        }
        color
    }

    fn joint(&mut self, j: usize) -> JointSpec {
        let joint = &self.robot.joints[j];
        let (parent, child) = (&joint.parent.link, &joint.child.link);
        let kind = kind(&joint.joint_type);
        let spec =
            JointSpec::new(&joint.name, kind, parent, child).with_placement(pose(&joint.origin));
        if kind == JointKind::Fixed {
            return spec;
        }
        let dynamics = joint.dynamics.clone().unwrap_or_default();
        if let Some(reason) = remarks::on_friction(dynamics.friction) {
            self.warn(Part::Dynamics(j), reason);
        }
        let spec = spec
            .with_axis(joint.axis.xyz.0)
            .with_limits(self.limits(j, kind))
            .with_damping(dynamics.damping)
            .with_friction(dynamics.friction);
        match self.mimic(j) {
            Some(mimic) => spec.with_mimic(mimic),
            None => spec,
        }
    }

    fn limits(&mut self, j: usize, kind: JointKind) -> Limits {
        let limit = &self.robot.joints[j].limit;
        let below = |x: f64, no_limit: f64| (x != no_limit).then_some(x);
        let limits = Limits {
            lower: below(limit.lower, f64::NEG_INFINITY).filter(|_| is_bounded(kind)),
            upper: below(limit.upper, f64::INFINITY).filter(|_| is_bounded(kind)),
            velocity: below(limit.velocity, f64::INFINITY),
            effort: below(limit.effort, f64::INFINITY),
        };
        if let Some(reason) = remarks::on_room(&limits) {
            self.warn(Part::Limit(j), reason);
        }
        for (quantity, limit) in [("velocity", limits.velocity), ("effort", limits.effort)] {
            if limit == Some(0.0) {
                self.warn(Part::Limit(j), format!("{quantity} is limited to 0"));
            }
        }
        limits
    }

    /// The joint that is followed; one that does not exist is an error later, unless all joints move independently.
    fn mimic(&mut self, j: usize) -> Option<Mimic> {
        let mimic = self.robot.joints[j].mimic.as_ref()?;
        if self.mimicry == Mimicry::Independent && !self.joints.contains(&*mimic.joint) {
            self.warn(Part::Mimic(j), remarks::on_missing_leader(&mimic.joint));
            return None;
        }
        Some(Mimic {
            leader: mimic.joint.clone(),
            multiplier: mimic.multiplier.unwrap_or(1.0),
            offset: mimic.offset.unwrap_or_default(),
        })
    }
}

/// The inertia in the frame of the link; the file gives it in a frame C at the centre of mass, turned by the `rpy` of
/// its origin.
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
    let [xyz, rpy] = [pose.xyz.0, pose.rpy.0];
    if [xyz, rpy] == [[0.0; 3]; 2] {
        // Zeros of either sign.
        return Transform::new(rotation_from_rpy([0.0; 3]), Vector3::zeros());
    }
    Transform::new(rotation_from_rpy(rpy), Vector3::from(xyz))
}
