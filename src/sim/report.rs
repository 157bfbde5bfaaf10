//! Report on contact and constraints at an instant, for a person or a picture.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::evaluation_point::EvaluationPoint;
use super::integrators::AccelerationScratch;
use super::simulator::Simulator;
use super::state::State;
use crate::cone::{Certificate, Mode};
use crate::contact::PointState;
use crate::contact::reason::{ContactReason, PointOutcome};
use crate::dynamics::Calls;
use crate::scalar::{Over, Scalar};
use crate::spatial::Force;
use crate::spatial::linear::dot;

/// Report on the points of contact, and on constraints, at an instant.
#[derive(Clone, Debug)]
pub struct ContactReport<T: Scalar = f64> {
    /// Positions, depths and velocities of the points.
    pub points: Vec<PointState<T>>,
    /// The force of the ground on each, in the world, N.
    pub forces: Vec<Vector3<T>>,
    /// The force of the ground on each link, in the frame of the link (N, N·m about its origin), in the order of
    /// [`Model::links`](crate::Model::links).
    pub links: Vec<Force<T>>,
    /// In which part of its law each point is, for rigid contact; in the first lane. Points that took no part are separated.
    pub modes: Vec<Mode>,
    /// Behaviour of each point, and so why a derivative is zero or is not.
    pub reasons: Vec<ContactReason>,
    /// The forces of kinematic constraints, row after row as in [`Simulator::constraint_errors`]: N, N·m, on the second anchor (and the
    /// opposite on the first), along what grows with the error.
    pub constraints: Vec<T>,
    /// Accuracy with which the forces of rigid contact and of constraints obey their laws.
    pub certificate: Certificate,
}

impl<P: Scalar> Simulator<P> {
    /// Reports on the points of contact, and on constraints, at a state with the input `u` (length `nu`; N·m or N). Allocates.
    ///
    /// # Panics
    /// If state or input have the wrong length.
    pub fn contact_report<T: Over<P>>(&self, state: &State<T>, u: &[T]) -> ContactReport<T> {
        self.check(state);
        let mut scratch = AccelerationScratch::new(self, Calls::One);
        if let Some(balance) = &mut scratch.balance {
            balance.measure();
        }
        let at = EvaluationPoint::of_step(self, state, u);
        self.accelerate(&at, &mut scratch);
        let contact = &scratch.terms.contact;
        let n = contact.points.len();
        let mut out = ContactReport {
            points: contact.points.clone(),
            forces: contact.forces.clone(),
            links: vec![Force::zero(); self.model().links().len()],
            modes: vec![Mode::Separated; n],
            reasons: Vec::with_capacity(n),
            constraints: Vec::new(),
            certificate: Certificate::default(),
        };
        if let Some(balance) = &scratch.balance {
            let modes = contact.modes(balance);
            modes.for_each(|(i, mode)| out.modes[i] = mode);
            let solved = balance.rows().first_forces(self.held_rows());
            out.constraints = scratch.terms.constraints.forces(&at, solved);
            out.certificate = balance.certificate();
        }
        if let Some(contacts) = self.contacts() {
            let dt = self.time_step().value(0);
            for (i, law) in contacts.laws().iter().enumerate() {
                let state = &out.points[i];
                out.reasons.push(law.reason(&PointOutcome {
                    state,
                    normal_force: dot(&state.normal, &out.forces[i]),
                    mode: out.modes[i],
                    dt,
                    is_smoothed: contacts.smoothing().is_some(),
                }));
            }
            for (link, out) in self.model().links().iter().zip(&mut out.links) {
                let X_BL = self.model().frames()[link.frame.0].placement.lift::<T>();
                let own = (0..n).filter(|&i| contacts.points()[i].link == link.frame);
                own.for_each(|i| *out += X_BL.force_inverse(&contact.body_force(contacts, i)));
            }
        }
        out
    }
}
