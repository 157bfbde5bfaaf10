//! The gradient of the step as a graph; compiled in programs that trace it, as `dynamics.rs` says.

use super::origin::trace_of;
use super::ports::{Varied, next, state_and_input};
use crate::error::UnknownName;
use crate::scalar::Traced;
use crate::scalar::traced::{Graph, Port, trace};
use crate::sim::{Simulator, State};

/// Traces the gradient of λᵀ x⁺ of the step, in tangent coordinates: inputs as those of [`step_of_variants`](super::step_of_variants) and `lambda`,
/// outputs `dx`, `du`, and `dp` if parameters are named. It costs a few steps, independent of the number of parameters.
///
/// * `lambda` – λ, length `n_tangent`
///
/// # Errors
/// If there is no parameter with this name.
///
/// # Panics
/// If the step depends on values by branches: see [what can be traced](crate::scalar::traced).
#[cfg_attr(not(feature = "graphs"), inline)]
pub fn step_adjoint(simulator: &Simulator, parameters: &[&str]) -> Result<Graph, UnknownName> {
    let varied = Varied::new(simulator, parameters)?;
    let names = ["dx", "u", "parameters"];
    let named = if varied.len() == 0 { 2 } else { 3 };
    let adjoint = change(simulator, &varied).adjoint(&names[..named])?;
    let (n, nu) = (simulator.n_tangent(), simulator.nu());
    Ok(trace_of(simulator.model(), |t| {
        let (state, u) = state_and_input(t, simulator);
        let (variant, values) = varied.input(t, simulator);
        let reached = next(&variant, &state, &u);
        let mut inputs: Vec<Traced> = state.numbers().chain(&u).chain(&values).copied().collect();
        inputs.extend(vec![Traced::from(0.0); n]);
        inputs.extend(reached.numbers());
        inputs.extend(t.input(Port::vector("lambda", n)));
        let found = evaluated(&adjoint, &inputs);
        t.output(Port::vector("dx", n), &found[..n]);
        t.output(Port::vector("du", nu), &found[n..n + nu]);
        if varied.len() > 0 {
            t.output(Port::vector("dp", varied.len()), &found[n + nu..]);
        }
    }))
}

/// The change of the next state with the state, f(x ⊕ δx, u, p) ⊖ x⁺: inputs as those of the step, `dx` and `next`, output `change`.
#[cfg_attr(not(feature = "graphs"), inline)]
fn change(simulator: &Simulator, varied: &Varied) -> Graph {
    let (model, n) = (simulator.model(), simulator.n_tangent());
    trace(|t| {
        let (mut state, u) = state_and_input(t, simulator);
        let (variant, _) = varied.input(t, simulator);
        let dx = t.input(Port::vector("dx", n));
        let (dq, rest) = dx.split_at(model.nv());
        state.q = model.integrate(state.q.as_slice(), dq);
        for (x, &d) in state.v.iter_mut().chain(&mut state.contact).zip(rest) {
            *x += d;
        }
        let mut reached: State<Traced> = state.clone();
        reached.copy_from_slice(&t.input(Port::vector("next", state.len())));
        let moved = next(&variant, &state, &u);
        t.output(Port::vector("change", n), &moved.deviation(model, &reached));
    })
}

/// The outputs of a graph, recorded.
fn evaluated(graph: &Graph, inputs: &[Traced]) -> Vec<Traced> {
    let mut found = vec![Traced::from(0.0); graph.n_outputs()];
    let held = graph.evaluate_into(inputs, &mut graph.scratch(), &mut found);
    // Numbers that are recorded take conditions over.
    held.unwrap_or_else(|broken| panic!("{broken}"));
    found
}
