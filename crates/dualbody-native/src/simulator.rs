//! A simulator whose steps are compiled.

use std::num::NonZero;
use std::thread;

use dualbody::linearize::{Linearization, LinearizeScratch};
use dualbody::sim::{Rollout, RolloutStatus, StepScratch};
use dualbody::{Simulator, State, codegen};
use nalgebra::DVector;

use crate::compiler::Compiler;
use crate::error::NativeError;
use crate::function::NativeFunction;

/// A [`Simulator`] whose steps, and Jacobians if they are [wanted](Self::with_jacobians), are compiled for its robot.
///
/// Where a step takes something for granted that does not hold at a state (see [what can be traced](dualbody::scalar::traced)), and where nothing
/// could be compiled, the library's own code computes it: results are the same to rounding.
#[derive(Debug)]
pub struct NativeSimulator {
    pub(crate) own: Simulator,
    pub(crate) step: Option<NativeFunction>,
    pub(crate) jacobians: Option<NativeFunction>,
    reason: Option<NativeError>,
}

/// Working memory of one thread.
#[derive(Clone, Debug)]
pub struct NativeScratch {
    /// q, v, the state of contact, u.
    inputs: Vec<f64>,
    next: Vec<f64>,
    /// A and B, by columns.
    jacobians: Vec<f64>,
    step: StepScratch<f64>,
    linearize: LinearizeScratch,
}

impl NativeScratch {
    /// Memory for a simulator.
    pub fn new(native: &NativeSimulator) -> Self {
        let own = &native.own;
        let size = |function: &Option<NativeFunction>| {
            let outputs = function.as_ref().map(NativeFunction::n_outputs);
            vec![0.0; outputs.unwrap_or(0)]
        };
        Self {
            inputs: vec![0.0; own.neutral_state::<f64>().len() + own.nu()],
            next: size(&native.step),
            jacobians: size(&native.jacobians),
            step: StepScratch::new(own),
            linearize: LinearizeScratch::new(own),
        }
    }

    fn set(&mut self, state: &State, u: &[f64]) {
        let (of_state, of_input) = self.inputs.split_at_mut(state.len());
        state.copy_to_slice(of_state);
        of_input.copy_from_slice(u);
    }
}

impl NativeSimulator {
    /// Traces and compiles the step of a simulator.
    ///
    /// # Errors
    /// If it cannot be compiled or loaded.
    ///
    /// # Panics
    /// If the step decides on values, as solvers of contact do: see [what can be traced](dualbody::scalar::traced).
    pub fn new(simulator: Simulator, compiler: &Compiler) -> Result<Self, NativeError> {
        let graph = codegen::step(&simulator);
        let step = NativeFunction::new(&graph, "dualbody_step", compiler)?;
        Ok(Self {
            own: simulator,
            step: Some(step),
            jacobians: None,
            reason: None,
        })
    }

    /// [`new`](Self::new) that falls back on the library's own code where nothing can be compiled; [`reason`](Self::reason) says why.
    ///
    /// # Panics
    /// As [`new`](Self::new) does.
    pub fn or_own(simulator: Simulator, compiler: &Compiler) -> Self {
        Self::new(simulator.clone(), compiler).unwrap_or_else(|reason| Self {
            own: simulator,
            step: None,
            jacobians: None,
            reason: Some(reason),
        })
    }

    /// Compiles A and B too. The compiler takes a second or so for an arm, a minute for a humanoid, whose own loops are faster then: see
    /// [the table](dualbody::scalar::traced#how-large-it-gets). Does nothing where the step could not be compiled.
    ///
    /// # Errors
    /// If they cannot be compiled or loaded.
    pub fn with_jacobians(mut self, compiler: &Compiler) -> Result<Self, NativeError> {
        if self.step.is_some() {
            let graph = codegen::linearization(&self.own);
            self.jacobians = Some(NativeFunction::new(&graph, "dualbody_jacobians", compiler)?);
        }
        Ok(self)
    }

    /// The simulator that it was made of.
    pub fn simulator(&self) -> &Simulator {
        &self.own
    }

    /// Reason why nothing was compiled; `None` if it was.
    pub fn reason(&self) -> Option<&NativeError> {
        self.reason.as_ref()
    }

    /// Takes a step, as [`Simulator::step_into`] does. Does not allocate.
    ///
    /// # Panics
    /// If state, input, scratch or output have the wrong size.
    pub fn step_into(&self, state: &State, u: &[f64], s: &mut NativeScratch, next: &mut State) {
        self.check(state, u);
        s.set(state, u);
        match &self.step {
            Some(step) if step.holds(&s.inputs, &mut s.next) => next.copy_from_slice(&s.next),
            _ => self.own.step_into(state, u, &mut s.step, next),
        }
    }

