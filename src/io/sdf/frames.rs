//! Pose of every frame, and the link that carries it.
//!
//! Models are solved from the inside out: the frames in a model M have poses `X_MF` in its own frame, and a reference
//! into a nested model N passes through N's frame. A model with a placement frame P is where `X_RN = X_RP X_PN`, if R
//! is what its pose is relative to and `X_RP` that pose. All chains are walked with explicit stacks.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::scene::{FrameKind, ModelEntry, Nesting, Pose, Scene, WORLD};
use crate::error::LoadError;
use crate::io::place::SourcePlace;
use crate::nested::IntoNested;
use crate::scalar::MapEach;
use crate::spatial::Transform;

/// All frames of a robot in the world, and what carries them.
#[derive(Debug)]
pub(super) struct Placements {
    /// Pose of each frame in the world.
    pub(super) X_WF: Vec<Transform<f64>>,
    /// Link that carries each frame, or `None` for the world.
    pub(super) link: Vec<Option<usize>>,
}

impl Placements {
    /// Solves all models; of the world, only what places the robot.
    pub(super) fn new(scene: &Scene, robot: usize) -> Result<Self, LoadError> {
        let mut solver = Solver {
            scene,
            X_MF: vec![None; scene.frames.len()],
            is_open: vec![false; scene.frames.len()],
        };
        for model in (robot..scene.models.len()).rev() {
            for &frame in &scene.models[model].members {
                solver.solve(frame)?;
            }
        }
        // The surroundings of the robot were read before it; models joined to it were read after it.
        let start = scene.models[robot].frame;
        let in_world = &scene.models[WORLD].members;
        for &frame in in_world.iter().filter(|&&frame| frame >= start) {
            solver.solve(frame)?;
        }
        Ok(Self {
            X_WF: solver.in_world(),
            link: carriers(scene, robot)?,
        })
    }

    /// The pose of a part of a link in the frame of the link.
    pub(super) fn in_link(
        &self,
        scene: &Scene,
        link: usize,
        pose: &Pose,
        place: &SourcePlace,
    ) -> Result<Transform<f64>, LoadError> {
        let own = scene.links[link].frame;
        match &pose.relative_to {
            None => Ok(pose.value),
            Some(name) => {
                let frame = scene.resolve(scene.frames[own].scope, name, place)?;
                Ok(self.X_WF[own].inverse() * self.X_WF[frame] * pose.value)
            }
        }
    }
}

struct Solver<'s> {
    scene: &'s Scene,
    /// Pose of each frame in the model around it.
    X_MF: Vec<Option<Transform<f64>>>,
    is_open: Vec<bool>,
}

/// Reference frame that a frame's pose is relative to.
struct Reference {
    /// A frame beside it; `None` is that of the model around.
    frame: Option<usize>,
    /// The pose of the reference in that frame.
    X_FR: Transform<f64>,
}

impl Solver<'_> {
    /// Follows the references of a frame to one that is known, and comes back with the poses.
    fn solve(&mut self, frame: usize) -> Result<(), LoadError> {
        let mut chain: Vec<(usize, Reference)> = Vec::new();
        let mut next = Some(frame);
        while let Some(frame) = next
            && self.X_MF[frame].is_none()
        {
            if std::mem::replace(&mut self.is_open[frame], true) {
                return Err(self.scene.frames[frame].place.cycle());
            }
            let reference = self.reference(frame)?;
            next = reference.frame;
            chain.push((frame, reference));
        }
        while let Some((frame, reference)) = chain.pop() {
            let known = reference.frame.and_then(|frame| self.X_MF[frame]);
            let X_MR = known.map_or(reference.X_FR, |X_MF| X_MF * reference.X_FR);
            self.X_MF[frame] = Some(X_MR * self.own_pose(frame)?);
        }
        Ok(())
    }

    fn reference(&self, frame: usize) -> Result<Reference, LoadError> {
        let scene = self.scene;
        let entry = &scene.frames[frame];
        let default = match &entry.kind {
            FrameKind::Model(_) | FrameKind::Link(_) => "__model__",
            FrameKind::Joint(joint) => &scene.joints[*joint].child,
            FrameKind::Free(attached_to) => attached_to.as_deref().unwrap_or("__model__"),
        };
        let name = entry.pose.relative_to.as_deref().unwrap_or(default);
        let target = scene.resolve(entry.scope, name, &entry.place)?;
        if target == scene.models[entry.scope].frame {
            return Ok(Reference {
                frame: None,
                X_FR: Transform::identity(),
            });
        }
        let (frame, X_FR) = self
            .climb(entry.scope, target)
            .ok_or_else(|| entry.place.unknown(name))?;
        Ok(Reference {
            frame: Some(frame),
            X_FR,
        })
    }

    /// The frame in a scope that holds a frame further inside, with the pose of that one in it.
    fn climb(&self, scope: usize, inner: usize) -> Option<(usize, Transform<f64>)> {
        let scene = self.scene;
        let (mut frame, mut X_FR) = (inner, Transform::identity());
        while scene.frames[frame].scope != scope {
            if frame == WORLD {
                return None;
            }
            X_FR = self.X_MF[frame]? * X_FR;
            frame = scene.models[scene.frames[frame].scope].frame;
        }
        // The world has no surroundings.
        (frame != WORLD).then_some((frame, X_FR))
    }

    /// The pose of a frame in what it is relative to.
    fn own_pose(&self, frame: usize) -> Result<Transform<f64>, LoadError> {
        let entry = &self.scene.frames[frame];
        let FrameKind::Model(model) = entry.kind else {
            return Ok(entry.pose.value);
        };
        let Some(name) = &self.scene.models[model].placement_frame else {
            return Ok(entry.pose.value);
        };
        let placed = self.scene.resolve(model, name, &entry.place)?;
        if placed == self.scene.models[model].frame {
            return Ok(entry.pose.value);
        }
        let place = self.climb(model, placed);
        let X_NP = place.and_then(|(frame, X_FP)| Some(self.X_MF[frame]? * X_FP));
        let X_NP = X_NP.ok_or_else(|| entry.place.unknown(name))?;
        Ok(entry.pose.value * X_NP.inverse())
    }

    /// The poses in the world, from the outside in.
    fn in_world(&self) -> Vec<Transform<f64>> {
        let scene = self.scene;
        let mut X_WF = vec![Transform::identity(); scene.frames.len()];
        for model in &scene.models {
            for &frame in &model.members {
                let X_MF = self.X_MF[frame].unwrap_or_else(Transform::identity);
                X_WF[frame] = X_WF[model.frame] * X_MF;
            }
        }
        X_WF
    }
}

