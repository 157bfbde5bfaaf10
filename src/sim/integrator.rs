//! How a step is taken, on the configuration manifold.

use nalgebra::DVector;

use super::simulator::Simulator;
use super::state::State;
use crate::dynamics::AbaScratch;
use crate::model::Model;
use crate::scalar::{Over, Scalar};

/// The integration method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Integrator {
    /// v⁺ = v + Δt v̇(q, v, u), then q⁺ = q ⊕ Δt v⁺: first order, one evaluation, no energy drift on average.
    #[default]
    SemiImplicitEuler,
    /// The classical method of fourth order, four evaluations, in tangent coordinates of the manifold [Munthe-Kaas 1999].
    RungeKutta4,
}

/// Working memory of [`Simulator::step_into`].
#[derive(Clone, Debug)]
pub struct StepScratch<T: Scalar> {
    pub(super) aba: AbaScratch<T>,
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
}

impl<T: Scalar> StepScratch<T> {
    /// Memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        let nv = model.nv();
        let zeros = || DVector::zeros(nv);
        Self {
            aba: AbaScratch::new(model),
            tau: vec![T::zero(); nv],
            a: vec![T::zero(); nv],
            stage: State::neutral(model),
            offset: zeros(),
            rate: zeros(),
            sum_rate: zeros(),
            sum_a: zeros(),
        }
    }
}

impl<T: Scalar> StepScratch<T> {
    /// The acceleration of the last evaluation of the dynamics.
    pub(crate) fn acceleration(&self) -> &[T] {
        &self.a
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
        match self {
            Self::SemiImplicitEuler => semi_implicit_euler(simulator, state, u, scratch, next),
            Self::RungeKutta4 => runge_kutta_4(simulator, state, u, scratch, next),
        }
    }
}

fn semi_implicit_euler<P: Scalar, T: Over<P>>(
    simulator: &Simulator<P>,
    state: &State<T>,
    u: &[T],
    scratch: &mut StepScratch<T>,
    next: &mut State<T>,
) {
    let dt = simulator.time_step();
    simulator.accelerate(state.q.as_slice(), state.v.as_slice(), u, scratch);
    // v⁺ = v + Δt v̇,  q⁺ = q ⊕ Δt v⁺
    let next_v = next.v.as_mut_slice().iter_mut();
    let offset = scratch.offset.as_mut_slice().iter_mut();
    for (((next, offset), &v), &a) in next_v.zip(offset).zip(state.v.as_slice()).zip(&scratch.a) {
        *next = v + a * dt;
        *offset = *next * dt;
    }
    simulator.model().integrate_into(
        state.q.as_slice(),
        scratch.offset.as_slice(),
        next.q.as_mut_slice(),
    );
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
    }
    model.integrate_into(
        state.q.as_slice(),
        scratch.sum_rate.as_slice(),
        next.q.as_mut_slice(),
    );
    next.v.copy_from(&state.v);
    add_scaled(&mut next.v, scratch.sum_a.as_slice(), 1.0);
}

fn start_at<T: Scalar>(state: &State<T>, scratch: &mut StepScratch<T>) {
    scratch.stage.q.copy_from(&state.q);
    scratch.stage.v.copy_from(&state.v);
    scratch.offset.fill(T::zero());
    scratch.sum_rate.fill(T::zero());
    scratch.sum_a.fill(T::zero());
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
    let stage = std::mem::replace(
        &mut scratch.stage,
        State {
            q: DVector::zeros(0),
            v: DVector::zeros(0),
        },
    );
    simulator.accelerate(stage.q.as_slice(), stage.v.as_slice(), u, scratch);
    scratch.stage = stage;
}

/// out += x s
fn add_scaled<T: Scalar>(out: &mut DVector<T>, x: &[T], s: f64) {
    out.iter_mut().zip(x).for_each(|(out, &x)| *out += x * s);
}
