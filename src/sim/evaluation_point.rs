//! Evaluation point of forces: a state, an input, and the kinds of forces that are evaluated at the end of a step.

use super::integrator::Integrator;
use super::simulator::Simulator;
use super::state::State;
use crate::contact::Contacts;
use crate::model::Model;
use crate::scalar::{Over, Scalar};

/// Forces of a step that are evaluated at its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AtEnd {
    /// None: all are those of its start, or of an instant.
    Nothing,
    /// Those of joints: dampers, springs, servos, dry friction, speed limits, joint limits.
    Joints,
    /// Those of joints and of soft contact.
    JointsAndContact,
}

impl AtEnd {
    pub(crate) fn has_joints(self) -> bool {
        self != Self::Nothing
    }

    pub(crate) fn has_contact(self) -> bool {
        self == Self::JointsAndContact
    }
}

/// Inputs of the balance of forces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EvaluationPoint<'a, P, T: Scalar> {
    pub(crate) simulator: &'a Simulator<P>,
    pub(crate) state: &'a State<T>,
    /// The input, length `nu`.
    pub(crate) u: &'a [T],
    pub(crate) at_end: AtEnd,
    /// `true` if rates are requested, of contact too; `false` for what a step changes.
    pub(crate) is_instant: bool,
    /// [`Simulator::half_step`], s; `None` where velocity forces are those of the state.
    pub(crate) half_step: Option<T>,
    /// Length of the step, s: the time step of the simulator, or that of an impact.
    pub(crate) dt: P,
    /// A contact point without force, by its index in this state.
    pub(crate) left_out: Option<usize>,
}

impl<'a, P: Scalar, T: Over<P>> EvaluationPoint<'a, P, T> {
    /// All forces at a state.
    pub(crate) fn instant(simulator: &'a Simulator<P>, state: &'a State<T>, u: &'a [T]) -> Self {
        Self {
            simulator,
            state,
            u,
            at_end: AtEnd::Nothing,
            is_instant: true,
            half_step: None,
            dt: simulator.time_step(),
            left_out: None,
        }
    }

    /// The forces with which the simulator's integrator steps, which may be those of the end or the middle of the step.
    pub(crate) fn of_step(simulator: &'a Simulator<P>, state: &'a State<T>, u: &'a [T]) -> Self {
        Self {
            at_end: simulator.at_end(),
            is_instant: false,
            half_step: simulator.half_step(state.v.as_slice()),
            ..Self::instant(simulator, state, u)
        }
    }

    /// The forces of a step that has been taken: whether anything rotates fast matters to those of constraints alone.
    pub(crate) fn after_step(simulator: &'a Simulator<P>, state: &'a State<T>, u: &'a [T]) -> Self {
        if !simulator.constraints().is_empty() {
            return Self::of_step(simulator, state, u);
        }
        Self {
            at_end: simulator.at_end(),
            is_instant: false,
            ..Self::instant(simulator, state, u)
        }
    }

    /// The forces of a step of another length, s, in which nothing rotates fast.
    pub(crate) fn lasting(
        simulator: &'a Simulator<P>,
        state: &'a State<T>,
        u: &'a [T],
        dt: P,
    ) -> Self {
        let in_the_middle = simulator.always_in_the_middle();
        Self {
            half_step: in_the_middle.then(|| (dt * 0.5).into()),
            dt,
            ..Self::of_step(simulator, state, u)
        }
    }

    pub(crate) fn model(&self) -> &'a Model<P> {
        self.simulator.model()
    }

    pub(crate) fn q(&self) -> &'a [T] {
        self.state.q.as_slice()
    }

    pub(crate) fn v(&self) -> &'a [T] {
        self.state.v.as_slice()
    }

    pub(crate) fn dt(&self) -> P {
        self.dt
    }

    /// `true` if no force depends on the acceleration.
    pub(crate) fn is_explicit(&self) -> bool {
        !self.at_end.has_joints() && self.half_step.is_none()
    }

    /// `true` if forces may have rows, whose forces a solver finds.
    pub(crate) fn may_have_rows(&self) -> bool {
        self.solved_contacts().is_some() || self.always_has_rows()
    }

    /// `true` if there are rows in every state.
    fn always_has_rows(&self) -> bool {
        !self.simulator.constraints().is_empty()
            || !self.is_explicit() && self.simulator.has_following_servos()
    }

    /// Whether a state in which nothing touches has no rows. Not with bristles, which relax there by rows, nor with forces in the middle of every step,
    /// whose memory needs rows.
    pub(crate) fn may_lose_rows(&self) -> bool {
        let contacts = self.solved_contacts();
        contacts.is_some_and(|contacts| !contacts.have_bristles())
            && !self.always_has_rows()
            && !self.simulator.always_in_the_middle()
    }

    /// Contacts whose forces a solver finds.
    pub(crate) fn solved_contacts(&self) -> Option<&'a Contacts<P>> {
        self.simulator.solved_contacts(self.at_end)
    }

    /// Contacts whose forces follow from the state.
    pub(crate) fn explicit_contacts(&self) -> Option<&'a Contacts<P>> {
        let contacts = self.simulator.contacts();
        contacts.filter(|_| self.solved_contacts().is_none())
    }

    /// Time after which the deeper side of an inner edge of the ground determines the contact, s: one step if a solver finds the forces, 0 if forces
    /// are those of the start.
    pub(crate) fn contact_duration(&self) -> P {
        self.solved_contacts().map_or(P::zero(), |_| self.dt)
    }
}

impl<P: Scalar> Simulator<P> {
    /// Forces of a step that are evaluated at its end.
    pub(crate) fn at_end(&self) -> AtEnd {
        match self.integrator() {
            Integrator::SemiImplicitEuler if self.resists() => AtEnd::Joints,
            Integrator::SemiImplicitEuler
            | Integrator::RungeKutta4
            | Integrator::ImplicitMidpoint => AtEnd::Nothing,
            Integrator::ImplicitVelocity => AtEnd::JointsAndContact,
        }
    }

    /// `true` if a step uses a solver, or may have to report dropped pairs of bodies.
    pub(crate) fn needs_solver(&self) -> bool {
        self.solved_contacts(self.at_end()).is_some()
            || !self.constraints().is_empty()
            || self.at_end().has_joints() && self.has_following_servos()
            || self.contacts().is_some_and(Contacts::have_pairs)
    }

    /// `true` if an impact may be found at its time within a step.
    pub(crate) fn may_bounce(&self) -> bool {
        self.contacts().is_some_and(Contacts::may_bounce)
    }

    /// The most rows of joints, each a block: joint limits, bounded forces, and servos of tendons.
    pub(crate) fn joint_rows(&self) -> usize {
        let bounded = self.actuation().map_or(0, |own| own.bounded_forces());
        let on_frames = self.frame_servos().count();
        self.model().nv() + bounded + self.tendon_servos().len() + on_frames
    }

    /// Contacts whose forces a solver finds in a step.
    fn solved_contacts(&self, at_end: AtEnd) -> Option<&Contacts<P>> {
        self.contacts().filter(|contacts| {
            if at_end.has_contact() {
                contacts.are_solved_implicitly()
            } else {
                contacts.are_solved_explicitly()
            }
        })
    }
}
