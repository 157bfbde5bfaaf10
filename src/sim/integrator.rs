//! Integration of a step, on the configuration manifold.

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
///
/// Which to take:
///
/// * [`SemiImplicitEuler`](Self::SemiImplicitEuler), the default, for learning and for control at steps of a few milliseconds: cheapest, and stable
///   whatever dampers, springs, friction and stops a description has.
/// * [`ImplicitVelocity`](Self::ImplicitVelocity) for [soft contact](crate::contact::SoftContact), for long steps, and for what spins and must go on
///   spinning.
/// * [`RungeKutta4`](Self::RungeKutta4) for smooth motion that must be right to many digits, of closed loops too. It is explicit
///   in everything, and diverges where forces are stiff; no rigid contact.
///
/// Largest error of a coordinate after 0.5 s (rad or m, against steps of 10 µs), at steps of 1, 5 and 10 ms, and the time of a step on one core of a
/// small virtual machine, optimised for tests (`cargo test --test it -- --nocapture errors_after_half_a_second`):
///
/// | | semi-implicit Euler | implicit velocity | Runge–Kutta |
/// |---|---|---|---|
/// | UR5 with dampers of 2 N·m·s | 3e-4, 2e-3, 3e-3; 0.9 µs | 3e-4, 2e-3, 3e-3; 5 µs | diverges in the second step |
/// | quadruped that falls on soft feet | 7e-3, bounces off; 4 µs | 3e-3, 1e-2, 2e-2; 23 µs | 6e-5, 0.2, 1.4; 14 µs |
/// | free body that tumbles at 20 rad/s | 2e-2, 9e-2, 0.2; 0.8 µs | 3e-3, 1.5e-2, 3e-2; 3 µs | below 4e-5; 3 µs |
/// | slider-crank, a closed loop | 1.5e-3, 8e-3, 2e-2; 5 µs | as semi-implicit Euler | 2e-5; 11 µs |
///
/// Conservation by each method, of systems whose energy nothing but the method can change: largest loss and gain of energy as parts of the
/// kinetic energy at the start (of the delta robot, which falls from rest and swings with up to 2 J, in J), measured by the tests in
/// `tests/it/integrators.rs`.
///
/// | | semi-implicit Euler | implicit velocity | Runge–Kutta |
/// |---|---|---|---|
/// | flywheel, 30 rad/s, 10 s | +0.2 (1 ms), +39 (5 ms) | 1e-15, and its momentum | −8e-12 (1 ms), −2e-8 (5 ms) |
/// | heavy top, 300 rad/s, 5 s | ±1e-6 (1 ms), ±3e-6 (5 ms) | ±1e-6 (1 ms), ±3e-6 (5 ms) | −9e-7 (1 ms), −6e-3 (5 ms) |
/// | wing nut, 6 rad/s, 100 s | +0.13 (1 ms), +6 (10 ms) | +3e-6 (1 ms), +3e-4 (10 ms), back with each flip | −1e-12 (1 ms), −4e-8 (10 ms) |
/// | slider-crank, 15 rad/s, 10 s | −0.014, +0.005 (1 ms); −0.5, +0.1 (10 ms) | as semi-implicit Euler | ±4e-6 (1 ms), −0.2 (10 ms) |
/// | free delta robot, 10 s | ±0.4 J (1 ms); −1.8, +0.1 J (10 ms) | as semi-implicit Euler | ±5e-4 J (1 ms) |
///
/// Both steps of Euler keep the energy of closed loops but for what the stabilisation of their [constraints](crate::constraint) takes where a loop
/// passes singular places fast, as the delta robot does: −0.06 J at 0.5 ms, −0.01 J at 0.25 ms, and ±0.07 J at 1 ms with
/// [time constants](crate::constraint::Constraint::with_time_constant) of 2 ms instead of 10.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Integrator {
    /// v⁺ = v + Δt a, then q⁺ = q ⊕ Δt v⁺: of first order, one evaluation of the dynamics. The linear velocity of a floating base is stepped in the
    /// world, so that a free body keeps its momentum, see [`JointKind::advance`](crate::joint::JointKind::advance).
    ///
    /// Forces are those of the start of the step but for two kinds, which no short enough step can be found for beforehand:
    ///
    /// * Dampers, springs, dry friction, speed limits and stops of joints are those of its end, linear in v⁺ with the coefficients of its start:
    ///   (M + Δt C + Δt² K) a = τ − h − Δt K v. So joints are stable at any stiffness and any step. A stop that would pull is let go.
    ///   Robots without any of these take the step of textbooks.
    /// * Where a coordinate turns by more than 0.1 rad in a step, and faster than 100 rad/s, Coriolis and centrifugal forces become those of the middle of
    ///   the step, as with [`ImplicitVelocity`](Self::ImplicitVelocity), wholly at twice that speed; their share grows as 3 x² − 2 x³ between, so that
    ///   the step and its derivatives are continuous. Light wrists that whirl stay finite. The first step that needs it allocates. With kinematic
    ///   constraints these forces are always those of the middle, which linkages need to keep their energy.
    ///
    /// Below that angle a nutation at the rate λ grows by √(1 + (λ Δt)²) in each step: a body that spins gains energy, slowly at ordinary rates.
    #[default]
    SemiImplicitEuler,
    /// Semi-implicit Euler with more of its forces inside the step: springs, viscous and dry friction and speed limits of joints, their stops,
    /// and [soft contact](crate::contact::SoftContact) are those of its end, each linear in the velocity v⁺ after the step with the coefficients
    /// of its start, but never pulling and within the cone of friction, which a solver sees to. So damping of any strength is stable at any
    /// step, and so are stops; contact far stiffer than the step resolves may bounce.
    ///
    /// Coriolis and centrifugal forces c(q, v) are those of its middle, to first order in the acceleration:
    /// M a + c(v) + ½ Δt ∂c/∂v a = τ − g. Spinning bodies are stable at any rate and keep energy and momentum, see above. Where contact and stops act,
    /// ∂c/∂v is applied to the acceleration that there would be without them, so that the problem of the solver stays symmetric: that under the
    /// forces of kinematic constraints alone.
    ///
    /// Of first order. Motors' torque–speed curves, external forces and gravity are those of the start.
    ///
    /// # References
    /// [Hairer, Wanner 1996, section IV.7] for methods that solve with a Jacobian once.
    ImplicitVelocity,
    /// The classical method of fourth order, four evaluations, in tangent coordinates of the manifold [Munthe-Kaas 1999]. All forces are explicit: with
    /// a damper d on an inertia I it diverges where Δt d / I > 2.8.
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

/// Working memory of [`Simulator::step_into`]. It belongs to the model that it was made for and to clones of it; after a change of masses,
/// placements or armature a new one is needed.
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
            middle: (simulator.always_in_the_middle())
                .then(|| Box::new(MiddleScratch::new(simulator))),
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
    /// Status of the solver of the forces of contact and constraints in the last step, in a lane: the worst of all its evaluations, and
    /// [`Converged`](Status::Converged) where none was needed. What it means stands at [`ContactReport::certificate`](super::ContactReport).
    ///
    /// # Panics
    /// If there is no such lane.
    pub fn solver_status(&self, lane: usize) -> Status {
        assert!(lane < T::LANES, "there are {} lanes, none {lane}", T::LANES);
        let solver = self.constrained.as_ref();
        solver.map_or(Status::Converged, |solver| solver.status(lane))
    }

    /// Solution of the last evaluation of the dynamics.
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
