//! Any method behind the activations of inputs: these give the signals over the step, and their own next state; derivatives follow by the chain rule.
//!
//! With the step x⁺ = f(x, s), the signals s = g(x, w, u) and the activations w⁺ = h(x, w, u),
//!
//! > δx⁺ = (A + B ∂g/∂x) δx + B ∂g/∂w δw + B ∂g/∂u δu  and  δw⁺ = ∂h/∂x δx + ∂h/∂w δw + ∂h/∂u δu.

use std::ops::Range;

use nalgebra::DMatrix;

use super::AccelerationScratch;
use super::method::{Pullback, Pushforward, Step, StepColumns, StepPoint};
use crate::cone::Status;
use crate::dynamics::Calls;
use crate::scalar::{Differentiable, Over, Scalar};
use crate::sim::activation::{PlacedActivation, Variable};
use crate::sim::parameter_slots::{SimulatorParameterGroup, add_to_part};
use crate::sim::signals::Signals;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::terms::StepGradientSum;

/// Working memory: that of the method, and of the activations.
#[derive(Clone, Debug)]
pub(crate) struct Activated<M, S> {
    pub(super) method: M,
    own: S,
}

impl<T: Scalar, M: Step<T>> Step<T> for Activated<M, Signals<T>> {
    fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        Self {
            method: Step::new(simulator),
            own: Signals::default(),
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
        let signal = self.own.find(simulator, state, u);
        self.method.step(simulator, state, signal, found, next);
        if !simulator.activations().is_empty() {
            next.activation
                .as_mut_slice()
                .copy_from_slice(self.own.next());
        }
    }

    fn status(&self, lane: usize) -> Status {
        self.method.status(lane)
    }
}

/// Signals, and the Jacobians of the step with these as its inputs.
#[derive(Clone, Debug)]
pub(crate) struct SignalColumns<T: Scalar> {
    signals: Signals<T>,
    a: DMatrix<T>,
    b: DMatrix<T>,
}

impl<T: Differentiable, M: Pushforward<T>> Pushforward<T> for Activated<M, SignalColumns<T>> {
    fn new(simulator: &Simulator, calls: Calls) -> Self {
        let [n, nu] = match simulator.activations().is_empty() {
            true => [0; 2],
            false => [simulator.n_motion(), simulator.nu()],
        };
        Self {
            method: Pushforward::new(simulator, calls),
            own: SignalColumns {
                signals: Signals::default(),
                a: DMatrix::zeros(n, n),
                b: DMatrix::zeros(n, nu),
            },
        }
    }

    fn linearize(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        out: &mut StepColumns<'_, T>,
    ) {
        if simulator.activations().is_empty() {
            return self.method.linearize(simulator, at, out);
        }
        let SignalColumns { signals, a, b } = &mut self.own;
        let u = signals.find(simulator, at.state, at.u);
        let inner = StepPoint { u, ..*at };
        self.method
            .linearize(simulator, &inner, &mut StepColumns { a, b });
        out.a.fill(T::zero());
        out.b.fill(T::zero());
        out.a.view_mut((0, 0), a.shape()).copy_from(&*a);
        out.b.view_mut((0, 0), b.shape()).copy_from(&*b);
        for own in simulator.activations() {
            add_columns(simulator, own, at, b, out);
        }
    }
}

/// Writes the columns of an input with an activation, and adds those of what the activation depends on.
///
/// * `b` – B of the step in its signals
fn add_columns<T: Scalar>(
    simulator: &Simulator,
    own: &PlacedActivation<f64>,
    at: &StepPoint<'_, T>,
    b: &DMatrix<T>,
    out: &mut StepColumns<'_, T>,
) {
    let (nv, n) = (simulator.model().nv(), simulator.n_motion());
    let (first, delay) = (n + own.first, own.own.delay_steps());
    let dynamic = first + delay;
    out.b.column_mut(own.input).fill(T::zero());
    for k in 1..delay {
        out.a[(first + k - 1, first + k)] = T::one();
    }
    if delay > 0 {
        out.b[(dynamic - 1, own.input)] = T::one();
    }
    own.each_derivative(
        simulator.time_step(),
        at.state,
        at.u,
        false,
        |of, output, slope| {
            let mut column = match (of, own.joint) {
                (Variable::Input, _) if delay == 0 => out.b.column_mut(own.input),
                (Variable::Input, _) => out.a.column_mut(first),
                (Variable::State(k), _) => out.a.column_mut(dynamic + k),
                (Variable::Position, Some(joint)) => out.a.column_mut(joint.v),
                (Variable::Velocity, Some(joint)) => out.a.column_mut(nv + joint.v),
                _ => return,
            };
            match output {
                0 => {
                    let by_signal = b.column(own.input);
                    let motion = column.iter_mut().zip(&by_signal);
                    motion.for_each(|(out, &b)| *out += b * slope);
                }
                output => column[dynamic + output - 1] += slope,
            }
        },
    );
}

