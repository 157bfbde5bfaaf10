//! The functions of a robot that kernels are made of, as graphs.
//!
//! They are those of [`dualbody::codegen`], compiled here once, with parameters of the robot as inputs where a batch is of many variants of it.
//! Any other graph becomes a kernel in the same way ([`CudaFunction`](crate::CudaFunction)).

use dualbody::scalar::Traced;
use dualbody::scalar::traced::{Graph, Origin, Port, Tracer, trace};
use dualbody::sim::StepScratch;
use dualbody::{Model, Simulator, State, UnknownName, codegen};
use nalgebra::{DMatrix, DVector};

/// Traces inverse dynamics: inputs `q`, `v`, `a`, output `tau`.
pub fn inverse_dynamics(model: &Model) -> Graph {
    codegen::inverse_dynamics(model)
}

/// Traces forward dynamics: inputs `q`, `v`, `tau`, output `a`.
///
/// # Panics
/// If the mass matrix is singular: [`Model::check_mass_matrix`] says so beforehand.
pub fn forward_dynamics(model: &Model) -> Graph {
    codegen::forward_dynamics(model)
}

/// Traces A and B of the step in tangent coordinates: inputs `q`, `v`, `contact` where there is a state of contact, `u`, outputs `A`, `B`.
///
/// # Panics
/// If the step decides on values: see [what can be traced](dualbody::scalar::traced).
pub fn linearization(simulator: &Simulator) -> Graph {
    codegen::linearization(simulator)
}

/// Traces A and B of the step of variants of a robot: inputs and outputs as those of [`linearization`], with the input `parameters` at the end.
///
/// The chain rule goes through all operations of the step, which takes more of them than the derivatives along the tree that [`linearization`] knows: with masses and dampings as parameters 21,682 instead
/// of 3,903 of a UR5, 47,162 instead of 8,345 of a Panda, 151,556 instead of 23,216 of a quadruped.
///
/// * `parameters` – names in [`Simulator::parameter_layout`]; all others are constants of the graph. Without any it is [`linearization`].
///
/// # Errors
/// If there is no parameter of a name.
///
/// # Panics
/// If the step decides on values: see [what can be traced](dualbody::scalar::traced).
pub fn linearization_of_variants(
    simulator: &Simulator,
    parameters: &[&str],
) -> Result<Graph, UnknownName> {
    let chosen = indices(simulator, parameters)?;
    if chosen.is_empty() {
        return Ok(linearization(simulator));
    }
    let slopes = change(simulator, &chosen).jacobian(&["change"], &["dx", "u"])?;
    let (n, nu) = (simulator.n_tangent(), simulator.nu());
    let graph = trace(|t| {
        let found = evaluated(&slopes, &at_step(t, simulator, &chosen));
        let (a, b) = found.split_at(n * n);
        t.output(Port::matrix("A", n, n), a);
        t.output(Port::matrix("B", n, nu), b);
    });
    Ok(graph.with_origin(origin(simulator.model())))
}

/// Traces the step: inputs `q`, `v`, `contact` where there is a state of contact, `u`, and `parameters` if some are named; outputs `q_next`,
/// `v_next`, and `contact_next` likewise.
///
/// * `parameters` – names in [`Simulator::parameter_layout`]; all others are constants of the graph
///
/// # Errors
/// If there is no parameter of a name.
///
/// # Panics
/// If the step decides on values: see [what can be traced](dualbody::scalar::traced).
pub fn step(simulator: &Simulator, parameters: &[&str]) -> Result<Graph, UnknownName> {
    let chosen = indices(simulator, parameters)?;
    let graph = trace(|t| {
        let (state, u) = (declare_state(t, simulator), declare_input(t, simulator));
        let varied = varied(t, simulator, &chosen);
        output_state(t, simulator, &next(&varied, &state, &u));
    });
    Ok(graph.with_origin(origin(simulator.model())))
}

/// Traces the step under linear feedback, u = u₀ − K (x ⊖ x₀): inputs `q`, `v`, `contact` where there is a state of contact, `parameters` if
/// some are named, and `x0`, `u0`, `K`; outputs as those of [`step`].
///
/// * `x0` – the reference state, the numbers of a state
/// * `u0` – input at the reference, length `nu`
/// * `K` – gain, `nu` × `n_tangent`, on the deviation in tangent coordinates
///
/// # Errors
/// If there is no parameter of a name.
///
/// # Panics
/// If the step decides on values: see [what can be traced](dualbody::scalar::traced).
pub fn feedback_step(simulator: &Simulator, parameters: &[&str]) -> Result<Graph, UnknownName> {
    let chosen = indices(simulator, parameters)?;
    let (nu, n) = (simulator.nu(), simulator.n_tangent());
    let graph = trace(|t| {
        let state = declare_state(t, simulator);
        let varied = varied(t, simulator, &chosen);
        let mut reference = state.clone();
        reference.copy_from_slice(&t.input(Port::vector("x0", state.len())));
        let u0 = DVector::from_vec(t.input(Port::vector("u0", nu)));
        let gain = DMatrix::from_vec(nu, n, t.input(Port::matrix("K", nu, n)));
        let u = u0 - gain * state.deviation(simulator.model(), &reference);
        output_state(t, simulator, &next(&varied, &state, u.as_slice()));
    });
    Ok(graph.with_origin(origin(simulator.model())))
}

