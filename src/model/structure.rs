//! Comparison of the structures of robots, without their parameters.

use std::hash::{DefaultHasher, Hash, Hasher};

use super::{Body, BodyId, Frame, Joint, Model};
use crate::error::StructureMismatch;
use crate::joint::JointKind;
use crate::scalar::Scalar;

/// Structure of a robot without parameters: names and kinds of joints, names of frames, and their tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Structure(u64);

impl Structure {
    /// # Panics
    /// If `what` belongs to a robot of another structure.
    pub(crate) fn check<P>(self, model: &Model<P>, what: &str) {
        assert!(
            self == model.structure,
            "{what} belong to another robot than \"{}\": its joints, links or frames are others",
            model.name
        );
    }
}

/// The hash of the content that [`Model::check_structure`] compares: names, kinds and positions in the tree, without parameters of type `P`.
pub(super) fn fingerprint<P>(
    bodies: &[Body<P>],
    joints: &[Joint],
    frames: &[Frame<P>],
) -> Structure {
    let mut out = DefaultHasher::new();
    for body in bodies {
        let follows = body.coupling.is_some();
        (body.parent, body.joint, body.q, body.v, follows).hash(&mut out);
    }
    let joints = joints.iter().map(|joint| (&joint.name, joint.body));
    let frames = frames.iter().map(|frame| (&frame.name, frame.body));
    joints.for_each(|joint| joint.hash(&mut out));
    frames.for_each(|frame| frame.hash(&mut out));
    Structure(out.finish())
}

impl<P> Model<P> {
    /// Identity of the robot's structure within this program: equal for a robot and its variants, which differ in
    /// numbers only; different for robots with other names, joint kinds or trees, of whatever size.
    #[inline]
    pub(crate) fn structure(&self) -> Structure {
        self.structure
    }
}

impl<P: Scalar> Model<P> {
    /// Checks that another model, the one at `index` of a list, differs from this one in numbers only.
    pub(crate) fn check_structure<Q: Scalar>(
        &self,
        other: &Model<Q>,
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

    fn first_difference<Q: Scalar>(&self, other: &Model<Q>) -> Option<String> {
        differing("bodies", self.n_bodies(), other.n_bodies())
            .or_else(|| differing("velocity coordinates", self.nv(), other.nv()))
            .or_else(|| differing("joints", self.n_joints(), other.n_joints()))
            .or_else(|| differing("frames", self.frames.len(), other.frames.len()))
            .or_else(|| self.first_joint_difference(other))
            .or_else(|| self.first_body_difference(other))
            .or_else(|| self.first_weight_difference(other))
            .or_else(|| self.first_frame_difference(other))
    }

    fn first_joint_difference<Q: Scalar>(&self, other: &Model<Q>) -> Option<String> {
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

    /// Kinds and positions in the tree, and mimic joints.
    fn first_body_difference<Q: Scalar>(&self, other: &Model<Q>) -> Option<String> {
        let pairs = self.bodies.iter().zip(&other.bodies).enumerate();
        for (i, (own, theirs)) in pairs {
            let name = other.body_name(BodyId(i));
            if place(own) != place(theirs) {
                return Some(format!(
                    "body {i}, \"{name}\", has another place in the tree"
                ));
            }
            if own.coupling.is_some() != theirs.coupling.is_some() {
                return Some(format!(
                    "the joint of body {i}, \"{name}\", mimics another joint in only one of them"
                ));
            }
        }
        None
    }

    /// Bodies that gravity does not act on, or on parts of.
    fn first_weight_difference<Q: Scalar>(&self, other: &Model<Q>) -> Option<String> {
        let own = self.weightless.iter().map(|part| part.body);
        let theirs = other.weightless.iter().map(|part| part.body);
        (!own.eq(theirs)).then(|| "gravity acts on different links".to_owned())
    }

    fn first_frame_difference<Q: Scalar>(&self, other: &Model<Q>) -> Option<String> {
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

/// Place of a body in the tree, and its joint.
fn place<P>(b: &Body<P>) -> (Option<BodyId>, JointKind, [usize; 3]) {
    (b.parent, b.joint, [b.q, b.v, b.subtree_end])
}

fn differing(what: &str, expected: usize, given: usize) -> Option<String> {
    (given != expected).then(|| format!("it has {given} {what}, not {expected}"))
}

#[cfg(test)]
mod tests {
    use crate::model::samples;

    #[test]
    fn identity_of_a_variant_is_that_of_the_robot_and_of_no_other_of_the_same_size() {
        let model = samples::double_pendulum();
        let variant = model.clone().with_damping(0, 0.3);
        assert_eq!(model.structure(), variant.structure());
        assert_eq!(model.structure(), samples::double_pendulum().structure());
        let lifted = model.cast::<num_dual::Dual64>();
        assert_eq!(model.structure(), lifted.structure());
        let other = samples::cartpole();
        assert_eq!((model.nq(), model.nv()), (other.nq(), other.nv()));
        assert_ne!(model.structure(), other.structure());
    }
}
