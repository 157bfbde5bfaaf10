//! The Jacobians of the step as a graph.

use nalgebra::DVector;

use super::origin::origin;
use super::ports::state_and_input;
use crate::autodiff::{CHUNK, seed};
use crate::scalar::traced::{Graph, Port, trace};
use crate::scalar::{Dual, Traced};
use crate::sim::{Simulator, State, StepScratch};

/// Traces the Jacobians of the step, δx⁺ = A δx + B δu in tangent coordinates: inputs as those of [`step`](super::step()), outputs `A`
/// and `B`, those of [`Simulator::linearize`].
///
/// Where no solver finds forces, [`Simulator::linearize`] itself is recorded, which differentiates along the tree. Through the solver of contact and
/// constraints dual numbers go along with the step, some directions at a time, in its last step alone.
///
/// # Panics
/// If the step decides on values, with the place: see [what can be traced](crate::scalar::traced).
#[cfg_attr(not(feature = "graphs"), inline)]
pub fn linearization(simulator: &Simulator) -> Graph {
    let (n, nu) = (simulator.n_tangent(), simulator.nu());
    let graph = trace(|t| {
        let (state, u) = state_and_input(t, simulator);
        let columns = if simulator.needs_solver() {
            columns_of_step(simulator, &state, &u)
        } else {
            let step = simulator.linearize_over(&state, &u);
            step.a.iter().chain(&step.b).copied().collect()
        };
        let (a, b) = columns.split_at(n * n);
        t.output(Port::matrix("A", n, n), a);
        t.output(Port::matrix("B", n, nu), b);
    });
    graph.with_origin(origin(simulator.model()))
}

/// A number with its derivatives in some directions, to be recorded.
type Number = Dual<Traced, CHUNK>;

/// A and B, column after column, of the step on dual numbers. Inlined as what calls it, or the library would compile the step over these.
#[cfg_attr(not(feature = "graphs"), inline)]
fn columns_of_step(simulator: &Simulator, state: &State<Traced>, u: &[Traced]) -> Vec<Traced> {
    let (n, width) = (simulator.n_tangent(), simulator.n_tangent() + u.len());
    let mut columns = Vec::with_capacity(n * width);
    let mut scratch = StepScratch::new(simulator);
    let start = lifted(state);
    let values = std::iter::repeat_n(Traced::from(0.0), n).chain(u.iter().copied());
    let mut z: Vec<Number> = values.map(Number::constant_of).collect();
    for first in (0..width).step_by(CHUNK) {
        let seeded = first..width.min(first + CHUNK);
        seed(&mut z, &seeded, Traced::from(1.0));
        let moved = start.integrate(simulator.model(), &z[..n]);
        let mut next = moved.clone();
        simulator.step_into(&moved, &z[n..], &mut scratch, &mut next);
        seed(&mut z, &seeded, Traced::from(0.0));
        let mut value = next.clone();
        let numbers = value.numbers_mut();
        numbers.for_each(|x| *x = Number::constant_of(x.re));
        let change = next.deviation(simulator.model(), &value);
        for direction in 0..seeded.len() {
            columns.extend(change.iter().map(|x| x.eps[direction]));
        }
    }
    columns
}

/// A state without derivatives.
fn lifted(state: &State<Traced>) -> State<Number> {
    let lift = |x: &DVector<Traced>| x.map(Number::constant_of);
    State {
        q: lift(&state.q),
        v: lift(&state.v),
        contact: lift(&state.contact),
    }
}
