//! How a step is taken, on the configuration manifold.

use nalgebra::DVector;

use super::constrained::ConstrainedScratch;
use super::contact::ContactScratch;
use super::force::BodyForces;
use super::implicit_joints::{ImplicitJoints, Stop};
use super::middle::{Middle, MiddleScratch};
use super::simulator::Simulator;
use super::state::State;
use crate::contact::cone::Status;
use crate::dynamics::AbaScratch;
use crate::scalar::{Over, Scalar};

/// The integration method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Integrator {
    /// v⁺ = v + Δt v̇(q, v, u), then q⁺ = q ⊕ Δt v⁺: first order, one evaluation, no energy drift on average. The linear velocity of a
    /// floating base is stepped in the world, so that a free body keeps its momentum, see [`JointKind::advance`](crate::joint::JointKind::advance).
    #[default]
    SemiImplicitEuler,
    /// Semi-implicit Euler with the forces of the end of the step where they are stiff: springs, viscous and dry friction and speed
    /// limits of joints, their stops, and [soft contact](crate::contact::SoftContact), each linear in the velocity v⁺ after the step with the coefficients of its
    /// start, but never pulling and within the cone of friction, which a solver sees to. So damping of any strength
    /// is stable at any step, and so are stops; contact far stiffer than the step resolves may bounce. Of first order. Motors' torque–speed curves, external forces, gyroscopic forces and gravity are those of the start.
    ImplicitVelocity,
    /// The classical method of fourth order, four evaluations, in tangent coordinates of the manifold [Munthe-Kaas 1999].
    RungeKutta4,
}

/// Which forces of a step are those at its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AtEnd {
    /// None: all are those of its start, or of a moment.
    Nothing,
    /// Those of joints: dampers, springs, dry friction, speed limits, stops.
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

/// Working memory of [`Simulator::step_into`].
#[derive(Clone, Debug)]
pub struct StepScratch<T: Scalar> {
    pub(super) aba: AbaScratch<T>,
    pub(super) contact: ContactScratch<T>,
    /// Of external forces and frame actuators.
    pub(super) bodies: BodyForces<T>,
    /// For rigid contact, constraints, and steps that are implicit in velocity.
    pub(super) constrained: Option<Box<ConstrainedScratch<T>>>,
    /// For steps without these whose joints have forces of their end.
    pub(super) joints: ImplicitJoints<T>,
    /// For velocity forces of the middle of a step; with semi-implicit Euler from the first step on in which something whirls.
    pub(super) middle: Option<Box<MiddleScratch<T>>>,
    /// [`Simulator::half_step`] of the last evaluation.
    pub(super) half_step: Option<T>,
    pub(super) tau: Vec<T>,
    pub(super) a: Vec<T>,
    /// The state at a stage.
    stage: State<T>,
    /// The stage's configuration as a tangent at the start of the step.
    offset: DVector<T>,
    /// Rate of the offset.
    rate: DVector<T>,
    /// Weighted sums of the stages.
    sum_rate: DVector<T>,
    sum_a: DVector<T>,
    sum_contact: DVector<T>,
}

impl<T: Scalar> StepScratch<T> {
    /// Memory for a simulator.
    pub fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let zeros = || DVector::zeros(nv);
        Self {
            aba: AbaScratch::new(model),
            contact: ContactScratch::new(simulator),
            bodies: BodyForces::new(model, simulator.frame_terms()),
            constrained: simulator
                .needs_solver()
                .then(|| Box::new(ConstrainedScratch::new(simulator))),
            joints: ImplicitJoints::new(simulator),
            middle: (simulator.integrator() == Integrator::ImplicitVelocity)
                .then(|| Box::new(MiddleScratch::new(model))),
            half_step: None,
            tau: vec![T::zero(); nv],
            a: vec![T::zero(); nv],
            stage: simulator.neutral_state(),
            offset: zeros(),
            rate: zeros(),
            sum_rate: zeros(),
            sum_a: zeros(),
            sum_contact: DVector::zeros(simulator.n_contact()),
        }
    }
}

/// The acceleration at a state, and where forces of contact act.
pub(crate) struct Solution<'a, T: Scalar> {
    pub(crate) a: &'a [T],
    /// Forces that a solver found, where it was needed.
    pub(crate) constrained: Option<&'a mut ConstrainedScratch<T>>,
    /// Ends of joints that no solver looked at, in the order of [`Simulator::each_end`].
    pub(crate) stops: &'a [Stop<T>],
    /// `None` where velocity forces are those of the start.
    pub(crate) middle: Option<Middle<'a, T>>,
    pub(crate) contact: &'a ContactScratch<T>,
}

impl<T: Scalar> StepScratch<T> {
    /// How the solver of the forces of contact and constraints came out in the last step, in a lane: the worst of all its evaluations, and
    /// [`Converged`](Status::Converged) where none was needed. What it means stands at [`ContactReport::certificate`](super::ContactReport).
    ///
    /// # Panics
    /// If there is no such lane.
    pub fn solver_status(&self, lane: usize) -> Status {
        assert!(lane < T::LANES, "there are {} lanes, none {lane}", T::LANES);
        let solver = self.constrained.as_ref();
        solver.map_or(Status::Converged, |solver| solver.status(lane))
    }

