//! Robot in the HTML viewer: shapes, frames, joints, inertias, names. All data are constant; [`motion`](super::motion) contains the motion.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Matrix3;
use serde::Serialize;

use super::bond::Bond;
use super::meshes::Meshes;
use super::shape::{Pose, Shape, pose};
use super::skeleton::skeleton;
use super::track::Track;
use crate::joint::JointKind;
use crate::linalg::symmetric_eigen3;
use crate::model::{Body, BodyId, FrameId, Model, WORLD};
use crate::nested::IntoNested;
use crate::spatial::Transform;

/// A robot without its motion.
#[derive(Debug, Serialize)]
pub(super) struct Robot {
    name: String,
    /// Pose of the robot in the picture.
    placement: Pose,
    bodies: Vec<SceneBody>,
    shapes: Vec<Shape>,
    frames: Vec<SceneFrame>,
    /// Frames whose paths are drawn.
    traces: Vec<usize>,
    /// Frames whose axes are drawn.
    shown: Vec<usize>,
    /// Constraints.
    bonds: Vec<Bond>,
    links: Vec<Link>,
}

/// A moving body and its joint.
#[derive(Debug, Serialize)]
struct SceneBody {
    parent: Option<usize>,
    /// The pose `X_PJ` of the joint in the parent; of a joint that has no slider, that of the body at the neutral configuration.
    placement: Pose,
    /// `turn` about z, `slide` along z, `screw` for both, or `still`.
    motion: &'static str,
    /// Advance of a screw, m/rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pitch: Option<f64>,
    /// The slider that moves it: position = ratio · slider + offset.
    slider: Option<Slider>,
    com: [f64; 3],
    /// The solid ellipsoid of its mass and inertia: its centre and axes, and their half lengths.
    ellipsoid: Option<(Pose, [f64; 3])>,
    mass: f64,
}

/// Slider that moves a joint by hand.
#[derive(Debug, Serialize)]
struct Slider {
    /// The coordinate in q.
    coordinate: usize,
    ratio: f64,
    offset: f64,
    /// Coordinate of the joint; `None` for a mimic joint.
    own: Option<Own>,
}

#[derive(Debug, Serialize)]
struct Own {
    name: String,
    lower: f64,
    upper: f64,
    unit: &'static str,
}

#[derive(Debug, Serialize)]
struct SceneFrame {
    name: String,
    body: Option<usize>,
    pose: Pose,
}

/// A line of the tree.
#[derive(Debug, Serialize)]
struct Link {
    name: String,
    /// Number of links above it.
    depth: usize,
    /// The joint that carries it.
    joint: Option<String>,
    frame: usize,
}

/// Sliders of joints without limits: once around, or a metre.
const FREE_RANGE: [f64; 2] = [std::f64::consts::PI, 1.0];

pub(super) fn robot(track: &Track, meshes: &mut Meshes) -> Robot {
    let model = &track.model;
    let frame = |id: &FrameId| id.0;
    Robot {
        name: track.name.clone(),
        placement: pose(&track.placement),
        bodies: (0..model.n_bodies()).map(|i| body(model, i)).collect(),
        shapes: shapes(model, meshes),
        frames: frames(model),
        traces: track.traces.iter().map(frame).collect(),
        shown: track.frames.iter().map(frame).collect(),
        bonds: track.bonds.clone(),
        links: links(model),
    }
}

fn body(model: &Model, i: usize) -> SceneBody {
    let body = &model.bodies()[i];
    let motion = match body.joint {
        JointKind::Revolute | JointKind::Continuous => "turn",
        JointKind::Prismatic => "slide",
        JointKind::Screw(_) => "screw",
        _ => "still",
    };
    let X_PJ = match motion {
        "still" => body.place(model.neutral().as_slice()),
        _ => body.placement,
    };
    SceneBody {
        parent: body.parent.map(|parent| parent.0),
        placement: pose(&X_PJ),
        motion,
        pitch: match body.joint {
            JointKind::Screw(pitch) => Some(pitch.metres_per_radian()),
            _ => None,
        },
        slider: (motion != "still").then(|| slider(model, i)),
        com: body.inertia.com().into(),
        ellipsoid: ellipsoid(body),
        mass: body.inertia.mass,
    }
}

fn slider(model: &Model, i: usize) -> Slider {
    let body = &model.bodies()[i];
    let (ratio, offset) = body.coupling.map_or((1.0, 0.0), |c| (c.ratio, c.offset));
    let part = model
        .joint_parts()
        .find(|part| part.body == BodyId(i) && body.coupling.is_none());
    let own = part.zip(model.part_name(BodyId(i))).map(|(part, name)| {
        let limits = part.limits;
        let is_sliding = body.joint == JointKind::Prismatic;
        let free = FREE_RANGE[usize::from(is_sliding)];
        Own {
            name,
            lower: limits.lower.unwrap_or(-free),
            upper: limits.upper.unwrap_or(free),
            unit: if is_sliding { "m" } else { "rad" },
        }
    });
    Slider {
        coordinate: body.q,
        ratio,
        offset,
        own,
    }
}

