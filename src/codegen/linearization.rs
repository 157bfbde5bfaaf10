//! The Jacobians of the step as a graph.

use nalgebra::DVector;

use super::origin::trace_of;
use super::ports::{Varied, state_and_input};
use crate::autodiff::{CHUNK, seed};
use crate::error::UnknownName;
use crate::scalar::traced::{Graph, Port, Tracer};
use crate::scalar::{Dual, Traced};
use crate::sim::{Simulator, State, StepScratch};

/// Traces the Jacobians of the step, δx⁺ = A δx + B δu in tangent coordinates: inputs as those of [`step`](super::step()), outputs `A`
/// and `B`, those of [`Simulator::linearize`].
///
/// Without a force solver, it records [`Simulator::linearize`], which differentiates along the tree. With a solver, and for
/// [variants](linearization_of_variants), it records the step over dual numbers, several directions at a time, with derivatives of the solver only in
/// its last step. [`Graph::jacobian`], which uses only operations, is for graphs of other functions. The table shows the number of operations of the
/// three methods; numbers in brackets are those of parameters (masses and dampings) in the last two:
///
/// | | along the tree | dual numbers | [`Graph::jacobian`] of the step |
/// |---|---|---|---|
/// | UR5 (12) | 3,903 | 9,949 | 21,682 |
/// | Panda (17) | 8,345 | 19,353 | 47,162 |
/// | quadruped (31) | 23,216 | 46,565 | 151,556 |
/// | UR5 (12), [`RungeKutta4`](crate::Integrator::RungeKutta4) | 21,076 | 105,275 | 79,276 |
/// | quadruped (31), the same | 238,700 | 679,401 | 567,186 |
/// | ball on a slope, regularised rigid contact | – | 22,597 | 161,324 |
///
/// # Panics
/// If the step depends on values by branches; the message contains the location: see [what can be traced](crate::scalar::traced).
#[cfg_attr(not(feature = "graphs"), inline)]
pub fn linearization(simulator: &Simulator) -> Graph {
    trace_of(simulator.model(), |t| {
        let (state, u) = state_and_input(t, simulator);
        if simulator.needs_solver() {
            output_jacobians(
                t,
                simulator,
                &columns_of_step(&simulator.cast(), &state, &u),
            );
        } else {
            let step = simulator.linearize(&state, &u);
            let columns: Vec<Traced> = step.a.iter().chain(&step.b).copied().collect();
            output_jacobians(t, simulator, &columns);
        }
    })
}

/// Traces A and B of the step of variants of a robot: inputs and outputs as those of [`linearization`], with the input `parameters` at the end.
///
/// It records the step over dual numbers: see the table of [`linearization`].
///
/// * `parameters` – names in [`Simulator::parameter_layout`]; all others are constants of the graph. Without any it is [`linearization`].
///
/// # Errors
/// If there is no parameter with this name.
///
/// # Panics
/// If the step depends on values by branches: see [what can be traced](crate::scalar::traced).
#[cfg_attr(not(feature = "graphs"), inline)]
pub fn linearization_of_variants(
    simulator: &Simulator,
    parameters: &[&str],
) -> Result<Graph, UnknownName> {
    if parameters.is_empty() {
        return Ok(linearization(simulator));
    }
    let varied = Varied::new(simulator, parameters)?;
    Ok(trace_of(simulator.model(), |t| {
        let (state, u) = state_and_input(t, simulator);
        let (variant, _) = varied.input(t, simulator);
        output_jacobians(t, simulator, &columns_of_step(&variant, &state, &u));
    }))
}

fn output_jacobians(t: &mut Tracer, simulator: &Simulator, columns: &[Traced]) {
    let (n, nu) = (simulator.n_tangent(), simulator.nu());
    let (a, b) = columns.split_at(n * n);
    t.output(Port::matrix("A", n, n), a);
    t.output(Port::matrix("B", n, nu), b);
}

/// A value with its derivatives in some directions, to be recorded.
type Number = Dual<Traced, CHUNK>;

/// A and B, column by column, of the step on dual numbers. Inlined as what calls it, or the library would compile the step over these.
#[cfg_attr(not(feature = "graphs"), inline)]
fn columns_of_step(
    simulator: &Simulator<Traced>,
    state: &State<Traced>,
    u: &[Traced],
) -> Vec<Traced> {
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
        activation: lift(&state.activation),
        sleep: lift(&state.sleep),
    }
}
