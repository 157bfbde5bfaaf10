//! Parameters of a description, over any scalar.

use super::ModelBuilder;
use crate::scalar::Scalar;
use crate::spatial::{Inertia, Transform};

/// Inertias and poses of a description, in the order of its parts.
#[derive(Clone, Debug)]
pub(super) struct Numbers<T> {
    /// Of each link, in its own frame.
    pub(super) inertias: Vec<Inertia<T>>,
    /// Of each joint, in its parent link.
    pub(super) placements: Vec<Transform<T>>,
    /// Of each added frame, in its link.
    pub(super) frames: Vec<Transform<T>>,
}

impl<T: Scalar> Numbers<T> {
    /// The parameters of the description.
    pub(super) fn of(builder: &ModelBuilder) -> Self {
        let links = builder.links.iter();
        let joints = builder.joints.iter();
        let frames = builder.frames.iter();
        Self {
            inertias: links.map(|link| link.inertia.lift()).collect(),
            placements: joints.map(|joint| joint.placement.lift()).collect(),
            frames: frames.map(|frame| frame.placement.lift()).collect(),
        }
    }
}

impl Numbers<f64> {
    /// Puts them into a description of the same parts.
    pub(super) fn put_into(self, builder: &mut ModelBuilder) {
        for (link, inertia) in builder.links.iter_mut().zip(self.inertias) {
            link.inertia = inertia;
        }
        for (joint, placement) in builder.joints.iter_mut().zip(self.placements) {
            joint.placement = placement;
        }
        for (frame, placement) in builder.frames.iter_mut().zip(self.frames) {
            frame.placement = placement;
        }
    }
}
