//! The step as a graph; compiled in programs that trace it, as `dynamics.rs` says.

use super::origin::origin;
use super::ports::{CONTACT, POSITION, VELOCITY, state_and_input};
use crate::scalar::traced::{Graph, Port, trace};
use crate::sim::{Simulator, StepScratch};

/// Traces [`Simulator::step_into`]: inputs `q`, `v`, `contact` where there is a state of contact, and `u`; outputs
/// `q_next`, `v_next`, and `contact_next` likewise.
///
/// # Panics
/// If the step decides on values, with the place: see [what can be traced](crate::scalar::traced).
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
    let model = simulator.model();
    let graph = trace(|t| {
        let (state, u) = state_and_input(t, simulator);
        let mut next = state.clone();
        simulator.step_into(&state, &u, &mut StepScratch::new(simulator), &mut next);
        t.output(
            Port::vector("q_next", model.nq()).with_unit(POSITION),
            &next.q,
        );
        t.output(
            Port::vector("v_next", model.nv()).with_unit(VELOCITY),
            &next.v,
        );
        if simulator.n_contact() > 0 {
            let port = Port::vector("contact_next", simulator.n_contact());
            t.output(port.with_unit(CONTACT), &next.contact);
        }
    });
    graph.with_origin(origin(model))
}
