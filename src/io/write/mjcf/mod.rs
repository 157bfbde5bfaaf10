//! The writer of MJCF files: the description as nested bodies.

mod inertial;
mod joint;
mod mesh;
mod shape;
mod stack;

use std::collections::{HashMap, HashSet};

use super::{Names, WORLD};
use crate::error::WriteError;
use crate::io::xml::{Xml, number, numbers};
use crate::joint::{JointKind, Pitch};
use crate::model::walk::Step;
use crate::model::{Base, JointSpec, Mimicry, Model, ModelBuilder, Weightless};
use crate::nested::IntoNested;
use crate::spatial::{Inertia, Quaternion, Transform};

/// Name of the body of a floating base that has a frame of its own.
const BASE_BODY: &str = "floating_base";

/// Writes a model; `builder` is its description.
pub(super) fn write(model: &Model<f64>, builder: &ModelBuilder) -> Result<String, WriteError> {
    let mut sites: HashMap<&str, Vec<(&str, &Transform<f64>)>> = Default::default();
    for frame in &builder.frames {
        let own = sites.entry(&frame.link).or_default();
        own.push((&frame.name, &frame.placement));
    }
    let has_frame = |link: &str| sites.contains_key(link);
    let stacked = stack::stacked(model, builder, &has_frame);
    check_masses(model, &stacked)?;
    let mut writer = Writer {
        xml: Xml::new(),
        builder,
        floats: model.has_floating_base(),
        sites,
        joint_names: Names::of(builder.joints.iter().map(|joint| joint.name.as_str())),
        moving: (model.links().iter())
            .map(|link| &model.frames()[link.frame.0])
            .filter(|frame| frame.body.is_some())
            .map(|frame| frame.name.as_str())
            .collect(),
        inertias: inertial::Inertias::new(model, builder),
        base_placement: base_placement(model),
        meshes: mesh::Meshes::of(builder),
        screws: Vec::new(),
        second_hinges: HashMap::new(),
        stacked,
        pending: stack::Pending::default(),
        shift: Transform::identity(),
    };
    writer.xml.start("mujoco", &[("model", &builder.name)]);
    writer.check_base(model)?;
    writer.header();
    writer.bodies()?;
    writer.equalities();
    writer.motors();
    Ok(writer.xml.finish())
}

/// Checks that every body that moves has mass of its own, as `MuJoCo` requires.
///
/// * `stacked` – links that become no bodies
fn check_masses(model: &Model<f64>, stacked: &HashSet<&str>) -> Result<(), WriteError> {
    let massless = |link: &crate::model::Link| {
        let frame = &model.frames()[link.frame.0];
        let body = frame
            .body
            .filter(|&body| model.body(body).inertia.mass == 0.0)?;
        let name = frame.name.as_str();
        (!stacked.contains(name)).then_some((body, name))
    };
    let mut massless: Vec<_> = model.links().iter().filter_map(massless).collect();
    massless.dedup_by_key(|&mut (body, _)| body);
    let names: Vec<&str> = massless.into_iter().map(|(_, name)| name).collect();
    if names.is_empty() {
        return Ok(());
    }
    let reason = "every body that moves needs mass there; the option massless_links gives it some";
    Err(unsupported(
        "moving links without mass",
        &names.join(", "),
        reason,
    ))
}

/// The pose of the first link that floats on the body of a floating base, if that is not its own frame.
fn base_placement(model: &Model<f64>) -> Option<Transform<f64>> {
    let mut frames = model
        .links()
        .iter()
        .map(|link| &model.frames()[link.frame.0]);
    let first = frames.find(|frame| frame.body.is_some())?;
    let is_apart = model.has_floating_base() && first.placement != Transform::identity();
    is_apart.then_some(first.placement)
}

fn unsupported(element: &str, name: &str, reason: impl Into<String>) -> WriteError {
    WriteError::Unsupported {
        format: "MJCF",
        element: element.into(),
        name: name.into(),
        reason: reason.into(),
    }
}

struct Writer<'a> {
    xml: Xml,
    builder: &'a ModelBuilder,
    floats: bool,
    /// The added frames by their links.
    sites: HashMap<&'a str, Vec<(&'a str, &'a Transform<f64>)>>,
    joint_names: Names,
    /// Names of the links that move.
    moving: HashSet<&'a str>,
    inertias: inertial::Inertias,
    /// Pose of the root link on a floating body that has another frame.
    base_placement: Option<Transform<f64>>,
    meshes: mesh::Meshes,
    /// Slides that advance with hinges: name, name of the hinge, m/rad.
    screws: Vec<(String, String, Pitch)>,
    /// Names of the second hinges of universal joints, by the names of the joints.
    second_hinges: HashMap<String, String>,
    /// Links whose joints are among those of the next body.
    stacked: HashSet<&'a str>,
    /// Joints of such links before the next body.
    pending: stack::Pending<'a>,
    /// The frame of the joint that is written, in its body.
    shift: Transform<f64>,
}

