//! The objects in a picture, with their poses.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DVector, Vector3};

use super::surface::{Corner, rod, triangles};
use crate::dynamics::{Kinematics, forward_kinematics_into};
use crate::model::{BodyId, Model};
use crate::scalar::MapEach;
use crate::spatial::{Quaternion, Transform};
use crate::view::meshes::Meshes;
use crate::view::recording::Recording;
use crate::view::scene;
use crate::view::shape::{Pose, Shape};
use crate::view::track::Track;

/// Colours of robots without one, as in the HTML viewer: one after another.
const PLAIN: [[f64; 3]; 4] = [
    [0.55, 0.62, 0.72],
    [0.80, 0.62, 0.45],
    [0.52, 0.70, 0.58],
    [0.70, 0.58, 0.74],
];

/// Colours of the axes of frames.
const AXES: [[f64; 3]; 3] = [[0.90, 0.25, 0.22], [0.25, 0.70, 0.28], [0.25, 0.45, 0.95]];

/// Length and thickness of axes, relative to the half diagonal of what is in the picture, and to their length.
const AXIS: [f64; 2] = [0.09, 0.045];

/// Moments at which one looks where the robots are.
const MOMENTS: usize = 60;

/// Depth below which the lowest point decides on the floor rather than the origin, relative to the half diagonal: feet sink in a
/// little.
const SINKING: f64 = 0.05;

/// Robots and objects.
#[derive(Debug)]
pub(super) struct Stage {
    robots: Vec<(Model, Transform<f64>)>,
    pub(super) pieces: Vec<StagePiece>,
    /// Least and largest corner of a box around everything at any time.
    bounds: [Vector3<f64>; 2],
    /// Height of the floor; `None` where the ground is a surface of its own.
    pub(super) floor: Option<f64>,
}

/// A piece of a robot, or of an object that stands still.
#[derive(Debug)]
pub(super) struct StagePiece {
    /// The robot and its body; `None` for the world.
    on: Option<(usize, Option<usize>)>,
    /// Pose on the body.
    pose: Transform<f64>,
    pub(super) color: [f64; 4],
    pub(super) corners: Vec<Corner>,
    is_ground: bool,
}

/// Poses of the bodies of each robot in the picture.
pub(super) type Poses = Vec<Vec<Transform<f64>>>;

impl StagePiece {
    /// A piece that is fixed in the world.
    pub(super) fn still(pose: Transform<f64>, color: [f64; 4], corners: Vec<Corner>) -> Self {
        Self {
            on: None,
            pose,
            color,
            corners,
            is_ground: false,
        }
    }
}

impl Stage {
    /// The stage of a recording, and remarks on its meshes.
    pub(super) fn new(recording: &Recording) -> (Self, Vec<String>) {
        let mut meshes = Meshes::default();
        let mut stage = Self {
            robots: recording
                .robots
                .iter()
                .map(|track| (track.model.clone(), track.placement))
                .collect(),
            pieces: Vec::new(),
            bounds: [Vector3::zeros(); 2],
            floor: None,
        };
        for (i, (model, _)) in stage.robots.iter().enumerate() {
            let [r, g, b] = PLAIN[i % PLAIN.len()];
            for shape in scene::shapes(model, &mut meshes) {
                let on = Some((i, shape.body));
                let corners = triangles(&shape.piece, &meshes.meshes);
                stage
                    .pieces
                    .push(piece(on, &shape, [r, g, b, 1.0], corners, false));
            }
        }
        let (mut level, mut has_surface, mut frames) = (None, false, Vec::new());
        for object in &recording.scene_objects {
            let scenery = object.scenery(&mut meshes);
            level = level.or(scenery.level);
            has_surface |= scenery.is_ground && scenery.level.is_none();
            for shape in &scenery.shapes {
                let corners = triangles(&shape.piece, &meshes.meshes);
                stage.pieces.push(piece(
                    None,
                    shape,
                    [0.7, 0.7, 0.7, 1.0],
                    corners,
                    scenery.is_ground,
                ));
            }
            frames.extend(scenery.axes);
        }
        stage.bounds = stage.bounds_of(recording);
        frames.iter().for_each(|frame| stage.add_axes(frame));
        stage.floor = (!has_surface).then(|| level.unwrap_or_else(|| stage.lowest()));
        (stage, meshes.warnings())
    }

    pub(super) fn bounds(&self) -> [Vector3<f64>; 2] {
        self.bounds
    }

    /// Half the diagonal of the box around everything, m.
    pub(super) fn radius(&self) -> f64 {
        ((self.bounds[1] - self.bounds[0]).norm() / 2.0).max(1e-3)
    }

