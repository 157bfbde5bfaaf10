//! Whether two robots differ in numbers only.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use super::{Body, BodyId, Model};
use crate::error::StructureMismatch;
use crate::scalar::Scalar;

/// What all robots have in common that differ in numbers only: names and kinds of joints, names of frames, and how they hang together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Structure(u64);

impl Structure {
    /// # Panics
    /// If `what` belongs to a robot of another structure.
    pub(crate) fn check<P: Scalar>(self, model: &Model<P>, what: &str) {
        assert!(
            self == model.structure(),
            "{what} belong to another robot than \"{}\": its joints, links or frames are others",
            model.name
        );
    }
}

impl<P: Scalar> Model<P> {
    /// What it has in common with robots that differ in numbers only.
    pub(crate) fn structure(&self) -> Structure {
        let mut hasher = DefaultHasher::new();
        for body in &self.bodies {
            (body.parent, body.joint, body.q, body.v).hash(&mut hasher);
        }
        for joint in &self.joints {
            (&joint.name, joint.body, joint.kind).hash(&mut hasher);
        }
        for frame in &self.frames {
            (&frame.name, frame.body).hash(&mut hasher);
        }
        Structure(hasher.finish())
    }
}

impl Model {
    /// Checks that another model, the one at `index` of a list, differs from this one in numbers only.
    pub(crate) fn check_structure(
        &self,
        other: &Self,
        index: usize,
    ) -> Result<(), StructureMismatch> {
        self.first_difference(other).map_or(Ok(()), |difference| {
            Err(StructureMismatch {
                index,
                model: other.name.clone(),
                difference,
            })
        })
    }

    fn first_difference(&self, other: &Self) -> Option<String> {
        differing("bodies", self.n_bodies(), other.n_bodies())
            .or_else(|| differing("velocity coordinates", self.nv(), other.nv()))
            .or_else(|| differing("joints", self.n_joints(), other.n_joints()))
            .or_else(|| differing("frames", self.frames.len(), other.frames.len()))
            .or_else(|| self.first_joint_difference(other))
            .or_else(|| self.first_body_difference(other))
            .or_else(|| self.first_frame_difference(other))
    }

    fn first_joint_difference(&self, other: &Self) -> Option<String> {
        let pairs = self.joints.iter().zip(&other.joints).enumerate();
        let mut differing = pairs.filter(|(_, (own, other))| {
            (&own.name, own.body, own.kind) != (&other.name, other.body, other.kind)
        });
        differing.next().map(|(k, (own, other))| {
            format!(
                "joint {k} is \"{}\" ({}) on body {}, not \"{}\" ({}) on body {}",
                other.name, other.kind, other.body.0, own.name, own.kind, own.body.0
            )
        })
    }

    /// Kinds and places in the tree; a follower's ratio and offset belong to the structure, as they are not numbers of type `P`.
    fn first_body_difference(&self, other: &Self) -> Option<String> {
        let structure = |b: &Body<f64>| (b.parent, b.joint, b.q, b.v, b.subtree_end);
        let pairs = self.bodies.iter().zip(&other.bodies).enumerate();
        for (i, (own, theirs)) in pairs {
            let name = other.body_name(BodyId(i));
            if structure(own) != structure(theirs) {
                return Some(format!("body {i}, \"{name}\", hangs elsewhere in the tree"));
            }
            if own.coupling != theirs.coupling {
                return Some(format!(
                    "the joint of body {i}, \"{name}\", follows another one by {:?}, not by {:?}",
                    theirs.coupling, own.coupling
                ));
            }
        }
        None
    }

    fn first_frame_difference(&self, other: &Self) -> Option<String> {
        let pairs = self.frames.iter().zip(&other.frames).enumerate();
        let mut differing =
            pairs.filter(|(_, (own, other))| (&own.name, own.body) != (&other.name, other.body));
        differing.next().map(|(k, (own, other))| {
            format!(
                "frame {k} is \"{}\", not \"{}\", or is on another body",
                other.name, own.name
            )
        })
    }
}

fn differing(what: &str, expected: usize, given: usize) -> Option<String> {
    (given != expected).then(|| format!("it has {given} {what}, not {expected}"))
}
