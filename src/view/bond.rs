//! Constraints as drawn in pictures, moving with their attachment frames.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::constraint::{Anchor, Constraint, ConstraintKind};
use crate::error::UnknownName;
use crate::model::{BodyId, Model};
use crate::scalar::MapEach;

/// A constraint between two attachment frames.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Bond {
    pub(super) kind: BondKind,
    pub(super) ends: [End; 2],
}

/// Drawing style of a constraint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum BondKind {
    Weld,
    Ball,
    Rod,
    Coupler,
}

/// An attachment frame on a body, or in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct End {
    pub(super) body: Option<usize>,
    /// Position in the frame of the body, m.
    pub(super) at: [f64; 3],
}

/// A constraint in a file, where bodies are named by their first link.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredBond {
    kind: BondKind,
    links: [Option<String>; 2],
    places: [[f64; 3]; 2],
}

impl Bond {
    /// The bonds of a constraint: one, or of a tendon one from each joint to the next.
    pub(super) fn all(model: &Model, constraint: &Constraint) -> Vec<Self> {
        let one = |kind, anchors: &[Anchor; 2]| {
            let ends = anchors.each_ref().map_each(|anchor| End::of(model, anchor));
            vec![Self { kind, ends }]
        };
        let tied = |bodies: &[BodyId]| {
            let pairs = bodies.windows(2).map(|pair| Self {
                kind: BondKind::Coupler,
                ends: [pair[0], pair[1]].map_each(End::joint),
            });
            pairs.collect()
        };
        match constraint.kind() {
            ConstraintKind::Weld(anchors) => one(BondKind::Weld, anchors),
            ConstraintKind::Ball(anchors) => one(BondKind::Ball, anchors),
            ConstraintKind::Distance { anchors, .. } => one(BondKind::Rod, anchors),
            ConstraintKind::Coupler { bodies, .. } => tied(bodies),
            ConstraintKind::Tendon { joints, .. } => tied(joints),
        }
    }

    pub(super) fn stored(&self, model: &Model) -> StoredBond {
        let link = |end: &End| {
            end.body
                .map(|body| model.body_name(BodyId(body)).to_owned())
        };
        StoredBond {
            kind: self.kind,
            links: self.ends.each_ref().map(link),
            places: self.ends.map_each(|end| end.at),
        }
    }

    pub(super) fn read(stored: StoredBond, model: &Model) -> Result<Self, UnknownName> {
        let StoredBond {
            kind,
            links: [first, second],
            places,
        } = stored;
        let end = |link: Option<String>, at| -> Result<End, UnknownName> {
            let frame = link.map(|link| model.find_frame(&link)).transpose()?;
            let body = frame.and_then(|frame| model.frames()[frame.0].body);
            let body = body.map(|body| body.0);
            Ok(End { body, at })
        };
        let ends = [end(first, places[0])?, end(second, places[1])?];
        Ok(Self { kind, ends })
    }
}

impl End {
    pub(super) fn of(model: &Model, anchor: &Anchor) -> Self {
        let mounted = anchor.mounted(model);
        Self {
            body: mounted.body.map(|body| body.0),
            at: mounted.X_BA.translation.into(),
        }
    }

    /// The position of the joint of a body.
    fn joint(body: BodyId) -> Self {
        Self {
            body: Some(body.0),
            at: Vector3::zeros().into(),
        }
    }
}
