//! A simulator whose steps are compiled.
//!
//! Functions that need the library's own code of a step, to trace it or without a compiler, are compiled in programs that call them: these have that code anyway.

use std::num::NonZero;
use std::thread;

use dualbody::cone::Status;
use dualbody::linearize::{Linearization, LinearizeScratch};
use dualbody::sim::{Rollout, StepScratch};
use dualbody::{Simulator, State, codegen};

use crate::compiler::Compiler;
use crate::error::NativeError;
use crate::function::NativeFunction;
use crate::numbers::{self, Functions, Numbers};

/// A [`Simulator`] whose steps, and [on request](Self::with_jacobians) Jacobians, are compiled for its robot.
///
/// The library's own code computes a step if a state violates a condition of the compiled one (see [what can be traced](dualbody::scalar::traced)), or
/// if compilation failed. Results are the same to rounding. Forces of regularised contact and of constraints agree to about 1e-7 of the change of
/// velocity in a step.
#[derive(Debug)]
pub struct NativeSimulator {
    pub(crate) own: Simulator,
    pub(crate) functions: Functions,
    reason: Option<NativeError>,
}

/// Working memory of one thread.
#[derive(Clone, Debug)]
pub struct NativeScratch {
    numbers: Numbers,
    step: StepScratch<f64>,
    linearize: LinearizeScratch,
}

impl NativeScratch {
    /// Makes memory for a simulator.
    #[inline]
    pub fn new(native: &NativeSimulator) -> Self {
        Self {
            numbers: Numbers::new(&native.own, &native.functions),
            step: StepScratch::new(&native.own),
            linearize: LinearizeScratch::new(&native.own),
        }
    }
}

impl NativeSimulator {
    /// Traces and compiles the step of a simulator.
    ///
    /// # Errors
    /// If it cannot be compiled or loaded.
    ///
    /// # Panics
    /// If the step decides on values, as the solver of rigid contact does: see [what can be traced](dualbody::scalar::traced).
    #[inline]
    pub fn new(simulator: Simulator, compiler: &Compiler) -> Result<Self, NativeError> {
        let graph = codegen::step(&simulator);
        let step = NativeFunction::new(&graph, "dualbody_step", compiler)?;
        Ok(Self {
            own: simulator,
            functions: Functions {
                step: Some(step),
                jacobians: None,
            },
            reason: None,
        })
    }

    /// [`new`](Self::new) that uses the library's own code if compilation fails; [`reason`](Self::reason) explains why.
    ///
    /// # Panics
    /// As [`new`](Self::new) does.
    #[inline]
    pub fn or_own(simulator: Simulator, compiler: &Compiler) -> Self {
        Self::new(simulator.clone(), compiler).unwrap_or_else(|reason| Self {
            own: simulator,
            functions: Functions::default(),
            reason: Some(reason),
        })
    }

    /// Compiles A and B as well. The compiler takes about a second for an arm and a minute for a humanoid, for which the library's loops are faster: see
    /// [the table](dualbody::scalar::traced#size-and-speed). Does nothing if the step could not be compiled.
    ///
    /// # Errors
    /// If they cannot be compiled or loaded.
    #[inline]
    pub fn with_jacobians(mut self, compiler: &Compiler) -> Result<Self, NativeError> {
        if self.functions.step.is_some() {
            let graph = codegen::linearization(&self.own);
            self.functions.jacobians =
                Some(NativeFunction::new(&graph, "dualbody_jacobians", compiler)?);
        }
        Ok(self)
    }

    /// The simulator from which it was made.
    pub fn simulator(&self) -> &Simulator {
        &self.own
    }

    /// Reason why compilation failed; `None` if the step is compiled.
    pub fn reason(&self) -> Option<&NativeError> {
        self.reason.as_ref()
    }

    /// Takes a step, as [`Simulator::step_into`] does. Does not allocate.
    ///
    /// # Panics
    /// If state, input, scratch or output have the wrong size.
    #[inline]
    pub fn step_into(&self, state: &State, u: &[f64], s: &mut NativeScratch, next: &mut State) {
        self.take_step(state, u, s, next);
    }

    /// [`step_into`](Self::step_into) that returns the status of the solver of contact and constraints.
    #[inline]
    fn take_step(
        &self,
        state: &State,
        u: &[f64],
        s: &mut NativeScratch,
        next: &mut State,
    ) -> Status {
        self.check(state, u);
        s.numbers.set(numbers::of(state, u));
        if let Some(own) = s.numbers.step(&self.functions) {
            next.copy_from_slice(own);
            return Status::Converged;
        }
        self.own.step_into(state, u, &mut s.step, next);
        s.step.solver_status(0)
    }

    /// Computes A and B of a step, as [`Simulator::linearize_into`] does; by compiled code after [`with_jacobians`](Self::with_jacobians).
    ///
    /// # Panics
    /// If state, input, scratch or output have the wrong size.
    #[inline]
    pub fn linearize_into(
        &self,
        state: &State,
        u: &[f64],
        s: &mut NativeScratch,
        out: &mut Linearization,
    ) {
        self.check(state, u);
        s.numbers.set(numbers::of(state, u));
        if !s.numbers.linearize(&self.functions, out) {
            self.own.linearize_into(state, u, &mut s.linearize, out);
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
        control: impl FnMut(f64, &State, &mut [f64]),
    ) -> Rollout {
        let mut scratch = NativeScratch::new(self);
        let step = |state: &State, u: &[f64], next: &mut State| {
            self.take_step(state, u, &mut scratch, next)
        };
        self.own.rollout_of_steps(initial, steps, control, step)
    }

    /// Takes one step of each of many states, on all cores.
    ///
    /// * `inputs` – the input of one state after the other, `nu` numbers each
    ///
    /// # Panics
    /// If a state has the wrong length, or the number of inputs is wrong.
    #[inline]
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

    #[inline]
    fn step_group(&self, states: &mut [State], inputs: &[f64]) {
        let (nu, n) = (self.own.nu(), states.first().map_or(0, State::len));
        let input = |i: usize| &inputs[nu * i..nu * (i + 1)];
        let mut scratch = None;
        let mut by_own = |i: usize, state: &mut State| {
            let scratch = scratch.get_or_insert_with(|| StepScratch::new(&self.own));
            let start = state.clone();
            self.own.step_into(&start, input(i), scratch, state);
        };
        let Some(step) = &self.functions.step else {
            return states
                .iter_mut()
                .enumerate()
                .for_each(|(i, state)| by_own(i, state));
        };
        let mut given = vec![0.0; (n + nu) * states.len()];
        for (i, state) in states.iter().enumerate() {
            self.check(state, input(i));
            let own = &mut given[(n + nu) * i..(n + nu) * (i + 1)];
            numbers::write(numbers::of(state, input(i)), own);
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
            "the contact state"
        );
        let n_activation = self.own.n_activation();
        assert_eq!(state.activation.len(), n_activation, "the activations");
        assert_eq!(u.len(), self.own.nu(), "the input");
    }
}
