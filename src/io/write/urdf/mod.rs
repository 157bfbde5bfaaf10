//! The writer of URDF files.

mod left_out;
mod universal;

use super::{AboutCom, Names, WORLD};
use crate::error::WriteError;
use crate::io::motion::is_bounded;
use crate::io::values::INERTIA_ENTRIES;
use crate::io::xml::{Xml, number, numbers};
use crate::joint::JointKind;
use crate::model::{Base, Geometry, JointSpec, LinkSpec, Mimicry, ModelBuilder};
use crate::spatial::{Inertia, Transform, roll_pitch_yaw};

/// Name of the root link that is the frame of a floating base, and of its fixed joint.
const FLOATING_FRAME: &str = "floating_base";

/// The first version in which a missing limit means that there is none.
const WITH_OPTIONAL_LIMITS: &str = "1.2";

/// Writes a description.
pub(super) fn write(builder: &ModelBuilder) -> Result<String, WriteError> {
    check(builder)?;
    let builder = &universal::split(builder);
    let steps = builder.walk();
    let root = steps[0].link.name.as_str();
    let hidden = (builder.base == Base::Floating && root == WORLD).then_some(root);
    let mut writer = Writer {
        xml: Xml::new(),
        joint_names: Names::of(builder.joints.iter().map(|joint| joint.name.as_str())),
        n_materials: 0,
        mimicry: builder.mimicry,
    };
    let mut attributes = vec![("name", builder.name.as_str())];
    if builder.joints.iter().any(lacks_limits) {
        attributes.push(("version", WITH_OPTIONAL_LIMITS));
    }
    writer.xml.start("robot", &attributes);
    for note in left_out::notes(builder, hidden) {
        writer.xml.comment(&note);
    }
    if builder.base == Base::Fixed && root != WORLD {
        writer.world(builder, root)?;
    }
    if let Some(hidden) = hidden {
        writer.floating_frame(builder, hidden);
    }
    writer.parts(builder, hidden)?;
    Ok(writer.xml.finish())
}

/// Refuses joints that URDF has no type for.
fn check(builder: &ModelBuilder) -> Result<(), WriteError> {
    let is_screw = |joint: &&JointSpec| matches!(joint.kind, JointKind::Screw(_));
    match builder.joints.iter().find(is_screw) {
        None => Ok(()),
        Some(joint) => Err(WriteError::Unsupported {
            format: "URDF",
            element: "joint".into(),
            name: joint.name.clone(),
            reason: "there are no screw joints".into(),
        }),
    }
}

/// `true` where a limit that the first version demands is missing.
fn lacks_limits(joint: &JointSpec) -> bool {
    let limits = &joint.limits;
    let bounds = [limits.lower, limits.upper, limits.velocity, limits.effort];
    is_bounded(joint.kind) && bounds.contains(&None)
}

struct Writer {
    xml: Xml,
    joint_names: Names,
    n_materials: usize,
    mimicry: Mimicry,
}

impl Writer {
    /// Writes links, joints and frames, except for a link that is hidden.
    fn parts(&mut self, builder: &ModelBuilder, hidden: Option<&str>) -> Result<(), WriteError> {
        let is_seen = |link: &str| Some(link) != hidden;
        for link in &builder.links {
            if is_seen(&link.name) {
                self.link(link)?;
            }
        }
        for joint in &builder.joints {
            if is_seen(&joint.parent) {
                self.joint(joint);
            }
        }
        for frame in &builder.frames {
            if is_seen(&frame.link) {
                self.frame(&frame.name, &frame.link, &frame.placement);
            }
        }
        let weightless = builder.links.iter().filter(|link| !link.has_gravity);
        for link in weightless.filter(|link| is_seen(&link.name)) {
            self.xml.start("gazebo", &[("reference", &link.name)]);
            self.xml.text("gravity", "false");
            self.xml.end();
        }
        Ok(())
    }