    /// Computes A and B of a step, as [`Simulator::linearize_into`] does: by compiled code if [they are](Self::with_jacobians).
    ///
    /// # Panics
    /// If state, input, scratch or output have the wrong size.
    pub fn linearize_into(
        &self,
        state: &State,
        u: &[f64],
        s: &mut NativeScratch,
        out: &mut Linearization,
    ) {
        self.check(state, u);
        s.set(state, u);
        match &self.jacobians {
            Some(function) if function.holds(&s.inputs, &mut s.jacobians) => {
                write_jacobians(&s.jacobians, out);
            }
            _ => self.own.linearize_into(state, u, &mut s.linearize, out),
        }
    }

    /// Takes up to `steps` steps, as [`Simulator::rollout`] does.
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn rollout(
        &self,
        initial: &State,
        steps: usize,
        mut control: impl FnMut(f64, &State, &mut [f64]),
    ) -> Rollout {
        let (own, mut scratch) = (&self.own, NativeScratch::new(self));
        let (mut states, mut inputs) = (vec![initial.clone()], Vec::new());
        let (mut next, mut status) = (initial.clone(), RolloutStatus::Completed);
        for step in 0..steps {
            let mut u = DVector::zeros(own.nu());
            let state = &states[step];
            control(step as f64 * own.time_step(), state, u.as_mut_slice());
            if !u.iter().all(|u| u.is_finite()) {
                status = RolloutStatus::NonFiniteInput { step };
                break;
            }
            self.step_into(state, u.as_slice(), &mut scratch, &mut next);
            if !next.is_finite() || next.v.amax() > own.divergence_bound() {
                status = RolloutStatus::Diverged { step };
                break;
            }
            states.push(next.clone());
            inputs.push(u);
        }
        let mut rollout = Rollout::new(own.model(), own.time_step(), states, inputs);
        rollout.status = status;
        rollout.with_input_names(own.input_names())
    }

    /// Takes one step of each of many states, on all cores.
    ///
    /// * `inputs` – those of one state after the other, `nu` numbers each
    ///
    /// # Panics
    /// If a state has another size, or there are not as many inputs.
    pub fn step_states(&self, states: &mut [State], inputs: &[f64]) {
        let (nu, count) = (self.own.nu(), states.len());
        assert_eq!(inputs.len(), nu * count, "the inputs of {count} states");
        let threads = thread::available_parallelism().map_or(1, NonZero::get);
        let size = count.div_ceil(threads).max(1);
        thread::scope(|scope| {
            for (group, states) in states.chunks_mut(size).enumerate() {
                let first = nu * size * group;
                let inputs = &inputs[first..first + nu * states.len()];
                scope.spawn(move || self.step_group(states, inputs));
            }
        });
    }

    fn step_group(&self, states: &mut [State], inputs: &[f64]) {
        let (nu, n) = (self.own.nu(), states.first().map_or(0, State::len));
        let input = |i: usize| &inputs[nu * i..nu * (i + 1)];
        let mut scratch = None;
        let mut by_own = |i: usize, state: &mut State| {
            let scratch = scratch.get_or_insert_with(|| StepScratch::new(&self.own));
            let start = state.clone();
            self.own.step_into(&start, input(i), scratch, state);
        };
        let Some(step) = &self.step else {
            return states
                .iter_mut()
                .enumerate()
                .for_each(|(i, state)| by_own(i, state));
        };
        let mut given = vec![0.0; (n + nu) * states.len()];
        for (i, state) in states.iter().enumerate() {
            self.check(state, input(i));
            let (of_state, of_input) = given[(n + nu) * i..(n + nu) * (i + 1)].split_at_mut(n);
            state.copy_to_slice(of_state);
            of_input.copy_from_slice(input(i));
        }
        let (mut next, mut status) = (vec![0.0; n * states.len()], vec![0; states.len()]);
        step.call_batch(&given, &mut next, &mut status);
        for (i, (state, status)) in states.iter_mut().zip(status).enumerate() {
            match status {
                0 => state.copy_from_slice(&next[n * i..n * (i + 1)]),
                _ => by_own(i, state),
            }
        }
    }

    fn check(&self, state: &State, u: &[f64]) {
        let model = self.own.model();
        assert_eq!(state.q.len(), model.nq(), "q of \"{}\"", model.name());
        assert_eq!(state.v.len(), model.nv(), "v of \"{}\"", model.name());
        assert_eq!(
            state.contact.len(),
            self.own.n_contact(),
            "the state of contact"
        );
        assert_eq!(u.len(), self.own.nu(), "the input");
    }
}

/// Splits A and B, each by columns.
pub(crate) fn write_jacobians(numbers: &[f64], out: &mut Linearization) {
    let (a, b) = numbers.split_at(out.a.len());
    out.a.as_mut_slice().copy_from_slice(a);
    out.b.as_mut_slice().copy_from_slice(b);
}
