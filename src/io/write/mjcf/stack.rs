//! Links without inertia between joints. `MuJoCo` has no such bodies, but several joints on a body: those of such links are joints of the body that they carry.

use std::collections::{HashMap, HashSet};

use super::Writer;
use crate::joint::JointKind;
use crate::model::walk::Step;
use crate::model::{JointSpec, Model, ModelBuilder};
use crate::spatial::{Inertia, Transform};

/// Most degrees of freedom of a body there.
const MOST: usize = 6;

/// Name of the link that the reader makes between two joints of a body.
fn between(joint: &JointSpec) -> String {
    format!("{}::link", joint.name)
}

/// Names of the links whose joints the body of the next link has.
pub(super) fn stacked<'a>(
    model: &Model<f64>,
    builder: &'a ModelBuilder,
    has_frame: &impl Fn(&str) -> bool,
) -> HashSet<&'a str> {
    let steps = builder.walk();
    let carried = carried(&steps);
    let massless = massless(model);
    let mut counts: HashMap<&str, usize> = HashMap::new();
    for step in &steps {
        let (Some(joint), [next]) = (step.joint, carried_by(&carried, &step.link.name)) else {
            continue;
        };
        let below = counts.get(joint.parent.as_str()).copied().unwrap_or(0);
        let count = below + freedom(joint);
        let name = step.link.name.as_str();
        let is_bare = step.link.visuals.is_empty() && step.link.collisions.is_empty();
        let fits = can_be_first(joint.kind) && count + freedom(next) <= MOST;
        if massless.contains(name) && is_bare && !has_frame(name) && fits {
            counts.insert(name, count);
        }
    }
    counts.into_keys().collect()
}

/// Joints by the link that carries them.
fn carried<'a>(steps: &[Step<'a>]) -> HashMap<&'a str, Vec<&'a JointSpec>> {
    let mut out: HashMap<&str, Vec<&JointSpec>> = HashMap::new();
    for joint in steps.iter().filter_map(|step| step.joint) {
        out.entry(&joint.parent).or_default().push(joint);
    }
    out
}

fn carried_by<'m, 'a>(
    carried: &'m HashMap<&str, Vec<&'a JointSpec>>,
    link: &str,
) -> &'m [&'a JointSpec] {
    carried.get(link).map_or(&[], Vec::as_slice)
}

/// Names of the links on moving bodies without inertia, except for a floating base, whose free joint is alone.
fn massless(model: &Model<f64>) -> HashSet<&str> {
    let bases = usize::from(model.has_floating_base());
    let frames = model
        .links()
        .iter()
        .map(|link| &model.frames()[link.frame.0]);
    let bodies = frames.filter_map(|frame| Some((frame.body?, frame.name.as_str())));
    let massless =
        bodies.filter(|&(body, _)| body.0 >= bases && model.body(body).inertia == Inertia::zero());
    massless.map(|(_, name)| name).collect()
}

/// Whether other joints can follow on the same body: there is none after a ball, and a free joint is alone.
fn can_be_first(kind: JointKind) -> bool {
    !matches!(kind, JointKind::Spherical | JointKind::Floating)
}

/// Degrees of freedom of the joints that it becomes.
fn freedom(joint: &JointSpec) -> usize {
    match joint.kind {
        JointKind::Screw(_) => 2,
        kind => kind.nv(),
    }
}

/// Joints whose links have no body, from the first on, with what carries the first.
#[derive(Debug, Default)]
pub(super) struct Pending<'a>(Vec<&'a JointSpec>);

impl<'a> Pending<'a> {
    pub(super) fn push(&mut self, joint: &'a JointSpec) {
        self.0.push(joint);
    }
}

impl<'a> Writer<'a> {
    /// The joints of a body, the first one first, each with its frame in the body, and the pose of the body.
    pub(super) fn joints_of(
        &mut self,
        last: &'a JointSpec,
    ) -> (Vec<(&'a JointSpec, Transform<f64>)>, Transform<f64>) {
        let mut joints = std::mem::take(&mut self.pending.0);
        for joint in &joints {
            if joint.child != between(joint) {
                self.xml.comment(&format!("left out: the link {}, which has no inertia: its joint is one of the next body", joint.child));
            }
        }
        joints.push(last);
        let mut to_body = Transform::identity();
        let mut placed = Vec::with_capacity(joints.len());
        for joint in joints.into_iter().rev() {
            placed.push((joint, to_body.inverse()));
            to_body = joint.placement * to_body;
        }
        placed.reverse();
        (placed, to_body)
    }
}
