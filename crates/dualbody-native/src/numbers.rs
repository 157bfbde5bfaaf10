//! Inputs and outputs of the compiled functions of a simulator.

use dualbody::linearize::Linearization;
use dualbody::{Simulator, State};

use crate::function::NativeFunction;

/// The functions of a simulator, as far as they are compiled.
#[derive(Debug, Default)]
pub(crate) struct Functions {
    pub(crate) step: Option<NativeFunction>,
    pub(crate) jacobians: Option<NativeFunction>,
}

/// Memory for one state at a time.
#[derive(Clone, Debug)]
pub(crate) struct Numbers {
    /// q, v, the state of contact, u.
    inputs: Vec<f64>,
    next: Vec<f64>,
    /// A and B, by columns.
    jacobians: Vec<f64>,
}

impl Numbers {
    pub(crate) fn new(own: &Simulator, functions: &Functions) -> Self {
        let outputs = |function: &Option<NativeFunction>| {
            let n = function.as_ref().map(NativeFunction::n_outputs);
            vec![0.0; n.unwrap_or(0)]
        };
        Self {
            inputs: vec![0.0; own.neutral_state::<f64>().len() + own.nu()],
            next: outputs(&functions.step),
            jacobians: outputs(&functions.jacobians),
        }
    }

    /// Sets state and input.
    pub(crate) fn set(&mut self, inputs: impl IntoIterator<Item = f64>) {
        write(inputs, &mut self.inputs);
    }

    /// The next state, if the step is compiled and its conditions hold.
    pub(crate) fn step(&mut self, functions: &Functions) -> Option<&[f64]> {
        let step = functions.step.as_ref()?;
        step.holds(&self.inputs, &mut self.next)
            .then_some(&self.next)
    }

    /// Writes A and B, if they are compiled and their conditions hold. Returns whether it did.
    pub(crate) fn linearize(&mut self, functions: &Functions, out: &mut Linearization) -> bool {
        let Some(jacobians) = &functions.jacobians else {
            return false;
        };
        let holds = jacobians.holds(&self.inputs, &mut self.jacobians);
        if holds {
            let (a, b) = self.jacobians.split_at(out.a.len());
            out.a.as_mut_slice().copy_from_slice(a);
            out.b.as_mut_slice().copy_from_slice(b);
        }
        holds
    }
}

/// Numbers of a state and an input, in the order of the inputs of the functions.
pub(crate) fn of<'a>(state: &'a State, u: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    state.numbers().chain(u).copied()
}

pub(crate) fn write(numbers: impl IntoIterator<Item = f64>, out: &mut [f64]) {
    out.iter_mut().zip(numbers).for_each(|(out, x)| *out = x);
}