    /// The poses of all bodies; of a configuration that is not finite those of the neutral one.
    pub(super) fn poses(&self, configurations: &[&[f64]]) -> Poses {
        assert_eq!(
            configurations.len(),
            self.robots.len(),
            "one state for each robot"
        );
        let robots = self.robots.iter().zip(configurations);
        let poses = robots.map(|((model, placement), q)| {
            let neutral = model.neutral();
            model.check_q(q);
            let is_known = q.iter().all(|x| x.is_finite());
            let q = if is_known { q } else { neutral.as_slice() };
            let mut kinematics = Kinematics::new(model);
            forward_kinematics_into(model, q, &vec![0.0; model.nv()], &mut kinematics);
            let bodies = (0..model.n_bodies()).map(BodyId);
            bodies
                .map(|body| *placement * kinematics.pose(Some(body)))
                .collect()
        });
        poses.collect()
    }

    /// The pose of a piece in the picture.
    pub(super) fn pose(&self, piece: &StagePiece, poses: &Poses) -> Transform<f64> {
        match piece.on {
            None => piece.pose,
            Some((robot, None)) => self.robots[robot].1 * piece.pose,
            Some((robot, Some(body))) => poses[robot][body] * piece.pose,
        }
    }

    fn add_axes(&mut self, frame: &Pose) {
        let length = AXIS[0] * self.radius();
        for (axis, [r, g, b]) in AXES.into_iter().enumerate() {
            // z along the axis: the columns of the frame, one place on.
            let R = transform(frame).rotation;
            let columns = [1, 2, 0].map_each(|k| R.column((axis + k) % 3).into_owned());
            let turned = Transform::new(
                nalgebra::Matrix3::from_columns(&columns),
                transform(frame).translation,
            );
            let corners = rod(AXIS[1] * length, 0.0, length);
            self.pieces
                .push(StagePiece::still(turned, [r, g, b, 1.0], corners));
        }
    }

    /// Height of a floor that nothing says the height of.
    fn lowest(&self) -> f64 {
        let [low, high] = self.bounds;
        match low.z < -SINKING * self.radius() {
            true => low.z,
            false => ((low.z + high.z) / 2.0).min(0.0),
        }
    }

    /// The box around all pieces but the ground at some moments.
    fn bounds_of(&self, recording: &Recording) -> [Vector3<f64>; 2] {
        let mut out = [
            Vector3::repeat(f64::INFINITY),
            Vector3::repeat(f64::NEG_INFINITY),
        ];
        let step = recording.len().div_ceil(MOMENTS).max(1);
        let moments = (0..recording.len()).step_by(step);
        let mut known: Vec<Vec<&[f64]>> = moments
            .map(|k| recording.robots.iter().map(|track| track.q(k)).collect())
            .collect();
        let neutral: Vec<_> = self
            .robots
            .iter()
            .map(|(model, _)| model.neutral())
            .collect();
        if known.is_empty() {
            known.push(neutral.iter().map(DVector::as_slice).collect());
        }
        for configurations in known {
            let poses = self.poses(&configurations);
            for piece in self.pieces.iter().filter(|piece| !piece.is_ground) {
                let X = self.pose(piece, &poses);
                for corner in &piece.corners {
                    let at = X.point(&corner.position);
                    out = [out[0].inf(&at), out[1].sup(&at)];
                }
            }
        }
        match out[0].x <= out[1].x {
            true => out,
            false => [Vector3::new(-0.5, -0.5, 0.0), Vector3::new(0.5, 0.5, 1.0)],
        }
    }
}

fn piece(
    on: Option<(usize, Option<usize>)>,
    shape: &Shape,
    plain: [f64; 4],
    corners: Vec<Corner>,
    is_ground: bool,
) -> StagePiece {
    StagePiece {
        on,
        pose: transform(&shape.pose),
        color: shape.color.unwrap_or(plain),
        corners,
        is_ground,
    }
}

fn transform([x, y, z, w, i, j, k]: &Pose) -> Transform<f64> {
    let rotation = Quaternion::from_slice(&[*w, *i, *j, *k]).to_matrix();
    Transform::new(rotation, Vector3::new(*x, *y, *z))
}

/// The configuration of a robot at a time: interpolated between the moments around it that are known, else that of the last one
/// before it.
pub(super) fn configuration(recording: &Recording, track: &Track, time: f64) -> DVector<f64> {
    let times = recording.times();
    let after = times.partition_point(|&t| t <= time);
    let is_known = |k: &usize| track.q(*k).iter().all(|x| x.is_finite());
    let Some(before) = (0..after.max(1).min(times.len())).rev().find(is_known) else {
        return track.model.neutral();
    };
    let next = before + 1;
    if next != after || next >= times.len() || !is_known(&next) {
        return DVector::from_column_slice(track.q(before));
    }
    let part = (time - times[before]) / (times[next] - times[before]);
    track
        .model
        .interpolate(track.q(before), track.q(next), part.clamp(0.0, 1.0))
}
