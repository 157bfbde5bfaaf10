//! Forces on bodies from outside the tree: contact forces, forces on frames, and forces of constraints between attachment frames.

use crate::constraint::{CarrierMotion, Constraint};
use crate::dynamics::Kinematics;
use crate::model::{BodyId, FrameId};
use crate::scalar::{MapEach, Over, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrators::AccelerationScratch;
use crate::sim::simulator::Simulator;
use crate::spatial::{Force, Motion};

/// Whether there may be any.
pub(super) fn has_exterior_forces<P: Scalar>(simulator: &Simulator<P>) -> bool {
    let has_own = simulator.contacts().is_some() || !simulator.constraints().is_empty();
    has_own || !simulator.frame_terms().is_empty()
}

/// Hands each force on a body, in the body, with the frame that it is on, to `each`.
///
/// * `kinematics` – poses and velocities of all bodies
pub(super) fn each_exterior_force<P: Scalar, T: Over<P>>(
    at: &EvaluationPoint<'_, P, T>,
    found: &AccelerationScratch<T>,
    kinematics: &Kinematics<T>,
    mut each: impl FnMut(Option<FrameId>, Option<BodyId>, Force<T>),
) {
    if let Some(contacts) = at.simulator.contacts() {
        let contact = &found.terms.contact;
        contact.each_force(contacts, |link, body, force| each(Some(link), body, force));
    }
    each_frame_force(at, found, kinematics, &mut each);
    if !at.simulator.constraints().is_empty() {
        each_constraint_force(at, found, kinematics, &mut each);
    }
}

/// External forces, and those of actuators on frames.
fn each_frame_force<P: Scalar, T: Over<P>>(
    at: &EvaluationPoint<'_, P, T>,
    found: &AccelerationScratch<T>,
    kinematics: &Kinematics<T>,
    each: &mut impl FnMut(Option<FrameId>, Option<BodyId>, Force<T>),
) {
    let u = at.simulator.frame_inputs(at.u);
    for term in at.simulator.frame_terms().iter() {
        let mounted = term.place().mounted(at.model());
        let body = mounted.body;
        let own = term.input().map_or(T::zero(), |input| u[input]);
        let (pose, velocity) = (kinematics.pose(body), kinematics.velocity(body));
        let rows = found.balance.as_deref().map(|balance| balance.rows());
        let along = found.terms.frame_servos.force(at, &term, rows);
        let force = term.body_force(&mounted.X_BA, &pose, &velocity, own, along);
        each(term.place().frame, body, force);
    }
}

/// Forces of constraints on both bodies that carry their anchors.
fn each_constraint_force<P: Scalar, T: Over<P>>(
    at: &EvaluationPoint<'_, P, T>,
    found: &AccelerationScratch<T>,
    kinematics: &Kinematics<T>,
    each: &mut impl FnMut(Option<FrameId>, Option<BodyId>, Force<T>),
) {
    let Some(balance) = found.balance.as_deref() else {
        return;
    };
    let constraints = at.simulator.constraints();
    let solved = balance.rows().first_forces(at.simulator.bilateral_rows());
    let mut forces = found.terms.constraints.forces(at, solved).into_iter();
    for constraint in constraints {
        let mut own = forces.by_ref().take(Constraint::rows(constraint));
        let [first, second] = constraint.kind().anchors() else {
            own.for_each(drop);
            continue;
        };
        let anchors = [first, second];
        let mounted = anchors.map_each(|anchor| anchor.mounted(at.model()));
        let bodies = mounted.map_each(|on| carrier(kinematics, on.body));
        constraint.each_carried_row(&mounted, &bodies, at.dt().into(), |row| {
            let force = own.next().unwrap_or_else(T::zero);
            for (side, unit) in row.unit_forces.iter().enumerate() {
                each(anchors[side].frame, mounted[side].body, unit.scaled(force));
            }
        });
    }
}

/// A body as what carries an anchor; its acceleration does not matter to unit forces.
fn carrier<T: Scalar>(kinematics: &Kinematics<T>, body: Option<BodyId>) -> CarrierMotion<T> {
    CarrierMotion {
        X_WB: kinematics.pose(body),
        V: kinematics.velocity(body),
        bias: Motion::zero(),
        U: Motion::zero(),
    }
}