/// The solid ellipsoid with the mass and inertia of a body: moments Iᵢ = m (rⱼ² + rₖ²) / 5 about its axes, so
/// rᵢ² = 5 (Iⱼ + Iₖ − Iᵢ) / 2m.
fn ellipsoid(body: &Body<f64>) -> Option<(Pose, [f64; 3])> {
    let m = body.inertia.mass;
    if m <= 0.0 {
        return None;
    }
    let (moments, axes) = symmetric_eigen3(&body.inertia.about_com().to_matrix())?;
    let half = moments.sum() / 2.0;
    // Rounding can make the radius of a thin rod the root of a negative number.
    let radii = moments.map(|moment| (5.0 * (half - moment) / m).max(0.0).sqrt());
    let axes = right_handed(axes);
    Some((
        pose(&Transform::new(axes, body.inertia.com())),
        radii.into(),
    ))
}

fn right_handed(mut axes: Matrix3<f64>) -> Matrix3<f64> {
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    axes
}

fn frames(model: &Model) -> Vec<SceneFrame> {
    let frames = model.frames().iter().map(|frame| SceneFrame {
        name: frame.name.clone(),
        body: frame.body.map(|body| body.0),
        pose: pose(&frame.placement),
    });
    frames.collect()
}

fn links(model: &Model) -> Vec<Link> {
    let builder = model.to_builder();
    let steps = builder.walk();
    let links = steps.iter().map(|step| Link {
        name: step.link.name.clone(),
        depth: step.depth,
        joint: step
            .joint
            .map(|joint| format!("{}: {}", &joint.name, joint.kind)),
        frame: model.frame(&step.link.name).map_or(0, |frame| frame.0),
    });
    links.collect()
}

/// The visuals of each member; of one without the collisions; of one with neither a skeleton.
pub(super) fn shapes(model: &Model, meshes: &mut Meshes) -> Vec<Shape> {
    let member_of_link = members(model);
    let n = member_of_link.last().map_or(0, |last| last + 1);
    let (mut shown, mut touching) = (vec![false; n], vec![false; n]);
    for (link, &member) in model.links().iter().zip(&member_of_link) {
        shown[member] |= !link.visuals.is_empty();
        touching[member] |= !link.collisions.is_empty();
    }
    let mut shapes = Vec::new();
    for (link, &member) in model.links().iter().zip(&member_of_link) {
        let frame = &model.frames()[link.frame.0];
        let owner = format!("{}, link \"{}\"", model.name(), frame.name);
        let visuals = link.visuals.iter();
        let visuals = visuals.map(|v| (&v.placement, &v.geometry, v.color));
        let collisions = link.collisions.iter().filter(|_| !shown[member]);
        let collisions = collisions.map(|c| (&c.placement, &c.geometry, None));
        for (placement, geometry, color) in visuals.chain(collisions) {
            for (X, piece, own) in meshes.pieces(&owner, geometry) {
                shapes.push(Shape {
                    body: frame.body.map(|body| body.0),
                    pose: pose(&(frame.placement * *placement * X)),
                    color: color.or(own),
                    piece,
                });
            }
        }
    }
    let member_of_body = of_bodies(model, &member_of_link);
    let bare = (0..n).filter(|&member| !shown[member] && !touching[member]);
    shapes.extend(bare.nested(|member| skeleton(model, &|body| member_of_body[body] == member)));
    shapes
}

/// The member of each link: 0 for the root and a single robot, then the members on a root `world` in sequence.
fn members(model: &Model) -> Vec<usize> {
    let builder = model.to_builder();
    let steps = builder.walk();
    let is_world = steps.first().is_some_and(|step| step.link.name == WORLD);
    let mut member = 0;
    let mut of = |depth: usize| {
        member += usize::from(is_world && depth == 1);
        member
    };
    steps.iter().map(|step| of(step.depth)).collect()
}

/// The member of each body: that of its links, or of those that it carries.
fn of_bodies(model: &Model, member_of_link: &[usize]) -> Vec<usize> {
    let mut out = vec![None; model.n_bodies()];
    for (link, &member) in model.links().iter().zip(member_of_link) {
        if let Some(body) = model.frames()[link.frame.0].body {
            out[body.0] = Some(member);
        }
    }
    let mut next = 0;
    for member in out.iter_mut().rev() {
        next = *member.get_or_insert(next);
    }
    out.into_iter().map(Option::unwrap_or_default).collect()
}
