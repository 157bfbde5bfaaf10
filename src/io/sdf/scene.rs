//! Scene read from the files: models in each other with their frames, links and joints, and names to be resolved.
//!
//! Everything that can be a frame has an index into [`Scene::frames`]; the world is frame 0 and scope 0.

use std::collections::HashMap;

use crate::error::LoadError;
use crate::io::motion::Axis;
use crate::io::place::SourcePlace;
use crate::io::sensors::SensorElement;
use crate::joint::JointKind;
use crate::model::{Geometry, Mimic};
use crate::spatial::{Inertia, Transform};

/// The frame and the scope of the world.
pub(super) const WORLD: usize = 0;

/// Everything that was read.
#[derive(Debug)]
pub(super) struct Scene {
    pub(super) models: Vec<ModelEntry>,
    pub(super) frames: Vec<FrameEntry>,
    pub(super) links: Vec<LinkEntry>,
    pub(super) joints: Vec<JointEntry>,
    /// Sensors with their frames.
    pub(super) sensors: Vec<(SensorElement, usize)>,
    /// Gravity of the world, m/s²; `None` if the file has no world.
    pub(super) gravity: Option<[f64; 3]>,
    /// The model that becomes the robot, once it is met; the world itself if all do.
    pub(super) robot: Option<usize>,
    /// Name of the world, if all its models are read.
    pub(super) title: Option<String>,
}

/// A scope of names: a model, or the world.
#[derive(Debug)]
pub(super) struct ModelEntry {
    pub(super) frame: usize,
    /// Prefix of the names of the model's parts; empty for the model that becomes the robot.
    pub(super) prefix: String,
    pub(super) names: HashMap<String, usize>,
    /// Frames of the model, in the order in which they were read.
    pub(super) members: Vec<usize>,
    pub(super) placement_frame: Option<String>,
    pub(super) canonical_link: Option<String>,
    pub(super) is_static: bool,
    pub(super) nesting: Nesting,
}

/// Way in which the model around a model refers to its parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Nesting {
    /// A name from outside is `model::part`.
    #[default]
    Scoped,
    /// A name from outside is as one of its own: the model is merged into it, and only its frame remains, to hold the
    /// parts.
    Merged,
}

/// A named place.
#[derive(Debug)]
pub(super) struct FrameEntry {
    pub(super) scope: usize,
    /// Name of the frame in the whole robot.
    pub(super) name: String,
    pub(super) kind: FrameKind,
    pub(super) pose: Pose,
    pub(super) place: SourcePlace,
}

/// Element that a frame belongs to.
#[derive(Clone, Debug)]
pub(super) enum FrameKind {
    Model(usize),
    Link(usize),
    Joint(usize),
    /// A frame of its own, with the name of what it is attached to.
    Free(Option<String>),
}

/// A pose as a file states it.
#[derive(Clone, Debug)]
pub(super) struct Pose {
    /// The frame that it is given in; `None` where that goes without saying.
    pub(super) relative_to: Option<String>,
    pub(super) value: Transform<f64>,
}

impl Pose {
    /// Pose on the frame that goes without saying.
    pub(super) fn identity() -> Self {
        Self {
            relative_to: None,
            value: Transform::identity(),
        }
    }
}

#[derive(Debug)]
pub(super) struct LinkEntry {
    pub(super) frame: usize,
    pub(super) inertial: Inertial,
    pub(super) has_gravity: bool,
    pub(super) visuals: Vec<Shape>,
    pub(super) collisions: Vec<Shape>,
}

#[derive(Debug)]
pub(super) struct Inertial {
    pub(super) mass: MassEntry,
    pub(super) place: SourcePlace,
}

/// Source of the inertia of a link.
#[derive(Debug)]
pub(super) enum MassEntry {
    /// Mass and moments in a frame at the centre of mass.
    Given { pose: Pose, inertia: Inertia<f64> },
    /// Inertia of the collisions, of this density where they say nothing else, kg/m³.
    Solid { density: f64 },
}

/// A visual or a collision.
#[derive(Debug)]
pub(super) struct Shape {
    pub(super) name: Option<String>,
    pub(super) pose: Pose,
    pub(super) geometry: Geometry,
    pub(super) color: Option<[f64; 4]>,
    /// kg/m³.
    pub(super) density: Option<f64>,
    /// Bits of which one must be in common with another shape to collide with it.
    pub(super) bitmask: Option<u16>,
}

#[derive(Debug)]
pub(super) struct JointEntry {
    pub(super) frame: usize,
    pub(super) parent: String,
    pub(super) child: String,
    /// Motions from the parent to the child; none for a fixed joint.
    pub(super) motions: Vec<Motion>,
}

/// One axis of a joint, or a ball.
#[derive(Debug)]
pub(super) struct Motion {
    pub(super) kind: JointKind,
    pub(super) axis: Axis,
    /// The frame in which the axis is given; `None` is that of the joint.
    pub(super) expressed_in: Option<String>,
    pub(super) mimic: Option<Follow>,
}

/// A position that follows another: q = multiplier · (q of the leader − reference) + offset.
#[derive(Debug)]
pub(super) struct Follow {
    /// The joint to mimic, by its name in the file, with factor and offset.
    pub(super) mimic: Mimic,
    /// 0 or 1: which axis of the leader.
    pub(super) axis: usize,
    pub(super) reference: f64,
}

impl Scene {
    /// A world without anything in it.
    pub(super) fn new(place: SourcePlace) -> Self {
        let world = FrameEntry {
            scope: WORLD,
            name: "world".into(),
            kind: FrameKind::Model(WORLD),
            pose: Pose::identity(),
            place,
        };
        Self {
            models: vec![ModelEntry::new(WORLD, String::new())],
            frames: vec![world],
            links: Vec::new(),
            joints: Vec::new(),
            sensors: Vec::new(),
            gravity: None,
            robot: None,
            title: None,
        }
    }

    /// The frame that a name means where it stands; `a::b` is b in the nested model a.
    pub(super) fn resolve(
        &self,
        scope: usize,
        name: &str,
        place: &SourcePlace,
    ) -> Result<usize, LoadError> {
        self.find(scope, name).ok_or_else(|| place.unknown(name))
    }

    /// The frame that a name means in a scope, if there is one; see [`resolve`](Self::resolve).
    pub(super) fn find(&self, mut scope: usize, name: &str) -> Option<usize> {
        if name == "world" {
            return Some(WORLD);
        }
        let mut rest = name;
        loop {
            let model = &self.models[scope];
            if rest == "__model__" {
                return Some(model.frame);
            }
            if let Some(&frame) = model.names.get(rest) {
                return Some(frame);
            }
            let (nested, inner) = rest.split_once("::")?;
            let FrameKind::Model(model) = self.frames[*model.names.get(nested)?].kind else {
                return None;
            };
            (scope, rest) = (model, inner);
        }
    }
}

impl ModelEntry {
    pub(super) fn new(frame: usize, prefix: String) -> Self {
        Self {
            frame,
            prefix,
            names: HashMap::new(),
            members: Vec::new(),
            placement_frame: None,
            canonical_link: None,
            is_static: false,
            nesting: Nesting::Scoped,
        }
    }
}
