//! Random states of a function, and the library's results.

use dualbody::scalar::traced::Graph;
use dualbody::{Simulator, State, dynamics};
use nalgebra::{DMatrix, DVector};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use crate::cases::Cases;
use crate::catalogue::{Ground, Robot};
use crate::functions::{Function, Kind};

/// Steps of a motion that is compared.
const STEPS: usize = 8;
/// Numbers of expected outputs of a function, about.
const NUMBERS: usize = 120_000;
/// The most and the fewest states of a function, which are not multiples of the 32 threads of a warp.
const STATES: (usize, usize) = (9, 61);
/// States of these that leave a condition.
const FAST: usize = 2;
/// Factor of the speeds of these.
const FACTOR: f64 = 400.0;
/// Size of the entries of a gain, under which no light link rotates fast.
const GAIN: f64 = 1.0 / 128.0;

/// The nearest number of single precision, so that kernels of both precisions read the same inputs.
fn rounded(x: f64) -> f64 {
    f64::from(x as f32)
}

/// Random states of a function, and the library's results.
pub(crate) fn expect(robot: &Robot, function: &Function) -> Cases {
    let count = NUMBERS / function.graph.n_outputs().max(1);
    let count = count.clamp(STATES.0, STATES.1) | 1;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(u64::from(function.kind as u8));
    let mut out = Cases {
        count,
        ordinary: count - FAST,
        steps: if function.kind.is_step() { STEPS } else { 0 },
        ..Cases::default()
    };
    let feedback = feedback(robot, &mut rng);
    if function.kind == Kind::Feedback {
        out.shared.clone_from(&feedback.numbers);
    }
    for k in 0..count {
        let speed = if k < count - FAST { 1.0 } else { FACTOR };
        let state = random_state(robot, speed, &mut rng);
        if function.kind.is_step() {
            motion(robot, function, &feedback, state, &mut rng, &mut out);
        } else {
            value(robot, function, &state, &mut rng, &mut out);
        }
    }
    out
}

/// A random state; on the ground with its feet about at its surface.
fn random_state(robot: &Robot, speed: f64, rng: &mut Xoshiro256PlusPlus) -> State {
    let (simulator, model) = (&robot.simulator, robot.simulator.model());
    let mut state = simulator.neutral_state::<f64>();
    state.v.apply(|x| *x = speed * rng.random_range(-1.0..1.0));
    if robot.ground == Ground::Absent {
        state.q = model.random_configuration(rng);
    } else {
        let off = DVector::from_fn(model.nv(), |_, _| rng.random_range(-0.05..0.05));
        state.q = model.integrate(state.q.as_slice(), off.as_slice());
        let depth = rng.random_range(-2e-3..2e-3);
        state.q[2] += deepest(simulator, &state) - depth;
        state.contact.apply(|x| *x = rng.random_range(-1e-4..1e-4));
        state.v *= 0.2;
    }
    state.numbers_mut().for_each(|x| *x = rounded(*x));
    state
}

/// How deep the lowest point of a robot is below the surface, m.
fn deepest(simulator: &Simulator, state: &State) -> f64 {
    let Some(contacts) = simulator.contacts() else {
        return 0.0;
    };
    let (q, v) = (state.q.as_slice(), state.v.as_slice());
    let points = contacts.states(simulator.model(), q, v);
    points.iter().map(|s| s.depth).fold(f64::MIN, f64::max)
}

fn random(n: usize, rng: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    let number = |_| rounded(rng.random_range(-1.0..1.0));
    (0..n).map(number).collect()
}

/// Linear feedback on the deviation from a reference.
struct Feedback {
    reference: State,
    input: DVector<f64>,
    gain: DMatrix<f64>,
    numbers: Vec<f64>,
}

fn feedback(robot: &Robot, rng: &mut Xoshiro256PlusPlus) -> Feedback {
    let (nu, n) = (robot.simulator.nu(), robot.simulator.n_tangent());
    let reference = random_state(robot, 1.0, rng);
    let input = DVector::from_vec(random(nu, rng)).scale(GAIN);
    let gain = DMatrix::from_vec(nu, n, random(nu * n, rng)).scale(GAIN);
    let numbers = reference.numbers().chain(&input).chain(&gain);
    Feedback {
        numbers: numbers.copied().collect(),
        reference,
        input,
        gain,
    }
}

