//! Costs that are linear in states and inputs.

use dualbody::Scalar;
use dualbody::linearize::{RolloutCost, RolloutGradient, RolloutGradientOptions};

use crate::prelude::*;

/// A cost that is linear in the numbers of states and inputs: what a gradient in them makes of any cost. Weights that are left out are zero.
pub(crate) struct Weighted<'a> {
    pub(crate) steps: usize,
    pub(crate) q: &'a [f64],
    pub(crate) v: &'a [f64],
    pub(crate) contact: &'a [f64],
    pub(crate) u: &'a [f64],
}

/// Sum of numbers with the weights of a step, of so many; zero without weights. A state in the tangent has no numbers for sleep, which the weights have.
fn weighted<'x, T: Scalar>(
    weights: &[f64],
    steps: usize,
    step: usize,
    x: impl Iterator<Item = &'x T>,
) -> T {
    let own = weights.iter().skip(step * (weights.len() / steps.max(1)));
    let products = own.zip(x).map(|(&w, &x)| x * w);
    products.fold(T::zero(), |sum, product| sum + product)
}

impl Weighted<'_> {
    /// Its gradient over a rollout with inputs, row after row.
    pub(crate) fn pull(
        &self,
        simulator: &Simulator,
        start: &State,
        inputs: &[f64],
        options: &RolloutGradientOptions,
    ) -> RolloutGradient {
        let nu = simulator.nu();
        let input = |k: usize| DVector::from_column_slice(&inputs[k * nu..(k + 1) * nu]);
        let inputs: Vec<_> = (0..self.steps).map(input).collect();
        let start = std::slice::from_ref(start);
        let mut all = simulator.rollout_gradients(start, &[inputs], self, options);
        all.swap_remove(0)
    }

    fn state<T: Scalar>(&self, step: usize, state: &State<T>) -> T {
        let (n, beside) = (
            self.steps + 1,
            state.contact.iter().chain(&state.activation),
        );
        weighted(self.q, n, step, state.q.iter())
            + weighted(self.v, n, step, state.v.iter())
            + weighted(self.contact, n, step, beside)
    }
}

impl RolloutCost for Weighted<'_> {
    fn stage<T: Scalar>(&self, step: usize, state: &State<T>, u: &[T]) -> T {
        self.state(step, state) + weighted(self.u, self.steps, step, u.iter())
    }

    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        self.state(self.steps, last)
    }
}
