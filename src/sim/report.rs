//! Report on contact and constraints at an instant, for a person or a picture.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::evaluation_point::EvaluationPoint;
use super::integrators::AccelerationScratch;
use super::simulator::Simulator;
use super::state::State;
use super::terms::Contact;
use crate::cone::{Certificate, Mode};
use crate::contact::reason::{ContactReason, PointOutcome};
use crate::contact::{Contacts, PointState};
use crate::dynamics::Calls;
use crate::model::FrameId;
use crate::scalar::{Over, Scalar};
use crate::spatial::Force;
use crate::spatial::linear::dot;

/// Report on the points of contact, and on constraints, at an instant.
#[derive(Clone, Debug)]
pub struct ContactReport<T: Scalar = f64> {
    /// Positions, depths and velocities of the points with the ground.
    pub points: Vec<PointState<T>>,
    /// The force of the ground on each, in the world, N.
    pub forces: Vec<Vector3<T>>,
    /// The force of the ground and of other bodies on each link, in the frame of the link (N, N·m about its origin), in the order of
    /// [`Model::links`](crate::Model::links).
    pub links: Vec<Force<T>>,
    /// In which part of its law each point is, for rigid contact; in the first lane. Points that took no part are separated.
    pub modes: Vec<Mode>,
    /// Behaviour of each point, and so why a derivative is zero or is not.
    pub reasons: Vec<ContactReason>,
    /// Points at which bodies are near each other.
    pub pairs: Vec<PairReport<T>>,
    /// The forces of kinematic constraints, row after row as in [`Simulator::constraint_errors`]: N, N·m, on the second anchor (and the
    /// opposite on the first), along what grows with the error.
    pub constraints: Vec<T>,
    /// Accuracy with which the forces of rigid contact and of constraints obey their laws.
    pub certificate: Certificate,
}

/// A point at which two links are near each other.
#[derive(Clone, Debug)]
pub struct PairReport<T: Scalar = f64> {
    /// The links.
    pub links: [FrameId; 2],
    /// The point half way between both. The normal points out of the second link; the velocity is that of the first one less that of the second.
    pub point: PointState<T>,
    /// The force on the first link, in the world, N; that on the second one is opposite.
    pub force: Vector3<T>,
    /// In which part of its law the point is; in the first lane.
    pub mode: Mode,
    /// Its behaviour, and so why a derivative is zero or is not.
    pub reason: ContactReason,
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
        let n = self.contacts().map_or(0, |c| c.points().len());
        let mut out = ContactReport {
            points: contact.points[..n].to_vec(),
            forces: contact.forces[..n].to_vec(),
            links: vec![Force::zero(); self.model().links().len()],
            modes: vec![Mode::Separated; contact.points.len()],
            reasons: Vec::with_capacity(n),
            pairs: Vec::new(),
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
            self.report_points(contacts, contact, &mut out);
        }
        out.modes.truncate(n);
        out
    }

    /// Adds what each point does, and the forces on links.
    fn report_points<T: Over<P>>(
        &self,
        contacts: &Contacts<P>,
        contact: &Contact<T>,
        out: &mut ContactReport<T>,
    ) {
        let dt = self.time_step().value(0);
        let (is_smoothed, n) = (contacts.smoothing().is_some(), out.points.len());
        for (i, (&mode, state)) in out.modes.iter().zip(&contact.points).enumerate() {
            let force = contact.forces[i];
            let (law, links) = contact.law_and_links(contacts, i);
            let reason = law.reason(&PointOutcome {
                state,
                normal_force: dot(&state.normal, &force),
                mode,
                dt,
                is_smoothed,
            });
            match links {
                _ if i < n => out.reasons.push(reason),
                links => out.pairs.push(PairReport {
                    links,
                    point: *state,
                    force,
                    mode,
                    reason,
                }),
            }
        }
        for (link, out) in self.model().links().iter().zip(&mut out.links) {
            let X_BL = self.model().frames()[link.frame.0].placement.lift::<T>();
            contact.each_force_on(contacts, link.frame, |F| *out += X_BL.force_inverse(&F));
        }
    }
}
