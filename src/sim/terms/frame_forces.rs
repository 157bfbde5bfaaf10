//! External forces and frame actuators, which act on bodies.
//!
//! Each force depends on the pose and the velocity of its body and on one input. For its derivatives, one evaluation on dual numbers in these
//! directions is sufficient; the joints of the body propagate them.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::marker::PhantomData;

use super::frame_servos::middle;
use super::local::{FURTHER, OfBody, seeded_pose, seeded_velocity};
use super::numbers::Numbers;
use super::sink::{ActingPlace, DerivativePoint, Own, Sink};
use super::term::{Term, TermDerivatives};
use crate::constraint::Mounted;
use crate::dynamics::{Kinematics, forward_kinematics_into};
use crate::scalar::{Dual, Over, Scalar};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::force::{FrameTerm, PLACE_NUMBERS};
use crate::sim::forces::Forces;
use crate::sim::parameter_slots::PartSlots;
use crate::sim::simulator::Simulator;
use crate::spatial::{Motion, Transform};

/// The term, with the motions that its forces follow.
#[derive(Clone, Debug)]
pub(crate) struct FrameForces<T> {
    /// `None` if no force depends on the motion of its body.
    kinematics: Option<Box<Kinematics<T>>>,
    /// `true` if there are forces.
    any: bool,
}

impl<T: Scalar> FrameForces<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let terms = simulator.frame_terms();
        let follows = terms.iter().any(|term| !term.is_fixed_to_body());
        Self {
            kinematics: follows.then(|| Box::new(Kinematics::new(simulator.model()))),
            any: !terms.is_empty(),
        }
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for FrameForces<T> {
    #[inline]
    fn add_forces(&mut self, at: &EvaluationPoint<'_, P, T>, forces: &mut Forces<T>) {
        let (model, terms) = (at.model(), at.simulator.frame_terms());
        assert_eq!(
            self.any,
            !terms.is_empty(),
            "the scratch is of a simulator without these forces"
        );
        if let Some(kinematics) = &mut self.kinematics {
            forward_kinematics_into(model, at.q(), at.v(), kinematics);
        }
        let u = at.simulator.frame_inputs(at.u);
        for term in terms.iter() {
            let mounted = term.place().mounted(model);
            let u = term.input().map_or(T::zero(), |input| u[input]);
            let (mut X_WB, mut V_B) = (Transform::identity(), Motion::zero());
            if let Some(kinematics) = &self.kinematics {
                X_WB = kinematics.pose(mounted.body);
                V_B = kinematics.velocity(mounted.body);
            }
            let found = middle(at, &term);
            let force = term.body_force(&mounted.X_BA, &X_WB, &V_B, u, found);
            if let Some(body) = mounted.body {
                forces.bodies[body.0] += force;
            }
        }
    }
}

/// Derivatives of the term.
#[derive(Clone, Debug)]
pub(crate) struct FrameForceDerivatives<T> {
    slots: PartSlots,
    of: PhantomData<T>,
}

impl<T: Scalar> FrameForceDerivatives<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            slots: PartSlots::of_placed_parts(simulator),
            of: PhantomData,
        }
    }
}

/// The entry of the input of a term; zero for one without.
fn input_of<T: Scalar>(term: &FrameTerm<'_, f64>, at: &DerivativePoint<'_, T>) -> T {
    let u = at.point.simulator.frame_inputs(at.point.u);
    term.input().map_or(T::zero(), |input| u[input])
}

/// Passes each term, with its index and attachment frame, to `each`.
fn each_mounted<T: Scalar>(
    at: &DerivativePoint<'_, T>,
    mut each: impl FnMut(usize, &FrameTerm<'_, f64>, &Mounted<f64>),
) {
    let model = at.point.model();
    for (k, term) in at.point.simulator.frame_terms().iter().enumerate() {
        each(k, &term, &term.place().mounted(model));
    }
}

impl<T: Scalar> TermDerivatives<T> for FrameForceDerivatives<T> {
    type Term = FrameForces<T>;

    fn emit_forces<S: Sink<T>>(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &FrameForces<T>,
        out: &mut S,
    ) {
        let first = at.point.simulator.actuated().len();
        each_mounted(at, |k, force, mounted| {
            let on = mounted.body;
            let motion = out.turn_to(at, on, term.kinematics.as_deref());
            let own = force.input().map(|input| first + input);
            let (X_WB, V_B) = (seeded_pose(&motion.X_WB), seeded_velocity(&motion.V));
            let u: OfBody<T> = Dual::variable(input_of(force, at), FURTHER);
            let found = middle(at.point, force).map(Dual::constant_of);
            let F = force.body_force(&mounted.X_BA, &X_WB, &V_B, u, found);
            out.force(on, &F, own.map_or(Own::Nothing, Own::Input));
            let first = self.slots.frame_terms[k].start;
            let turn = first + PLACE_NUMBERS / 2..first + PLACE_NUMBERS;
            out.place(&ActingPlace {
                frame: force.place().frame,
                X_BA: mounted.X_BA,
                origin: first..turn.start,
                turn,
            });
        });
    }

    fn emit_numbers(
        &mut self,
        at: &DerivativePoint<'_, T>,
        term: &FrameForces<T>,
        out: &mut Numbers<'_, T>,
    ) {
        each_mounted(at, |k, force, mounted| {
            let on = mounted.body;
            let W = out.sum::<1>(on).W;
            let (mut X_WB, mut V_B) = (Transform::identity(), Motion::zero());
            if let Some(kinematics) = &term.kinematics {
                (X_WB, V_B) = (kinematics.pose(on), kinematics.velocity(on));
            }
            let mut slot = self.slots.frame_terms[k].start + PLACE_NUMBERS;
            let u = input_of(force, at);
            let found = middle(at.point, force);
            force.each_derivative(&mounted.X_BA, &X_WB, &V_B, u, found, &mut |F| {
                out.add(&(slot..slot + 1), &[-W.power(&F)]);
                slot += 1;
            });
        });
    }
}