/// The simulator with other parameters, and these.
fn variant(
    robot: &Robot,
    function: &Function,
    rng: &mut Xoshiro256PlusPlus,
) -> (Simulator, Vec<f64>) {
    let (layout, mut all) = (
        robot.simulator.parameter_layout(),
        robot.simulator.parameters(),
    );
    let mut own = Vec::new();
    for name in &function.parameters {
        if let Ok(k) = layout.find(name) {
            all[k] = rounded(all[k] * rng.random_range(0.8..1.2) + 0.01);
            own.push(all[k]);
        }
    }
    let simulator = match own.is_empty() {
        true => robot.simulator.clone(),
        false => robot.simulator.with_parameters(all.as_slice()),
    };
    (simulator, own)
}

/// Number of the first condition that does not hold, from 1, or 0.
fn condition(graph: &Graph, inputs: &[f64]) -> f64 {
    graph
        .evaluate(inputs)
        .err()
        .map_or(0.0, |broken| (broken.index + 1) as f64)
}

/// A motion of some steps from a state.
fn motion(
    robot: &Robot,
    function: &Function,
    feedback: &Feedback,
    mut state: State,
    rng: &mut Xoshiro256PlusPlus,
    out: &mut Cases,
) {
    let (simulator, parameters) = variant(robot, function, rng);
    let (nu, mut status, mut taken) = (simulator.nu(), 0.0, 0);
    out.start.extend(state.numbers());
    out.inputs.extend(&parameters);
    for _ in 0..STEPS {
        let (u, rest) = if function.kind == Kind::Feedback {
            let off = state.deviation(simulator.model(), &feedback.reference);
            (
                &feedback.input - &feedback.gain * off,
                feedback.numbers.clone(),
            )
        } else {
            let u = random(nu, rng);
            out.each_step.extend(&u);
            (
                DVector::from_vec(u.clone()),
                [u, parameters.clone()].concat(),
            )
        };
        if status != 0.0 {
            continue;
        }
        let inputs: Vec<f64> = state.numbers().chain(&rest).copied().collect();
        status = condition(&function.graph, &inputs);
        if status == 0.0 {
            state = simulator.step(&state, u.as_slice());
            taken += 1;
        }
    }
    out.expected.extend(state.numbers());
    out.status.push(status);
    out.taken.push(f64::from(taken));
}

/// A value of a function at a state.
fn value(
    robot: &Robot,
    function: &Function,
    state: &State,
    rng: &mut Xoshiro256PlusPlus,
    out: &mut Cases,
) {
    let (simulator, parameters) = variant(robot, function, rng);
    let (q, v) = (state.q.as_slice(), state.v.as_slice());
    let (model, nu) = (simulator.model(), simulator.nu());
    let rest = match function.kind {
        Kind::InverseDynamics | Kind::ForwardDynamics => random(model.nv(), rng),
        Kind::Gradients => random(nu + simulator.n_tangent(), rng),
        _ => [random(nu, rng), parameters].concat(),
    };
    let expected: Vec<f64> = match function.kind {
        Kind::InverseDynamics => dynamics::inverse_dynamics(model, q, v, &rest)
            .as_slice()
            .into(),
        Kind::ForwardDynamics => dynamics::forward_dynamics(model, q, v, &rest)
            .as_slice()
            .into(),
        Kind::Gradients => {
            let own = simulator.vjp(state, &rest[..nu], &rest[nu..]);
            own.state.iter().chain(&own.input).copied().collect()
        }
        _ => {
            let own = simulator.linearize(state, &rest[..nu]);
            own.a.iter().chain(&own.b).copied().collect()
        }
    };
    let inputs: Vec<f64> = state.numbers().chain(&rest).copied().collect();
    out.status.push(condition(&function.graph, &inputs));
    out.inputs.extend(inputs);
    out.expected.extend(expected);
}
