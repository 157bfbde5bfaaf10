//! Contribution of contact points to the gradient of a step.
//!
//! As in the Jacobians, one evaluation on dual numbers in pose and velocity of the body gives the derivatives of a point; weighted, they are a
//! force on the body that the common sweep carries to the world.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::point::{LinearizedPoint, PointDual};
use super::rows::Contact;
use crate::contact::{Contacts, ROWS};
use crate::dynamics::Sweep;
use crate::sim::simulator::Simulator;
use crate::sim::terms::adjoint::{AdjointPoint, StepSlopes, TermAdjoint};

/// The gradient of the term; it needs no memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactAdjoint;

impl ContactAdjoint {
    pub(crate) fn new(_: &Simulator) -> Self {
        Self
    }
}

/// Adds the derivatives of a number of a point to those of its body and of its bristle.
fn add_point(
    point: usize,
    x: &PointDual,
    (contacts, sweep): (&Contacts, &mut Sweep<f64>),
    out: &mut StepSlopes<'_>,
) {
    let body = &mut sweep.bodies[contacts.points()[point].body.0];
    body.by_pose += x.in_pose();
    body.by_V += x.in_velocity();
    if contacts.have_bristles() {
        let own = &mut out.contact[ROWS * point..ROWS * (point + 1)];
        own.iter_mut()
            .zip(x.by_bristle())
            .for_each(|(own, x)| *own += x);
    }
}

impl TermAdjoint for ContactAdjoint {
    type Term = Contact<f64>;

    fn add_forces(
        &mut self,
        at: &AdjointPoint<'_>,
        term: &Contact<f64>,
        sweep: &mut Sweep<f64>,
        out: &mut StepSlopes<'_>,
    ) {
        let Some(contacts) = at.moment.explicit_contacts() else {
            return;
        };
        let (simulator, state) = (at.moment.simulator, at.moment.state);
        for (i, place) in contacts.points().iter().enumerate() {
            let id = Some(place.body);
            let (X_WB, V_B) = (term.kinematics.pose(id), term.kinematics.velocity(id));
            let point = LinearizedPoint::new(simulator, state, i, &X_WB, &V_B);
            let Some(own) = point.explicit_force(at.moment.is_instant) else {
                continue;
            };
            let W = sweep.bodies[place.body.0].W.to_array();
            let mut sum = PointDual::weighted(&own.force, &W.map(|x| -x));
            if let Some(weights) = at.by_contact.get(ROWS * i..ROWS * (i + 1)) {
                sum = sum.plus(&PointDual::weighted(&own.bristle_step, weights));
            }
            add_point(i, &sum, (contacts, sweep), out);
        }
    }
}