/// The link that carries each frame of the robot, and each frame around it that a joint is at.
fn carriers(scene: &Scene, robot: usize) -> Result<Vec<Option<usize>>, LoadError> {
    let mut known = vec![None; scene.frames.len()];
    let mut is_open = vec![false; scene.frames.len()];
    known[WORLD] = Some(None);
    let ends = scene.joints.iter().nested(|joint| {
        let scope = scene.frames[joint.frame].scope;
        [&joint.parent, &joint.child].map_each(|name| scene.find(scope, name))
    });
    let start = scene.models[robot].frame;
    for frame in (start..scene.frames.len()).chain(ends.flatten()) {
        let (mut chain, mut at) = (Vec::new(), frame);
        let carrier = loop {
            if let Some(carrier) = known[at] {
                break carrier;
            }
            if std::mem::replace(&mut is_open[at], true) {
                return Err(scene.frames[at].place.cycle());
            }
            chain.push(at);
            match step(scene, at)? {
                Step::Link(link) => break Some(link),
                Step::Frame(next) => at = next,
            }
        };
        chain
            .into_iter()
            .for_each(|frame| known[frame] = Some(carrier));
    }
    Ok(known.into_iter().map(Option::flatten).collect())
}

/// Link or frame that a frame is attached to.
enum Step {
    Link(usize),
    Frame(usize),
}

fn step(scene: &Scene, frame: usize) -> Result<Step, LoadError> {
    let entry = &scene.frames[frame];
    let to = |name: &str| {
        scene
            .resolve(entry.scope, name, &entry.place)
            .map(Step::Frame)
    };
    match &entry.kind {
        FrameKind::Link(link) => Ok(Step::Link(*link)),
        FrameKind::Joint(joint) => to(&scene.joints[*joint].child),
        FrameKind::Free(attached_to) => to(attached_to.as_deref().unwrap_or("__model__")),
        FrameKind::Model(model) => canonical(scene, *model, &entry.place),
    }
}

/// Link or frame that a model's own frame is attached to: its canonical link, by default its first, or else its first
/// nested model.
fn canonical(scene: &Scene, index: usize, place: &SourcePlace) -> Result<Step, LoadError> {
    let model = &scene.models[index];
    if model.is_static {
        return Ok(Step::Frame(WORLD));
    }
    if let Some(name) = &model.canonical_link {
        return scene.resolve(index, name, place).map(Step::Frame);
    }
    let is_model = |frame: usize| matches!(scene.frames[frame].kind, FrameKind::Model(_));
    let mut members = model.members.iter().copied();
    let first_link = members.clone().find(|&frame| brings_link(scene, frame));
    first_link
        .or_else(|| members.find(|&frame| is_model(frame)))
        .map(Step::Frame)
        .ok_or_else(|| place.missing("link"))
}

/// `true` for a link, and for a merged model with one.
fn brings_link(scene: &Scene, frame: usize) -> bool {
    match scene.frames[frame].kind {
        FrameKind::Link(_) => true,
        FrameKind::Model(model) => {
            let ModelEntry {
                nesting, members, ..
            } = &scene.models[model];
            *nesting == Nesting::Merged && members.iter().any(|&frame| brings_link(scene, frame))
        }
        FrameKind::Joint(_) | FrameKind::Free(_) => false,
    }
}
