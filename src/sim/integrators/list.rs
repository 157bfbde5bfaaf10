//! The list of integrators: the only place that names all of them.

use super::activated::{Activated, SignalColumns, SignalDerivatives};
use super::method::{Pullback, Pushforward, Step, StepColumns, StepPoint};
use super::{AccelerationScratch, euler, implicit_midpoint, runge_kutta_4};
use crate::cone::Status;
use crate::dynamics::Calls;
use crate::scalar::{Differentiable, Over, Scalar};
use crate::sim::integrator::Integrator;
use crate::sim::signals::Signals;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::StepGradientSum;

/// Declares the list: memory of one method out of all, and the traits of a method, which go to that one.
macro_rules! list_integrators {
    ($($method:ident: $module:ident, $($integrator:ident)|+;)*) => {
        /// Working memory of one of the methods, for its step, for Jacobians, or for gradients.
        #[derive(Clone, Debug)]
        pub(crate) enum Method<$($method),*> {
            $($method(Box<$method>),)*
        }

        /// For steps.
        pub(crate) type StepMemory<T> = Activated<Method<$($module::Memory<T>),*>, Signals<T>>;
        /// For Jacobians of steps.
        pub(crate) type StepJacobian<T> = Activated<Method<$($module::Columns<T>),*>, SignalColumns<T>>;
        /// For gradients of steps, over plain numbers or over dual ones, which differentiate them once more.
        pub(crate) type StepAdjoint<T> = Activated<Method<$($module::Adjoint<T>),*>, SignalDerivatives<T>>;

        impl<$($method),*, S> Activated<Method<$($method),*>, S> {
            /// Whether it is for the method of an integrator.
            pub(crate) fn is_of(&self, integrator: Integrator) -> bool {
                match self.method {
                    $(Method::$method(_) => matches!(integrator, $(Integrator::$integrator)|+),)*
                }
            }
        }

        impl<T: Scalar, $($method: Step<T>),*> Step<T> for Method<$($method),*> {
            fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
                match simulator.integrator() {
                    $($(Integrator::$integrator)|+ => Self::$method(Box::new(Step::new(simulator))),)*
                }
            }

            #[inline]
            fn step<P: Scalar>(
                &mut self,
                simulator: &Simulator<P>,
                state: &State<T>,
                u: &[T],
                found: &mut AccelerationScratch<T>,
                next: &mut State<T>,
            ) where
                T: Over<P>,
            {
                match self {
                    $(Self::$method(own) => own.step(simulator, state, u, found, next),)*
                }
            }

            fn status(&self, lane: usize) -> Status {
                match self {
                    $(Self::$method(own) => own.status(lane),)*
                }
            }
        }

        impl<T: Differentiable, $($method: Pushforward<T>),*> Pushforward<T> for Method<$($method),*> {
            fn new(simulator: &Simulator, calls: Calls) -> Self {
                match simulator.integrator() {
                    $($(Integrator::$integrator)|+ => {
                        Self::$method(Box::new(Pushforward::new(simulator, calls)))
                    })*
                }
            }

            fn linearize(
                &mut self,
                simulator: &Simulator,
                at: &StepPoint<'_, T>,
                out: &mut StepColumns<'_, T>,
            ) {
                match self {
                    $(Self::$method(own) => own.linearize(simulator, at, out),)*
                }
            }
        }

        impl<T: Scalar, $($method: Pullback<T>),*> Pullback<T> for Method<$($method),*> {
            fn new(simulator: &Simulator, calls: Calls) -> Self {
                match simulator.integrator() {
                    $($(Integrator::$integrator)|+ => {
                        Self::$method(Box::new(Pullback::new(simulator, calls)))
                    })*
                }
            }

            fn add_gradient(
                &mut self,
                simulator: &Simulator,
                at: &StepPoint<'_, T>,
                adjoint: &[T],
                out: &mut StepGradientSum<'_, T>,
            ) {
                match self {
                    $(Self::$method(own) => own.add_gradient(simulator, at, adjoint, out),)*
                }
            }
        }
    };
}

list_integrators! {
    Euler: euler, SemiImplicitEuler | ImplicitVelocity;
    RungeKutta4: runge_kutta_4, RungeKutta4;
    ImplicitMidpoint: implicit_midpoint, ImplicitMidpoint;
}
