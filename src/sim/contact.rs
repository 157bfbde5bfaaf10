//! Forces of soft contact in a step, and what happens at its points.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::integrator::{AtEnd, StepScratch};
use super::simulator::Simulator;
use super::state::State;
use crate::contact::cone::{Certificate, Mode};
use crate::contact::reason::{ContactReason, PointOutcome};
use crate::contact::{BristleLoad, BristleRate, Contacts, PointState, ROWS, body_force};
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
    /// Rate of each bristle; empty for laws without.
    pub(super) rates: Vec<BristleRate<T>>,
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
            rates: vec![BristleRate::zero(); simulator.n_contact() / ROWS],
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

    /// Adds the forces that the laws give by themselves, on points and bodies, at a state.
    ///
    /// * `others` – what else acts on each body, in the body, which is added; empty for nothing
    pub(super) fn add_explicit_forces<P: Scalar>(
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
        let (bristles, _) = state.contact.as_slice().as_chunks::<ROWS>();
        for (i, law) in contacts.laws().iter().enumerate() {
            let deflection = bristles.get(i).map_or_else(Vector3::zeros, |&m| m.into());
            let Some(own) = law.explicit_force(&self.points[i], &deflection) else {
                continue;
            };
            self.forces[i] = own.force;
            if let Some(rate) = self.rates.get_mut(i) {
                *rate = own.bristle;
            }
            let force = self.body_force(contacts, i);
            self.external[contacts.points()[i].body.0] += force;
        }
    }

    /// Updates the rates of the bristles over a step at whose end the forces are those that are known.
    pub(super) fn update_bristles<P: Scalar>(
        &mut self,
        contacts: &Contacts<P>,
        state: &State<T>,
        dt: f64,
    ) where
        T: Over<P>,
    {
        let (bristles, _) = state.contact.as_slice().as_chunks::<ROWS>();
        for (i, (law, &m)) in contacts.laws().iter().zip(bristles).enumerate() {
            let (at, f) = (&self.points[i], &self.forces[i]);
            let step = law.bristle_step(&BristleLoad {
                depth: at.depth,
                separation: dot(&at.normal, &at.velocity),
                friction: &(f - scale(&at.normal, dot(&at.normal, f))),
                deflection: &Vector3::from(m),
                dt,
            });
            self.rates[i] = BristleRate {
                deflection: scale(&step, T::constant(1.0 / dt)),
                relaxation: T::zero(),
            };
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
            .flat_map(|rate| <[T; 3]>::from(rate.deflection))
    }

    /// Changes of the contact state over a step of Δt.
    pub(super) fn steps(&self, dt: f64) -> impl Iterator<Item = T> + '_ {
        let rates = self.rates.iter();
        rates.flat_map(move |rate| <[T; 3]>::from(rate.step(dt)))
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
            let dt = self.time_step();
            for (i, law) in contacts.laws().iter().enumerate() {
                let state = &out.points[i];
                out.reasons.push(law.reason(&PointOutcome {
                    state,
                    normal_force: dot(&state.normal, &out.forces[i]),
                    mode: out.modes[i],
                    dt,
                    kappa: contacts.kappa_over_step(dt),
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

    /// Contacts whose forces the solver finds in a step.
    pub(crate) fn solved_contacts(&self, at_end: AtEnd) -> Option<&Contacts<P>> {
        self.contacts().filter(|contacts| {
            if at_end.has_contact() {
                contacts.are_solved_implicitly()
            } else {
                contacts.are_solved_explicitly()
            }
        })
    }

    /// Time after which the deeper side of a fold of the ground is the one that is touched, s: a step where a solver finds forces for it, and none
    /// where they are those of its start.
    pub(crate) fn contact_duration(&self) -> f64 {
        let solved = self.solved_contacts(self.at_end());
        solved.map_or(0.0, |_| self.time_step())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactLaw, HuntCrossley, RelaxedRigid, Rigid, SoftContact, Terrain};
    use crate::{Integrator, Simulator};

    /// A box of 1 kg and 0.36 m × 0.24 m × 0.12 m, whose lower corners are so deep in flat ground, at rest.
    fn standing(law: ContactLaw, depth: f64) -> (Simulator, State<f64>) {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/box.urdf");
        let model = Model::from_urdf_file(path).expect("an asset");
        let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
        let simulator = Simulator::new(model)
            .with_contacts(contacts)
            .with_time_step(0.01);
        let mut state = simulator.neutral_state();
        state.q[2] = 0.06 - depth;
        (simulator, state)
    }

    // Gₙₙ = 1 / m + y² / I_xx + x² / I_yy and across 1 / m + y² / I_zz + z² / I_yy …, at (0.18, 0.12, −0.06) with
    // I = (0.006, 0.012, 0.0156).
    #[test]
    fn delassus_diagonal_of_a_corner_equals_its_closed_form() {
        let (simulator, state) = standing(ContactLaw::Rigid(Rigid::default()), 1e-4);
        let mut scratch = StepScratch::new(&simulator);
        simulator.accelerate_for_step(&state, &[], &mut scratch);
        let solved = scratch.constrained.as_ref().expect("a solver");
        assert_eq!(solved.touching().count(), 4);
        let (x, y, z): (f64, f64, f64) = (0.18, 0.12, 0.06);
        let expected = [
            1.0 + y * y / 0.006 + x * x / 0.012,
            1.0 + z * z / 0.012 + y * y / 0.0156,
            1.0 + z * z / 0.006 + x * x / 0.0156,
        ];
        for row in 0..solved.rows().count() {
            let (found, expected) = (solved.rows().mobility(row), expected[row % ROWS]);
            assert!(
                (found - expected).abs() < 1e-13,
                "{row}: {found} {expected}"
            );
        }
    }

    // Which contacts a solver looks at, by law and by which forces are those of the end of a step.
    #[test]
    fn solver_finds_the_forces_that_laws_leave_to_it() {
        let soft = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3));
        let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
        for (law, explicit) in [(soft, false), (relaxed, true)] {
            let (simulator, _) = standing(law, 0.0);
            for at_end in [AtEnd::Nothing, AtEnd::Joints] {
                assert_eq!(simulator.solved_contacts(at_end).is_some(), explicit);
            }
            assert!(simulator.solved_contacts(AtEnd::JointsAndContact).is_some());
            assert_eq!(simulator.contact_duration() > 0.0, explicit);
            let implicit = simulator.with_integrator(Integrator::ImplicitVelocity);
            assert_eq!(implicit.contact_duration(), 0.01);
        }
    }

    // Four corners with K = 500 N/m at 10 mm: 5 N each, in the body through its centre.
    #[test]
    fn explicit_forces_add_up_on_the_body() {
        let normal = HuntCrossley::linear(500.0, 1.0);
        let law = SoftContact {
            normal,
            friction: 0.5,
        };
        let (simulator, mut state) = standing(ContactLaw::Soft(law), 0.01);
        let contacts = simulator.contacts().expect("contacts");
        let mut scratch = ContactScratch::new(&simulator);
        let others = [Force::new(Vector3::x(), Vector3::zeros())];
        scratch.add_explicit_forces(simulator.model(), contacts, &state, &others);
        let expected = Force::new(Vector3::new(1.0, 0.0, 20.0), Vector3::zeros());
        let found = scratch.external[0].to_array();
        let mut both = found.iter().zip(expected.to_array());
        assert!(both.all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        // A bristle that is stretched pulls back: s = 500 N/m by 2 mm, on one corner.
        let lower = scratch
            .forces
            .iter()
            .position(|f| f.z > 0.0)
            .expect("a lower corner");
        state.contact[ROWS * lower] = 2e-3;
        scratch.add_explicit_forces(simulator.model(), contacts, &state, &others);
        assert!((scratch.forces[lower].x + 1.0).abs() < 1e-12);
    }
}