/// Signals, and the derivatives in them.
#[derive(Clone, Debug)]
pub(crate) struct SignalDerivatives<T: Scalar> {
    signals: Signals<T>,
    by_signal: Vec<T>,
    /// Places of the numbers of each activation among all parameters.
    slots: Vec<Range<usize>>,
}

impl<T: Scalar, M: Pullback<T>> Pullback<T> for Activated<M, SignalDerivatives<T>> {
    fn new(simulator: &Simulator, calls: Calls) -> Self {
        Self {
            method: Pullback::new(simulator, calls),
            own: SignalDerivatives {
                signals: Signals::default(),
                by_signal: Vec::new(),
                slots: slots(simulator),
            },
        }
    }

    fn add_gradient(
        &mut self,
        simulator: &Simulator,
        at: &StepPoint<'_, T>,
        adjoint: &[T],
        out: &mut StepGradientSum<'_, T>,
    ) {
        if simulator.activations().is_empty() {
            return self.method.add_gradient(simulator, at, adjoint, out);
        }
        let SignalDerivatives {
            signals,
            by_signal,
            slots,
        } = &mut self.own;
        let u = signals.find(simulator, at.state, at.u);
        let inner = StepPoint { u, ..*at };
        let (motion, after) = adjoint.split_at(simulator.n_motion());
        by_signal.clear();
        by_signal.resize(simulator.nu(), T::zero());
        let mut of_motion = StepGradientSum {
            u: by_signal,
            q: &mut *out.q,
            v: &mut *out.v,
            contact: &mut *out.contact,
            activation: &mut [],
            parameters: &mut *out.parameters,
            has_parts: out.has_parts,
        };
        (self.method).add_gradient(simulator, &inner, motion, &mut of_motion);
        for (k, own) in simulator.activations().iter().enumerate() {
            let weights = Weights {
                signal: by_signal[own.input],
                after,
            };
            by_signal[own.input] = T::zero();
            weights.add(simulator, own, at, slots.get(k), out);
        }
        let inputs = out.u.iter_mut().zip(&*by_signal);
        inputs.for_each(|(out, &x)| *out += x);
    }
}

/// Weights of a signal, and of all activations after the step.
struct Weights<'a, T> {
    signal: T,
    after: &'a [T],
}

impl<T: Scalar> Weights<'_, T> {
    /// Adds the derivatives in all that an activation depends on.
    fn add(
        &self,
        simulator: &Simulator,
        own: &PlacedActivation<f64>,
        at: &StepPoint<'_, T>,
        slots: Option<&Range<usize>>,
        out: &mut StepGradientSum<'_, T>,
    ) {
        let (first, delay) = (own.first, own.own.delay_steps());
        let dynamic = first + delay;
        for k in 1..delay {
            out.activation[first + k] += self.after[first + k - 1];
        }
        if delay > 0 {
            out.u[own.input] += self.after[dynamic - 1];
        }
        let with_numbers = out.has_parts;
        own.each_derivative(
            simulator.time_step(),
            at.state,
            at.u,
            with_numbers,
            |of, output, slope| {
                let weight = match output {
                    0 => self.signal,
                    output => self.after[dynamic + output - 1],
                };
                let slope = weight * slope;
                match (of, own.joint) {
                    (Variable::Input, _) if delay == 0 => out.u[own.input] += slope,
                    (Variable::Input, _) => out.activation[first] += slope,
                    (Variable::State(k), _) => out.activation[dynamic + k] += slope,
                    (Variable::Position, Some(joint)) => out.q[joint.v] += slope,
                    (Variable::Velocity, Some(joint)) => out.v[joint.v] += slope,
                    (Variable::Position | Variable::Velocity, None) => {}
                    (Variable::TimeStep, _) => out.add_time_step(slope),
                    (Variable::Parameter(k), _) => {
                        let part = slots.map_or(0..0, |own| own.start + k..own.start + k + 1);
                        add_to_part(out.parameters, &part, &[slope], T::one());
                    }
                }
            },
        );
    }
}

/// Places of the numbers of each activation among all parameters.
fn slots(simulator: &Simulator) -> Vec<Range<usize>> {
    let n = simulator.activations().len();
    if n == 0 {
        return Vec::new();
    }
    let mut out = vec![0..0; n];
    for (group, range) in simulator.parameter_layout().groups() {
        if let SimulatorParameterGroup::Activation(k) = *group {
            out[k] = range.clone();
        }
    }
    out
}
