//! Walks along the tree that algorithms share.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::iter::successors;

use crate::model::{Body, BodyId, FrameId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Motion, Transform};

/// The bodies from one of them, or from nowhere, to the world.
#[inline(always)]
pub(crate) fn to_world<P: Scalar>(
    model: &Model<P>,
    start: Option<BodyId>,
) -> impl Iterator<Item = (BodyId, &Body<P>)> {
    let bodies = successors(start, |&id| model.body(id).parent);
    bodies.map(|id| (id, model.body(id)))
}

/// Passes each body from the one that carries a frame to the world, and the pose `X_BF` of the frame in it, to `visit`.
/// Returns `X_WF`.
#[inline(always)]
pub(super) fn from_frame<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    frame: FrameId,
    mut visit: impl FnMut(&Body<P>, &Transform<T>),
) -> Transform<T> {
    let frame = model.frame_of(frame);
    let mut X_BF = frame.placement.lift::<T>();
    for (_, body) in to_world(model, frame.body) {
        visit(body, &X_BF);
        X_BF = body.place(q) * X_BF;
    }
    X_BF
}

/// Passes a force on a body to each body on the way to the world, seen from there.
///
/// * `X_PB` – the pose of each body in its parent
#[inline(always)]
pub(super) fn carry_force<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    X_PB: &[Transform<T>],
    on: BodyId,
    mut F: Force<T>,
    mut visit: impl FnMut(&Body<P>, &Force<T>),
) {
    for (id, body) in to_world(model, Some(on)) {
        visit(body, &F);
        F = X_PB[id.0].force(&F);
    }
}

/// The velocity of a body in its own frame from that of its parent, which `velocities` has at its index:  V = X⁻¹
/// `V_P` + S v.
#[inline(always)]
pub(super) fn velocity<P: Scalar, T: Over<P>>(
    body: &Body<P>,
    X_PB: &Transform<T>,
    v: &[T],
    velocities: impl Fn(BodyId) -> Motion<T>,
) -> Motion<T> {
    let V_P = body.parent.map_or_else(Motion::zero, velocities);
    let mut V = X_PB.motion_inverse(&V_P);
    body.add_motion(v, &mut V);
    V
}
