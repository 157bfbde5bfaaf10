//! The adjoint of a step of any integrator, over plain numbers or over dual ones, which differentiate it once more.

use super::acceleration::AccelerationAdjoint;
use super::euler;
use super::runge_kutta_4::StageAdjoint;
use crate::dynamics::Calls;
use crate::scalar::Scalar;
use crate::sim::{Integrator, Moment, Simulator, State, StepScratch, StepSlopes};

/// A step whose gradient is taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepPoint<'a, T: Scalar = f64> {
    pub(crate) state: &'a State<T>,
    pub(crate) u: &'a [T],
    /// The acceleration, where the step has been taken before.
    pub(crate) acceleration: Option<&'a [T]>,
}

/// Working memory of [`add_gradient`](Self::add_gradient), of the model that it was made for.
#[derive(Clone, Debug)]
pub(crate) struct StepAdjoint<T: Scalar> {
    step: StepScratch<T>,
    next: State<T>,
    method: Method<T>,
}

#[derive(Clone, Debug)]
enum Method<T: Scalar> {
    Euler(Box<AccelerationAdjoint<T>>),
    RungeKutta4(Box<StageAdjoint<T>>),
}

impl<T: Scalar> StepAdjoint<T> {
    pub(crate) fn new(simulator: &Simulator, calls: Calls) -> Self {
        let method = match simulator.integrator() {
            Integrator::SemiImplicitEuler | Integrator::ImplicitVelocity => {
                Method::Euler(Box::new(AccelerationAdjoint::new(simulator, calls)))
            }
            Integrator::RungeKutta4 => {
                Method::RungeKutta4(Box::new(StageAdjoint::new(simulator, calls)))
            }
        };
        Self {
            step: StepScratch::for_calls(simulator, calls),
            next: simulator.neutral_state(),
            method,
        }
    }

    /// Whether the integrator is the one that the memory was made for.
    pub(crate) fn is_of(&self, simulator: &Simulator) -> bool {
        let has_stages = simulator.integrator() == Integrator::RungeKutta4;
        has_stages == matches!(self.method, Method::RungeKutta4(_))
    }

    /// Adds the gradient of λᵀ x⁺ of a step.
    ///
    /// * `adjoint` – λ, along the tangent of the next state
    pub(crate) fn add_gradient(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        adjoint: &[T],
        out: &mut StepSlopes<'_, T>,
    ) {
        let StepPoint { state, u, .. } = *at;
        match &mut self.method {
            Method::Euler(acceleration) => {
                let (step, next) = (&mut self.step, &mut self.next);
                match at.acceleration {
                    None => simulator.step_into(state, u, step, next),
                    Some(a) => simulator.step_again_into(state, u, a, step, next),
                }
                let (at, found) = (Moment::of_step(simulator, state, u), &mut step.acceleration);
                euler::add_gradient(&at, found, next, adjoint, acceleration, out);
            }
            Method::RungeKutta4(stages) => {
                simulator.check_input(u);
                simulator.check(state);
                let at = Moment::of_step(simulator, state, u);
                stages.add_gradient(&at, adjoint, out);
            }
        }
    }
}