impl<'a> Writer<'a> {
    /// A base whose frame is not that of its first link has one inertia there, so gravity acts on all of it or on nothing.
    fn check_base(&self, model: &Model<f64>) -> Result<(), WriteError> {
        let is_base = |own: &&Weightless| own.body.0 == 0 && !own.is_whole();
        let is_split = model.weightless().iter().find(is_base).is_some();
        if self.base_placement.is_some() && is_split {
            let reason = "gravity acts on some of its links only";
            return Err(unsupported("floating base", &self.builder.name, reason));
        }
        Ok(())
    }

    fn header(&mut self) {
        let compiler = [
            ("angle", "radian"),
            ("autolimits", "true"),
            ("inertiafromgeom", "false"),
        ];
        self.xml.leaf("compiler", &compiler);
        let gravity = numbers(self.builder.gravity.as_slice());
        self.xml.leaf("option", &[("gravity", &gravity)]);
        self.xml.open("default");
        self.xml.leaf(
            "geom",
            &[("contype", "0"), ("conaffinity", "0"), ("density", "0")],
        );
        self.xml.end();
        self.meshes.write(&mut self.xml);
    }

    fn bodies(&mut self) -> Result<(), WriteError> {
        self.xml.open("worldbody");
        let is_world = |step: &Step<'_>| step.depth == 0 && step.link.name == WORLD;
        // The open bodies are those of the links above; the world body is open already.
        let mut open: Vec<usize> = Vec::new();
        for step in self.builder.walk() {
            while open.last().is_some_and(|&depth| depth >= step.depth) {
                open.pop();
                self.xml.end();
            }
            if is_world(&step) {
                self.link(&step)?;
                continue;
            }
            if step.link.name == WORLD {
                return Err(unsupported(
                    "link",
                    WORLD,
                    "only the root can have this name",
                ));
            }
            if let Some(joint) = step
                .joint
                .filter(|_| self.stacked.contains(&*step.link.name))
            {
                self.pending.push(joint);
                continue;
            }
            let on_world = open.is_empty();
            if self.base_placement.is_some() && self.is_floating_root(&step) {
                self.base_body()?;
                open.push(step.depth);
            }
            open.push(step.depth);
            self.body(&step, on_world)?;
        }
        open.iter().for_each(|_| self.xml.end());
        self.xml.end();
        Ok(())
    }

    /// Opens a body of its own for the frame of a floating base that is not that of its first link.
    fn base_body(&mut self) -> Result<(), WriteError> {
        let links = self.builder.links.iter().map(|link| link.name.as_str());
        let name = Names::of(links).fresh(BASE_BODY);
        let base = self.inertias.base_link().map(ToOwned::to_owned);
        let is_weightless = base.is_some_and(|link| self.inertias.is_weightless(&link));
        let mut attributes = vec![("name", name.clone())];
        attributes.extend(is_weightless.then(|| ("gravcomp", "1".to_owned())));
        self.xml.start("body", &attributes);
        self.floating_base()?;
        let inertia = self.inertias.take_base();
        self.inertial(&name, &inertia, inertial::Moves::Always)
    }

    /// Opens the body of a link and writes all but what it carries.
    fn body(&mut self, step: &Step<'a>, on_world: bool) -> Result<(), WriteError> {
        let root_floats = self.floats && self.is_floating_root(step);
        let on_base_body = self.base_placement.filter(|_| root_floats);
        let (joints, placement) = match step.joint {
            Some(joint) if !root_floats => self.joints_of(joint),
            _ => {
                let base = on_base_body.unwrap_or_else(Transform::identity);
                (Vec::new(), base)
            }
        };
        let on_world = on_world && joints.len() == 1;
        let mut attributes = vec![("name", step.link.name.to_owned())];
        attributes.extend(pose(&placement));
        if self.inertias.is_weightless(&step.link.name) {
            attributes.push(("gravcomp", "1".to_owned()));
        }
        self.xml.start("body", &attributes);
        if root_floats && on_base_body.is_none() {
            self.floating_base()?;
        }
        for (joint, frame) in joints {
            self.shift = frame;
            self.joint(joint, on_world)?;
        }
        let name = &step.link.name;
        let moves = self.moves(name);
        let inertia = self.inertias.take(name);
        self.inertial(name, &inertia, moves)?;
        self.link(step)
    }

