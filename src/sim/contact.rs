//! Forces of soft contact in a step, and what happens at its points.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::integrator::StepScratch;
use super::reason::ContactReason;
use super::simulator::Simulator;
use super::state::State;
use crate::contact::cone::{Certificate, Mode};
use crate::contact::{ContactLaw, Contacts, PointState, SoftResponse, body_force, step_of_bristle};
use crate::dynamics::{Kinematics, forward_kinematics_into};
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::Force;
use crate::spatial::linear::{dot, scale};

/// Working memory of contact: empty where there is none.
#[derive(Clone, Debug)]
pub(crate) struct ContactScratch<T> {
    pub(crate) kinematics: Kinematics<T>,
    pub(crate) points: Vec<PointState<T>>,
    /// Force on each point, in the world.
    pub(super) forces: Vec<Vector3<T>>,
    /// Force on each body, in the body.
    pub(super) external: Vec<Force<T>>,
    /// ṁ of each bristle, and how fast it falls by itself.
    pub(super) rates: Vec<(Vector3<T>, T)>,
}

impl<T: Scalar> ContactScratch<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let (model, n) = (
            simulator.model(),
            simulator.contacts().map_or(0, |c| c.points().len()),
        );
        let bodies = if n == 0 { 0 } else { model.n_bodies() };
        Self {
            kinematics: Kinematics::new(model),
            points: vec![PointState::zero(); n],
            forces: vec![Vector3::zeros(); n],
            external: vec![Force::zero(); bodies],
            rates: vec![(Vector3::zeros(), T::zero()); simulator.n_contact() / 3],
        }
    }

    /// Where the points are at a state.
    pub(super) fn locate<P: Scalar>(
        &mut self,
        model: &Model<P>,
        contacts: &Contacts<P>,
        state: &State<T>,
    ) where
        T: Over<P>,
    {
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        forward_kinematics_into(model, q, v, &mut self.kinematics);
        contacts.states_into(&self.kinematics, &mut self.points);
    }

    /// Forces of soft contact on points and bodies at a state.
    ///
    /// * `others` – what else acts on each body, in the body, which is added; empty for nothing
    pub(super) fn press<P: Scalar>(
        &mut self,
        model: &Model<P>,
        contacts: &Contacts<P>,
        state: &State<T>,
        others: &[Force<T>],
    ) where
        T: Over<P>,
    {
        self.locate(model, contacts, state);
        self.external.fill(Force::zero());
        let bodies = self.external.iter_mut().zip(others);
        bodies.for_each(|(sum, other)| *sum = *other);
        let (bristles, _) = state.contact.as_slice().as_chunks::<3>();
        for (i, (law, m)) in contacts.laws().iter().zip(bristles).enumerate() {
            let ContactLaw::Soft(law) = law else {
                continue;
            };
            let at = &self.points[i];
            let m = Vector3::new(m[0], m[1], m[2]);
            let response: SoftResponse<T> = law.respond(at.depth, &at.velocity, &at.normal, &m);
            self.forces[i] = scale(&at.normal, response.normal) + response.tangent;
            self.rates[i] = (response.deflection_rate, response.relaxation);
            let force = self.body_force(contacts, i);
            self.external[contacts.points()[i].body.0] += force;
        }
    }

    /// Updates the rates of the bristles over a step at whose end the forces are those that are known.
    pub(super) fn settle<P: Scalar>(&mut self, contacts: &Contacts<P>, state: &State<T>, dt: f64)
    where
        T: Over<P>,
    {
        let (bristles, _) = state.contact.as_slice().as_chunks::<3>();
        for (i, (law, &m)) in contacts.laws().iter().zip(bristles).enumerate() {
            let ContactLaw::Soft(law) = law else {
                continue;
            };
            let (at, f) = (&self.points[i], &self.forces[i]);
            let friction = f - scale(&at.normal, dot(&at.normal, f));
            let away = dot(&at.normal, &at.velocity);
            let step = law.settle((at.depth, away), &friction, &Vector3::from(m), dt);
            self.rates[i] = (scale(&step, T::constant(1.0 / dt)), T::zero());
        }
    }

    /// Spatial force of the contact at a point on its body, in the body frame.
    pub(crate) fn body_force<P>(&self, contacts: &Contacts<P>, point: usize) -> Force<T>
    where
        P: Scalar,
    {
        let pose = self.kinematics.pose_of(contacts.points()[point].body);
        body_force(
            &pose.rotation,
            &self.points[point].in_body,
            &self.forces[point],
        )
    }

    /// The rates of all numbers of the contact state, one after the other.
    pub(super) fn rates(&self) -> impl Iterator<Item = T> + '_ {
        self.rates
            .iter()
            .flat_map(|(rate, _)| [rate.x, rate.y, rate.z])
    }

    /// Changes of the contact state over a step of Δt.
    pub(super) fn steps(&self, dt: f64) -> impl Iterator<Item = T> + '_ {
        let rates = self.rates.iter();
        let steps = rates.map(move |(rate, relaxation)| step_of_bristle(rate, *relaxation, dt));
        steps.flat_map(|step| [step.x, step.y, step.z])
    }
}

/// Report on the points of contact, and on constraints, at a moment.
#[derive(Clone, Debug)]
pub struct ContactReport<T: Scalar = f64> {
    /// Where the points are, how deep and how fast.
    pub points: Vec<PointState<T>>,
    /// The force of the ground on each, in the world, N.
    pub forces: Vec<Vector3<T>>,
    /// The force of the ground on each link, in the frame of the link (N, N·m about its origin), in the order of
    /// [`Model::links`].
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
        let mut scratch = StepScratch::new(self);
        if let Some(constrained) = &mut scratch.constrained {
            constrained.measure();
        }
        self.accelerate_for_step(state, u, &mut scratch);
        let contact = &scratch.contact;
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
        if let Some(constrained) = &scratch.constrained {
            constrained
                .modes()
                .for_each(|(i, mode)| out.modes[i] = mode);
            out.constraints = constrained.constraint_forces().to_vec();
            out.certificate = constrained.certificate();
        }
        if let Some(contacts) = self.contacts() {
            let each = out.points.iter().zip(&out.forces).zip(&out.modes);
            let reason = |((at, f), &mode): ((&PointState<T>, _), _)| {
                let force = dot(&at.normal, f);
                if contacts.are_exactly_rigid() {
                    return ContactReason::of_rigid(at, force, mode, self.time_step());
                }
                let solved = Some(mode).filter(|_| !contacts.are_soft());
                ContactReason::new(at, force, solved)
            };
            out.reasons.extend(each.map(reason));
            for (link, out) in self.model().links().iter().zip(&mut out.links) {
                let X_BL = self.model().frames()[link.frame.0].placement.lift::<T>();
                let own = (0..n).filter(|&i| contacts.points()[i].link == link.frame);
                own.for_each(|i| *out += X_BL.force_inverse(&contact.body_force(contacts, i)));
            }
        }
        out
    }
}