    /// What the last evaluation of the dynamics found.
    pub(crate) fn solution(&mut self) -> Solution<'_, T> {
        Solution {
            a: &self.a,
            constrained: self.constrained.as_deref_mut(),
            stops: self.joints.stops(),
            middle: (self.middle.as_ref().zip(self.half_step)).map(|(middle, half_step)| Middle {
                gyroscopic: &middle.gyroscopic,
                half_step,
            }),
            contact: &self.contact,
        }
    }
}

impl Integrator {
    /// One step from `state` to `next`.
    pub(super) fn advance<P: Scalar, T: Over<P>>(
        self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        scratch: &mut StepScratch<T>,
        next: &mut State<T>,
    ) {
        if let Some(solver) = &mut scratch.constrained {
            solver.forget();
        }
        match self {
            Self::SemiImplicitEuler | Self::ImplicitVelocity => {
                simulator.accelerate_for_step(state, u, scratch);
                advance(simulator, state, scratch, next);
            }
            Self::RungeKutta4 => runge_kutta_4(simulator, state, u, scratch, next),
        }
    }
}

/// A step of Euler with the acceleration in the scratch.
fn advance<P: Scalar, T: Over<P>>(
    simulator: &Simulator<P>,
    state: &State<T>,
    scratch: &StepScratch<T>,
    next: &mut State<T>,
) {
    let dt = simulator.time_step();
    // v⁺ = v + Δt v̇,  q⁺ = q ⊕ Δt v⁺
    simulator.model().advance_into(
        (state.q.as_slice(), state.v.as_slice(), &scratch.a),
        dt,
        (next.q.as_mut_slice(), next.v.as_mut_slice()),
    );
    // m⁺ = m + Δt ṁ, implicit in how bristles fall
    let contact = next.contact.iter_mut().zip(&state.contact);
    for ((next, &m), step) in contact.zip(scratch.contact.steps(dt)) {
        *next = m + step;
    }
}

/// Tangent coordinates x = (offset from q, v) turn the step into one of an ordinary differential equation.
fn runge_kutta_4<P: Scalar, T: Over<P>>(
    simulator: &Simulator<P>,
    state: &State<T>,
    u: &[T],
    scratch: &mut StepScratch<T>,
    next: &mut State<T>,
) {
    /// Weight of each stage in the result, and fraction of the step at which the stage after it is taken.
    const STAGES: [(f64, f64); 4] = [
        (1.0 / 6.0, 0.5),
        (1.0 / 3.0, 0.5),
        (1.0 / 3.0, 1.0),
        (1.0 / 6.0, 0.0),
    ];
    let (model, dt) = (simulator.model(), simulator.time_step());
    start_at(state, scratch);
    for (weight, fraction) in STAGES {
        evaluate(simulator, u, scratch);
        add_scaled(&mut scratch.sum_rate, scratch.rate.as_slice(), weight * dt);
        add_scaled(&mut scratch.sum_a, &scratch.a, weight * dt);
        let rates = scratch.sum_contact.iter_mut().zip(scratch.contact.rates());
        rates.for_each(|(sum, rate)| *sum += rate * (weight * dt));
        // The next stage: offset = fraction Δt rate, q = start ⊕ offset, v = start + fraction Δt v̇
        scratch
            .offset
            .iter_mut()
            .zip(&scratch.rate)
            .for_each(|(offset, &rate)| *offset = rate * (fraction * dt));
        model.integrate_into(
            state.q.as_slice(),
            scratch.offset.as_slice(),
            scratch.stage.q.as_mut_slice(),
        );
        scratch.stage.v.copy_from(&state.v);
        add_scaled(&mut scratch.stage.v, &scratch.a, fraction * dt);
        let stage = scratch.stage.contact.iter_mut().zip(&state.contact);
        for ((stage, &m), rate) in stage.zip(scratch.contact.rates()) {
            *stage = m + rate * (fraction * dt);
        }
    }
    model.integrate_into(
        state.q.as_slice(),
        scratch.sum_rate.as_slice(),
        next.q.as_mut_slice(),
    );
    next.v.copy_from(&state.v);
    add_scaled(&mut next.v, scratch.sum_a.as_slice(), 1.0);
    next.contact.copy_from(&state.contact);
    add_scaled(&mut next.contact, scratch.sum_contact.as_slice(), 1.0);
}

fn start_at<T: Scalar>(state: &State<T>, scratch: &mut StepScratch<T>) {
    scratch.stage.q.copy_from(&state.q);
    scratch.stage.v.copy_from(&state.v);
    scratch.stage.contact.copy_from(&state.contact);
    scratch.offset.fill(T::zero());
    scratch.sum_rate.fill(T::zero());
    scratch.sum_a.fill(T::zero());
    scratch.sum_contact.fill(T::zero());
}

/// Rate of the offset, and v̇, at the stage.
fn evaluate<P: Scalar, T: Over<P>>(
    simulator: &Simulator<P>,
    u: &[T],
    scratch: &mut StepScratch<T>,
) {
    let v = scratch.stage.v.as_slice();
    simulator
        .model()
        .tangent_rate_into(scratch.offset.as_slice(), v, scratch.rate.as_mut_slice());
    let stage = std::mem::replace(&mut scratch.stage, State::new(&[], &[]));
    simulator.accelerate(&stage, u, scratch);
    scratch.stage = stage;
}

/// out += x s
fn add_scaled<T: Scalar>(out: &mut DVector<T>, x: &[T], s: f64) {
    out.iter_mut().zip(x).for_each(|(out, &x)| *out += x * s);
}