    /// A root in the frame that floats, for what is placed in it by a fixed joint to a world that is hidden.
    fn floating_frame(&mut self, builder: &ModelBuilder, hidden: &str) {
        let placed = builder.joints.iter().find(|joint| joint.parent == hidden);
        let Some(joint) = placed.filter(|joint| joint.placement != Transform::identity()) else {
            return;
        };
        let frames = builder.frames.iter().map(|frame| frame.name.as_str());
        let mut names = Names::of(
            builder
                .links
                .iter()
                .map(|link| link.name.as_str())
                .chain(frames),
        );
        let root = names.fresh(FLOATING_FRAME);
        self.xml.leaf("link", &[("name", &root)]);
        self.fixed_joint(FLOATING_FRAME, &root, &joint.child, &joint.placement);
    }

    /// A world link as the parent of the root of a fixed robot.
    fn world(&mut self, builder: &ModelBuilder, root: &str) -> Result<(), WriteError> {
        let frames = builder.frames.iter().map(|frame| frame.name.as_str());
        let mut names = builder
            .links
            .iter()
            .map(|link| link.name.as_str())
            .chain(frames);
        if names.any(|name| name == WORLD) {
            return Err(WriteError::Unsupported {
                format: "URDF",
                element: "link".into(),
                name: WORLD.into(),
                reason: format!("the base \"{root}\" must be fixed to a link of this name"),
            });
        }
        self.xml.leaf("link", &[("name", WORLD)]);
        self.fixed_joint(
            &format!("{root}_fixed"),
            WORLD,
            root,
            &Transform::identity(),
        );
        Ok(())
    }

    fn link(&mut self, link: &LinkSpec) -> Result<(), WriteError> {
        self.xml.start("link", &[("name", &link.name)]);
        let about_com = AboutCom::of(&link.inertia).ok_or_else(|| WriteError::Unsupported {
            format: "URDF",
            element: "link".into(),
            name: link.name.clone(),
            reason: "it has a first moment without mass".into(),
        })?;
        if link.inertia != Inertia::zero() {
            self.inertial(&about_com);
        }
        let is_known = |shape: &Geometry| !matches!(shape, Geometry::Ellipsoid { .. });
        for visual in link.visuals.iter().filter(|own| is_known(&own.geometry)) {
            let name = visual.name.as_deref().map(|name| ("name", name));
            self.xml.start("visual", name.as_slice());
            self.shape(&visual.placement, &visual.geometry);
            if let Some(color) = visual.color {
                self.material(&color);
            }
            self.xml.end();
        }
        for collision in (link.collisions.iter()).filter(|own| is_known(&own.geometry)) {
            let name = collision.name.as_deref().map(|name| ("name", name));
            self.xml.start("collision", name.as_slice());
            self.shape(&collision.placement, &collision.geometry);
            self.xml.end();
        }
        self.xml.end();
        Ok(())
    }

    fn inertial(&mut self, about_com: &AboutCom) {
        self.xml.open("inertial");
        self.origin(&Transform::from_translation(about_com.com));
        self.xml.leaf("mass", &[("value", &number(about_com.mass))]);
        let j = &about_com.moments;
        let entries = [j.xx, j.xy, j.xz, j.yy, j.yz, j.zz].map(number);
        let attributes: Vec<_> = INERTIA_ENTRIES.into_iter().zip(entries).collect();
        self.xml.leaf("inertia", &attributes);
        self.xml.end();
    }

    fn origin(&mut self, pose: &Transform<f64>) {
        if *pose != Transform::identity() {
            let xyz = numbers(pose.translation.as_slice());
            let rpy = numbers(&roll_pitch_yaw(&pose.rotation));
            self.xml.leaf("origin", &[("xyz", &xyz), ("rpy", &rpy)]);
        }
    }

