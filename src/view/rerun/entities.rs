//! Entities that are sent: robots, numbers and shapes.

use re_sdk::{EntityPath, EntityPathPart, TimeCell, TimePoint, log::PendingRow};
use re_types::AsComponents;
use re_types::archetypes::{Scalars, TextDocument, Transform3D, ViewCoordinates};
use re_types::datatypes::Quaternion as Rotation;

use super::{RerunStream, shapes};
use crate::dynamics::Kinematics;
use crate::model::{BodyId, Model};
use crate::view::meshes::Meshes;
use crate::view::recording::Recording;
use crate::view::scene;
use crate::view::scene_object::Scenery;
use crate::view::shape::{Pose, Shape, pose};
use crate::view::track::Track;

/// Length of the axes of a frame, m.
pub(super) const AXES: f32 = 0.1;

/// The timeline.
const TIMELINE: &str = "time";

/// A robot and where its parts stand among the entities.
#[derive(Debug)]
pub(super) struct Robot {
    pub(super) model: Model,
    pub(super) kinematics: Kinematics<f64>,
    pub(super) bodies: Vec<EntityPath>,
    pub(super) numbers: EntityPath,
    /// Entities of the coordinates of q and v.
    pub(super) columns: Vec<EntityPath>,
}

impl RerunStream {
    /// Logs what stands still: the shapes of robots, and scene objects; also the warnings.
    pub(super) fn log_scene(&self, scene: &Recording) {
        self.log_static(EntityPath::root(), &ViewCoordinates::RIGHT_HAND_Z_UP());
        let mut meshes = Meshes::default();
        for track in &scene.robots {
            let root = path(&["robots", &track.name]);
            self.log_static(root.clone(), &transform(&pose(&track.placement)));
            for (k, shape) in scene::shapes(&track.model, &mut meshes).iter().enumerate() {
                let body = shape.body.map(|body| track.model.body_name(BodyId(body)));
                let at = root.join(&path(&[body.unwrap_or("world"), &k.to_string()]));
                self.log_shape(at, shape, &meshes);
            }
        }
        for object in &scene.scene_objects {
            self.log_object(&object.scenery(&mut meshes), &meshes);
        }
        let warnings = meshes.warnings();
        if !warnings.is_empty() {
            let text = TextDocument::new(warnings.join("\n\n"));
            self.log_static(path(&["warnings"]), &text);
        }
    }

    fn log_object(&self, object: &Scenery<'_>, meshes: &Meshes) {
        let root = path(&["fixtures", object.name]);
        if let Some(axes) = &object.axes {
            self.log_static(root.clone(), &transform(axes).with_axis_length(AXES));
        }
        for (k, shape) in object.shapes.iter().enumerate() {
            self.log_shape(root.join(&path(&[&k.to_string()])), shape, meshes);
        }
    }

    fn log_shape(&self, at: EntityPath, shape: &Shape, meshes: &Meshes) {
        self.log_static(at.clone(), &transform(&shape.pose));
        self.log_static(at, shapes::archetype(shape, &meshes.meshes).as_ref());
    }

    pub(super) fn log_number(&self, at: EntityPath, time: f64, x: f64) {
        if !x.is_nan() {
            self.log(at, time, &Scalars::single(x));
        }
    }

    pub(super) fn log(&self, at: EntityPath, time: f64, what: &dyn AsComponents) {
        /// Nanoseconds in a second.
        const NANO: f64 = 1e9;
        let cell = TimeCell::from_duration_nanos((time * NANO).round() as i64);
        self.send(at, TimePoint::default().with_index(TIMELINE, cell), what);
    }

    pub(super) fn log_static(&self, at: EntityPath, what: &dyn AsComponents) {
        self.send(at, TimePoint::default(), what);
    }

    /// Sends components at a point in time; at none if they stay. The clock of the machine is not a timeline here.
    fn send(&self, at: EntityPath, time: TimePoint, what: &dyn AsComponents) {
        let row = PendingRow::from_iter(time, what.as_serialized_batches());
        self.stream.record_row(at, row, false);
    }
}

impl Robot {
    pub(super) fn new(track: &Track) -> Self {
        let model = track.model.clone();
        let numbers = path(&["numbers", &track.name]);
        let body = |i: usize| path(&["robots", &track.name, model.body_name(BodyId(i))]);
        let states = track.column_names().into_iter();
        let column = |name: String| {
            let parts = name.split_once('.').unwrap_or(("", &name));
            numbers.join(&path(&[parts.0, parts.1]))
        };
        Self {
            kinematics: Kinematics::new(&model),
            bodies: (0..model.n_bodies()).map(body).collect(),
            columns: states.take(model.nq() + model.nv()).map(column).collect(),
            numbers,
            model,
        }
    }
}

/// A path of names, whatever they hold.
pub(super) fn path(parts: &[&str]) -> EntityPath {
    parts
        .iter()
        .map(|&part| EntityPathPart::new(part))
        .collect()
}

pub(super) fn transform(&[x, y, z, w, i, j, k]: &Pose) -> Transform3D {
    let rotation = Rotation::from_xyzw([i, j, k, w].map(|x| x as f32));
    Transform3D::update_fields()
        .with_translation([x, y, z].map(|x| x as f32))
        .with_quaternion(rotation)
}
