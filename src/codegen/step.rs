//! The step as a graph, also of variants of a robot, and under feedback; compiled in programs that trace it, as `dynamics.rs` says.

use nalgebra::{DMatrix, DVector};

use super::origin::trace_of;
use super::ports::{Varied, output_step, state, state_and_input};
use crate::error::UnknownName;
use crate::scalar::traced::{Graph, Port};
use crate::sim::Simulator;

/// Traces [`Simulator::step_into`]: inputs `q`, `v`, `contact` (if there is a contact state), and `u`; outputs `q_next`, `v_next`, and `contact_next` likewise.
///
/// # Panics
/// If the step depends on values by branches; the message contains the location: see [what can be traced](crate::scalar::traced).
///
/// # Examples
/// ```
/// use dualbody::{Simulator, codegen, model::samples};
///
/// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
/// let graph = codegen::step(&simulator);
/// let next = graph.evaluate(&[std::f64::consts::FRAC_PI_2, 0.0, 0.0])?;
/// assert!((next[1] + 0.01 * 1.5 * 9.81).abs() < 1e-12); // v̇ = −3 g / 2 l, held for a step
/// # Ok::<(), dualbody::scalar::traced::BrokenCondition>(())
/// ```
#[cfg_attr(not(feature = "graphs"), inline)]
pub fn step(simulator: &Simulator) -> Graph {
    trace_of(simulator.model(), |t| {
        let (state, u) = state_and_input(t, simulator);
        output_step(t, simulator, &state, &u);
    })
}

/// Traces the step of variants of a robot: inputs and outputs as those of [`step`], with the input `parameters` at the end.
///
/// * `parameters` – names in [`Simulator::parameter_layout`]; all others are constants of the graph. Without any it is [`step`].
///
/// # Errors
/// If there is no parameter with this name.
///
/// # Panics
/// If the step decides on values: see [what can be traced](crate::scalar::traced).
#[cfg_attr(not(feature = "graphs"), inline)]
pub fn step_of_variants(simulator: &Simulator, parameters: &[&str]) -> Result<Graph, UnknownName> {
    if parameters.is_empty() {
        return Ok(step(simulator));
    }
    let varied = Varied::new(simulator, parameters)?;
    Ok(trace_of(simulator.model(), |t| {
        let (state, u) = state_and_input(t, simulator);
        let (variant, _) = varied.input(t, simulator);
        output_step(t, &variant, &state, &u);
    }))
}

/// Traces the step under linear feedback, u = u₀ − K (x ⊖ x₀): inputs `q`, `v`, `contact` (if there is a contact state), `parameters` (if some are
/// named), and `x0`, `u0`, `K`; outputs as those of [`step`].
///
/// * `x0` – the reference state
/// * `u0` – input at the reference, length `nu`
/// * `K` – gain, `nu` × `n_tangent`, on the deviation in tangent coordinates
///
/// # Errors
/// If there is no parameter with this name.
///
/// # Panics
/// If the step decides on values: see [what can be traced](crate::scalar::traced).
#[cfg_attr(not(feature = "graphs"), inline)]
pub fn feedback_step(simulator: &Simulator, parameters: &[&str]) -> Result<Graph, UnknownName> {
    let varied = Varied::new(simulator, parameters)?;
    let (nu, n) = (simulator.nu(), simulator.n_tangent());
    Ok(trace_of(simulator.model(), |t| {
        let state = state(t, simulator);
        let (variant, _) = varied.input(t, simulator);
        let mut reference = state.clone();
        reference.copy_from_slice(&t.input(Port::vector("x0", state.len())));
        let u0 = DVector::from_vec(t.input(Port::vector("u0", nu)));
        let gain = DMatrix::from_vec(nu, n, t.input(Port::matrix("K", nu, n)));
        let u = u0 - gain * state.deviation(simulator.model(), &reference);
        output_step(t, &variant, &state, u.as_slice());
    }))
}