    fn moves(&self, link: &str) -> inertial::Moves {
        if self.moving.contains(link) {
            inertial::Moves::Always
        } else {
            inertial::Moves::Never
        }
    }

    /// The root, or the link on a fixed joint below a `world` that it does not stand on.
    fn is_floating_root(&self, step: &Step<'_>) -> bool {
        let under_world = step.joint.is_some_and(|joint| joint.parent == WORLD);
        step.joint.is_none()
            || (step.depth == 1 && under_world && self.builder.base == Base::Floating)
    }

    /// The shapes and frames of a link.
    fn link(&mut self, step: &Step<'_>) -> Result<(), WriteError> {
        if step.depth == 0 && step.link.name == WORLD && step.link.inertia != Inertia::zero() {
            self.xml.comment("left out: the inertia of the world");
        }
        self.shapes(step.link);
        let sites = self
            .sites
            .remove(step.link.name.as_str())
            .unwrap_or_default();
        for (name, placement) in sites {
            let mut attributes = vec![("name", name.to_owned())];
            attributes.extend(pose(placement));
            self.xml.leaf("site", &attributes);
        }
        Ok(())
    }

    /// Mimic joints are separate joints there, and a screw has a second joint for its advance.
    fn equalities(&mut self) {
        let screws = std::mem::take(&mut self.screws).into_iter();
        let screws =
            screws.map(|(slide, hinge, pitch)| (slide, hinge, [0.0, pitch.metres_per_radian()]));
        let followers = self
            .builder
            .joints
            .iter()
            .filter(|joint| self.follows(joint));
        let followers = followers.filter_map(|joint| {
            let mimic = joint.mimic.as_ref()?;
            let factors = [mimic.offset, mimic.multiplier];
            Some((joint.name.to_owned(), mimic.leader.clone(), factors))
        });
        let tied: Vec<_> = screws.chain(followers).collect();
        if tied.is_empty() {
            return;
        }
        self.xml.open("equality");
        for (joint, leader, [offset, factor]) in tied {
            let polynomial = numbers(&[offset, factor, 0.0, 0.0, 0.0]);
            let attributes = [
                ("joint1", joint),
                ("joint2", leader),
                ("polycoef", polynomial),
            ];
            self.xml.leaf("joint", &attributes);
        }
        self.xml.end();
    }

    fn motors(&mut self) {
        let joints = self.builder.joints.iter();
        let hinges = joints.filter(|joint| !joint.is_passive).nested(|joint| {
            let second = joint
                .second
                .as_ref()
                .zip(self.second_hinges.get(&joint.name));
            let second = second.map(|(second, name)| (name.clone(), second.limits.effort));
            let is_single = joint.kind.nv() == 1 && !self.follows(joint);
            let first = (is_single || second.is_some())
                .then(|| (joint.name.to_owned(), joint.limits.effort));
            first.into_iter().chain(second)
        });
        let driven: Vec<_> = hinges.filter(|(_, effort)| *effort != Some(0.0)).collect();
        if driven.is_empty() {
            return;
        }
        self.xml.open("actuator");
        for (name, effort) in driven {
            let mut attributes = vec![("name", name.clone()), ("joint", name)];
            let range = |effort: f64| ("ctrlrange", numbers(&[-effort, effort]));
            attributes.extend(effort.map(range));
            self.xml.leaf("motor", &attributes);
        }
        self.xml.end();
    }

    fn follows(&self, joint: &JointSpec) -> bool {
        let coupled = self.builder.mimicry == Mimicry::Coupled;
        coupled && joint.mimic.as_ref().is_some() && joint.kind != JointKind::Fixed
    }
}

/// Position and quaternion (w, x, y, z), where they are not those of the identity.
fn pose(pose: &Transform<f64>) -> Vec<(&'static str, String)> {
    let mut attributes = Vec::new();
    if pose.translation != nalgebra::Vector3::zeros() {
        attributes.push(("pos", numbers(pose.translation.as_slice())));
    }
    if pose.rotation != nalgebra::Matrix3::identity() {
        attributes.push(("quat", quaternion(&pose.rotation)));
    }
    attributes
}

fn quaternion(rotation: &nalgebra::Matrix3<f64>) -> String {
    let mut wxyz = [0.0; 4];
    Quaternion::from_matrix(rotation).write_to(&mut wxyz);
    numbers(&wxyz)
}