/// Traces the gradient of λᵀ x⁺ of the step, in tangent coordinates: inputs as those of [`step`] and `lambda`, outputs `dx`, `du`, and `dp` if
/// parameters are named. It costs a few steps, whatever the number of parameters.
///
/// * `lambda` – λ, length `n_tangent`
///
/// # Errors
/// If there is no parameter of a name.
///
/// # Panics
/// If the step decides on values: see [what can be traced](dualbody::scalar::traced).
pub fn step_adjoint(simulator: &Simulator, parameters: &[&str]) -> Result<Graph, UnknownName> {
    let chosen = indices(simulator, parameters)?;
    let names: &[&str] = if chosen.is_empty() {
        &["dx", "u"]
    } else {
        &["dx", "u", "parameters"]
    };
    let adjoint = change(simulator, &chosen).adjoint(names)?;
    let (n, nu) = (simulator.n_tangent(), simulator.nu());
    let graph = trace(|t| {
        let mut inputs = at_step(t, simulator, &chosen);
        inputs.extend(t.input(Port::vector("lambda", n)));
        let found = evaluated(&adjoint, &inputs);
        t.output(Port::vector("dx", n), &found[..n]);
        t.output(Port::vector("du", nu), &found[n..n + nu]);
        if !chosen.is_empty() {
            t.output(Port::vector("dp", chosen.len()), &found[n + nu..]);
        }
    });
    Ok(graph.with_origin(origin(simulator.model())))
}

/// The change of the next state with the state, f(x ⊕ δx, u, p) ⊖ x⁺: inputs as those of [`step`], `dx` and `next`, output `change`.
fn change(simulator: &Simulator, chosen: &[usize]) -> Graph {
    let (model, n) = (simulator.model(), simulator.n_tangent());
    trace(|t| {
        let (mut state, u) = (declare_state(t, simulator), declare_input(t, simulator));
        let varied = varied(t, simulator, chosen);
        let dx = t.input(Port::vector("dx", n));
        let (dq, rest) = dx.split_at(model.nv());
        state.q = model.integrate(state.q.as_slice(), dq);
        for (x, &d) in state.v.iter_mut().chain(&mut state.contact).zip(rest) {
            *x += d;
        }
        let mut reached = state.clone();
        reached.copy_from_slice(&t.input(Port::vector("next", state.len())));
        let moved = next(&varied, &state, &u);
        t.output(Port::vector("change", n), &moved.deviation(model, &reached));
    })
}

/// The inputs of [`change`] at a step, without a change of the state: those of [`step`], which are declared, zeros, the next state.
fn at_step(t: &mut Tracer, simulator: &Simulator, chosen: &[usize]) -> Vec<Traced> {
    let (state, u) = (declare_state(t, simulator), declare_input(t, simulator));
    let mut inputs: Vec<Traced> = state.numbers().chain(&u).copied().collect();
    let varied = if chosen.is_empty() {
        simulator.cast()
    } else {
        let given = t.input(Port::vector("parameters", chosen.len()));
        inputs.extend(&given);
        with(simulator, chosen, &given)
    };
    let reached = next(&varied, &state, &u);
    inputs.extend(vec![Traced::from(0.0); simulator.n_tangent()]);
    inputs.extend(reached.numbers());
    inputs
}

/// The outputs of a graph, recorded.
fn evaluated(graph: &Graph, inputs: &[Traced]) -> Vec<Traced> {
    let mut found = vec![Traced::from(0.0); graph.n_outputs()];
    let held = graph.evaluate_into(inputs, &mut graph.scratch(), &mut found);
    // Numbers that are recorded take conditions over.
    held.unwrap_or_else(|broken| panic!("{broken}"));
    found
}

/// Places of parameters of some names.
fn indices(simulator: &Simulator, names: &[&str]) -> Result<Vec<usize>, UnknownName> {
    let layout = simulator.parameter_layout();
    names.iter().map(|name| layout.find(name)).collect()
}

/// The simulator with some parameters as an input, if there are any.
fn varied(t: &mut Tracer, simulator: &Simulator, chosen: &[usize]) -> Simulator<Traced> {
    if chosen.is_empty() {
        return simulator.cast();
    }
    let given = t.input(Port::vector("parameters", chosen.len()));
    with(simulator, chosen, &given)
}

fn with(simulator: &Simulator, chosen: &[usize], given: &[Traced]) -> Simulator<Traced> {
    let mut all: Vec<Traced> = simulator.parameters().iter().map(|&p| p.into()).collect();
    for (&k, &p) in chosen.iter().zip(given) {
        all[k] = p;
    }
    simulator.with_parameters(&all)
}

/// Declares a state.
fn declare_state(t: &mut Tracer, simulator: &Simulator) -> State<Traced> {
    let model = simulator.model();
    let q = t.input(Port::vector("q", model.nq()));
    let v = t.input(Port::vector("v", model.nv()));
    let mut state = simulator.state(&q, &v);
    if simulator.n_contact() > 0 {
        let contact = t.input(Port::vector("contact", simulator.n_contact()));
        state.contact = DVector::from_vec(contact);
    }
    state
}

/// Declares the input of the motors.
fn declare_input(t: &mut Tracer, simulator: &Simulator) -> Vec<Traced> {
    t.input(Port::vector("u", simulator.nu()))
}

fn next(simulator: &Simulator<Traced>, state: &State<Traced>, u: &[Traced]) -> State<Traced> {
    let mut out = state.clone();
    simulator.step_into(state, u, &mut StepScratch::new(simulator), &mut out);
    out
}

fn output_state(t: &mut Tracer, simulator: &Simulator, state: &State<Traced>) {
    let model = simulator.model();
    t.output(Port::vector("q_next", model.nq()), &state.q);
    t.output(Port::vector("v_next", model.nv()), &state.v);
    if simulator.n_contact() > 0 {
        let port = Port::vector("contact_next", simulator.n_contact());
        t.output(port, &state.contact);
    }
}

fn origin(model: &Model) -> Origin {
    Origin {
        name: model.name().to_owned(),
        fingerprint: model.fingerprint(),
    }
}