    fn shape(&mut self, pose: &Transform<f64>, geometry: &Geometry) {
        self.origin(pose);
        self.xml.open("geometry");
        match geometry {
            Geometry::Box { size } => self.xml.leaf("box", &[("size", &numbers(size))]),
            Geometry::Sphere { radius } => self.xml.leaf("sphere", &[("radius", &number(*radius))]),
            Geometry::Cylinder { radius, length } => self.round("cylinder", *radius, *length),
            Geometry::Capsule { radius, length } => self.round("capsule", *radius, *length),
            // Links leave it out.
            Geometry::Ellipsoid { .. } => {}
            Geometry::Mesh { uri, scale, .. } => {
                self.xml
                    .leaf("mesh", &[("filename", uri), ("scale", &numbers(scale))]);
            }
        }
        self.xml.end();
    }

    fn round(&mut self, tag: &str, radius: f64, length: f64) {
        self.xml.leaf(
            tag,
            &[("radius", &number(radius)), ("length", &number(length))],
        );
    }

    /// A material of its own: names of materials are those of the whole file.
    fn material(&mut self, color: &[f64; 4]) {
        self.n_materials += 1;
        self.xml.start(
            "material",
            &[("name", &format!("color_{}", self.n_materials))],
        );
        self.xml.leaf("color", &[("rgba", &numbers(color))]);
        self.xml.end();
    }

    fn joint(&mut self, joint: &JointSpec) {
        let kind = joint.kind;
        self.xml.start(
            "joint",
            &[("name", joint.name.as_str()), ("type", &*kind.to_string())],
        );
        self.origin(&joint.placement);
        self.xml.leaf("parent", &[("link", &joint.parent)]);
        self.xml.leaf("child", &[("link", &joint.child)]);
        if kind.has_axis() {
            self.xml
                .leaf("axis", &[("xyz", &numbers(joint.axis.as_slice()))]);
        }
        if kind != JointKind::Fixed {
            self.motion(joint);
        }
        self.xml.end();
    }

    /// Writes the limits, damping, friction and mimicry of a joint.
    fn motion(&mut self, joint: &JointSpec) {
        let limits = &joint.limits;
        let mut bounds = vec![("effort", limits.effort), ("velocity", limits.velocity)];
        if is_bounded(joint.kind) {
            bounds.extend([("lower", limits.lower), ("upper", limits.upper)]);
        }
        let bounds: Vec<(&str, String)> = bounds
            .into_iter()
            .filter_map(|(name, bound)| Some((name, number(bound?))))
            .collect();
        if !bounds.is_empty() {
            self.xml.leaf("limit", &bounds);
        }
        if (joint.damping, joint.friction) != (0.0, 0.0) {
            let (damping, friction) = (number(joint.damping), number(joint.friction));
            self.xml.leaf(
                "dynamics",
                &[("damping", &damping), ("friction", &friction)],
            );
        }
        if let Some(mimic) = joint
            .mimic
            .as_ref()
            .filter(|_| self.mimicry == Mimicry::Coupled)
        {
            let (multiplier, offset) = (number(mimic.multiplier), number(mimic.offset));
            let leader = ("joint", &mimic.leader);
            self.xml.leaf(
                "mimic",
                &[leader, ("multiplier", &multiplier), ("offset", &offset)],
            );
        }
    }

    /// An added frame: a link without inertia.
    fn frame(&mut self, name: &str, link: &str, pose: &Transform<f64>) {
        self.xml.leaf("link", &[("name", name)]);
        self.fixed_joint(&format!("{name}_frame"), link, name, pose);
    }

    fn fixed_joint(&mut self, name: &str, parent: &str, child: &str, pose: &Transform<f64>) {
        let name = self.joint_names.fresh(name);
        self.xml
            .start("joint", &[("name", &*name), ("type", "fixed")]);
        self.origin(pose);
        self.xml.leaf("parent", &[("link", parent)]);
        self.xml.leaf("child", &[("link", child)]);
        self.xml.end();
    }
}
