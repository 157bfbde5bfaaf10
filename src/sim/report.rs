//! Report on contact and constraints at an instant, for display and analysis.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, Vector3};

use super::evaluation_point::EvaluationPoint;
use super::integrators::AccelerationScratch;
use super::simulator::Simulator;
use super::state::State;
use super::terms::Contact;
use crate::cone::{Certificate, Mode};
use crate::contact::reason::{ContactReason, PointOutcome};
use crate::contact::{Contacts, PointState};
use crate::dynamics::{
    Calls, frame_jacobian, frame_jacobian_derivative, frame_pose, frame_velocity,
};
use crate::model::{FrameId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{cross, dot};
use crate::spatial::{Force, Representation};

/// Report on the contact points, and on constraints, at an instant.
#[derive(Clone, Debug)]
pub struct ContactReport<T: Scalar = f64> {
    /// Positions, depths and velocities of the contact points with the ground.
    pub points: Vec<PointState<T>>,
    /// The force of the ground on each, in the world, N.
    pub forces: Vec<Vector3<T>>,
    /// The force of the ground and of other bodies on each link, in the frame of the link (N, N·m about its origin), in the order of
    /// [`Model::links`](crate::Model::links).
    pub links: Vec<Force<T>>,
    /// Mode of each point in rigid contact (stick, slip, separated), in the first lane. Points that took no part are separated.
    pub modes: Vec<Mode>,
    /// Behaviour of each point, which explains why a derivative is zero or not.
    pub reasons: Vec<ContactReason>,
    /// Points at which bodies are near each other.
    pub pairs: Vec<PairReport<T>>,
    /// The forces of kinematic constraints, row by row as in [`Simulator::constraint_errors`]: N, N·m, on the second attachment frame (and the
    /// opposite on the first), in the direction in which the error grows.
    pub constraints: Vec<T>,
    /// Residuals of the laws of rigid contact and constraints for the computed forces.
    pub certificate: Certificate,
}

/// A point at which two links are near each other.
#[derive(Clone, Debug)]
pub struct PairReport<T: Scalar = f64> {
    /// The links.
    pub links: [FrameId; 2],
    /// The midpoint between both links. The normal points out of the second link; the velocity is that of the first link minus that of the second.
    pub point: PointState<T>,
    /// The force on the first link, in the world, N; the force on the second link is opposite.
    pub force: Vector3<T>,
    /// Mode of the point (stick, slip, separated), in the first lane.
    pub mode: Mode,
    /// Its behaviour, which explains why a derivative is zero or not.
    pub reason: ContactReason,
}

impl<T: Scalar> ContactReport<T> {
    /// Whether two links touch, in either order: whether a point between them is in contact, in the first lane.
    pub fn are_touching(&self, links: [FrameId; 2]) -> bool {
        let mut between = self.between(links);
        between.any(|(pair, _)| pair.mode != Mode::Separated)
    }

    /// Computes the force of the second link on the first, summed over their points, in the world, N.
    pub fn force_between(&self, links: [FrameId; 2]) -> Vector3<T> {
        let zero = Vector3::from_element(T::zero());
        let between = self.between(links);
        between.fold(zero, |sum, (pair, is_turned)| match is_turned {
            false => sum + pair.force,
            true => sum - pair.force,
        })
    }

    /// The points between two links, and whether the links are in the opposite order there.
    fn between(&self, links: [FrameId; 2]) -> impl Iterator<Item = (&PairReport<T>, bool)> {
        let turned = [links[1], links[0]];
        let pairs = self.pairs.iter();
        pairs.filter_map(move |pair| match pair.links {
            own if own == links => Some((pair, false)),
            own if own == turned => Some((pair, true)),
            _ => None,
        })
    }
}

impl<T: Scalar> PairReport<T> {
    /// Computes the Jacobian of the velocity of the first link relative to the second at the point, 6 × `nv`, rows `[linear; angular]` in the world's axes:
    /// J q̇ is the velocity of the [`point`](Self::point) and the difference of the angular velocities. A force there acts on the joints by the transpose of the first three
    /// rows. Allocates.
    ///
    /// * `q` – configuration of the report, length `nq`
    ///
    /// # Panics
    /// If `q` has the wrong length, or the report is one of another robot.
    pub fn jacobian<P: Scalar>(&self, model: &Model<P>, q: &[T]) -> DMatrix<T>
    where
        T: Over<P>,
    {
        self.difference(model, |frame| {
            let mut J = frame_jacobian(model, q, frame, Representation::Mixed);
            let arm = self.point.position - frame_pose(model, q, frame).translation;
            shift(&mut J, &arm);
            J
        })
    }

    /// Computes the rate of the [Jacobian](Self::jacobian), 6 × `nv`, of points that are fixed to their links:  J v̇ + J̇ v is the acceleration of
    /// the first point minus that of the second. Allocates.
    ///
    /// * `q`, `v` – configuration and velocity of the report, lengths `nq` and `nv`
    ///
    /// # Panics
    /// If a slice has the wrong length, or the report is one of another robot.
    pub fn jacobian_derivative<P: Scalar>(&self, model: &Model<P>, q: &[T], v: &[T]) -> DMatrix<T>
    where
        T: Over<P>,
    {
        let mixed = Representation::Mixed;
        self.difference(model, |frame| {
            let J = frame_jacobian(model, q, frame, mixed);
            let mut rate = frame_jacobian_derivative(model, q, v, frame, mixed);
            let arm = self.point.position - frame_pose(model, q, frame).translation;
            // d(J_ω × r)/dt = J̇_ω × r + J_ω × (ω × r)
            shift(&mut rate, &arm);
            let turning = cross(&frame_velocity(model, q, v, frame, mixed).angular, &arm);
            for (mut rate, column) in rate.column_iter_mut().zip(J.column_iter()) {
                let more = cross(&Vector3::new(column[3], column[4], column[5]), &turning);
                (0..3).for_each(|k| rate[k] += more[k]);
            }
            rate
        })
    }

    /// Value of the first link minus that of the second.
    fn difference<P: Scalar>(
        &self,
        model: &Model<P>,
        of: impl Fn(FrameId) -> DMatrix<T>,
    ) -> DMatrix<T> {
        let [first, second] = self.links;
        let n = model.frames().len();
        assert!(
            first.0 < n && second.0 < n,
            "the report is one of another robot than \"{}\"",
            model.name()
        );
        of(first) - of(second)
    }
}

/// Moves a Jacobian to a point an arm away: v + ω × r.
fn shift<T: Scalar>(J: &mut DMatrix<T>, arm: &Vector3<T>) {
    for mut column in J.column_iter_mut() {
        let more = cross(&Vector3::new(column[3], column[4], column[5]), arm);
        (0..3).for_each(|k| column[k] += more[k]);
    }
}

impl<P: Scalar> Simulator<P> {
    /// Reports on the contact points, and on constraints, at a state with the input `u` (length `nu`; N·m or N). Allocates.
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
            let solved = balance.rows().first_forces(self.bilateral_rows());
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
