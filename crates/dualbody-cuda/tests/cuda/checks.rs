//! Expected results of kernels, on any machine that runs them.

use std::iter::repeat_with;

use dualbody::codegen::RolloutInputs;
use dualbody::model::samples;
use dualbody::sim::RolloutStatus;
use dualbody::{Integrator, Model, Simulator, State, dynamics};
use dualbody_cuda::{Real, Schedule, graphs};
use nalgebra::{DMatrix, DVector};

use crate::common::{asset, generator, random_point, random_tangent};
use crate::machine::{Left, Machine, Run};

/// Sums in another order, over the steps of a motion.
const MOTION: f64 = 1e-9;
/// Sums in another order, sines of another library.
const ROUNDING: f64 = 1e-11;
/// Seven digits, over a formula.
const SINGLE: f64 = 2e-3;

/// States of each batch: no multiple of the threads of a block.
const COUNT: usize = 5;

const ASSETS: [&str; 12] = [
    "acrobot",
    "box",
    "cartpole",
    "double_pendulum",
    "four_bar",
    "hopper",
    "humanoid",
    "panda",
    "quadrotor",
    "quadruped",
    "sphere",
    "ur5",
];

pub(crate) fn assets() -> Vec<Model> {
    ASSETS
        .iter()
        .map(|name| asset(&format!("{name}.urdf")))
        .collect()
}

fn close(found: f64, expected: f64, size: f64, tolerance: f64, what: &str) {
    let off = (found - expected).abs() / size.max(1.0);
    assert!(
        off <= tolerance,
        "{what}: {found}, not {expected} ({off:e})"
    );
}

/// Compares numbers, relative to the largest of them.
fn close_all<R: Real>(found: &[R], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let size = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (k, (x, e)) in found.iter().zip(expected).enumerate() {
        close(x.to_f64(), *e, size, tolerance, &format!("{what}, {k}"));
    }
}

fn real<R: Real>(numbers: impl IntoIterator<Item = f64>) -> Vec<R> {
    numbers.into_iter().map(R::from_f64).collect()
}

/// Joint forces of inverse dynamics, in `R`.
pub(crate) fn inverse_dynamics<R: Real>(machine: &impl Machine, models: &[Model], tolerance: f64) {
    for model in models {
        let points: Vec<_> = (0..COUNT as u64)
            .map(|seed| random_point(model, seed))
            .collect();
        let inputs = points
            .iter()
            .flat_map(|p| p.q.iter().chain(&p.v).chain(&p.w).copied());
        let given: Vec<R> = real(inputs);
        let found = machine.batch(&graphs::inverse_dynamics(model), &[], COUNT, [&given, &[]]);
        let of = |p: &crate::common::Point| {
            dynamics::inverse_dynamics(model, p.q.as_slice(), p.v.as_slice(), p.w.as_slice())
        };
        let expected: Vec<f64> = points
            .iter()
            .flat_map(|p| of(p).iter().copied().collect::<Vec<_>>())
            .collect();
        assert_eq!(found.status, [0; COUNT], "{}", model.name());
        close_all(&found.numbers, &expected, tolerance, model.name());
    }
}

/// Accelerations of forward dynamics.
pub(crate) fn forward_dynamics(machine: &impl Machine, models: &[Model]) {
    for model in models {
        let points: Vec<_> = (0..COUNT as u64)
            .map(|seed| random_point(model, seed))
            .collect();
        let given: Vec<f64> = points
            .iter()
            .flat_map(|p| p.q.iter().chain(&p.v).chain(&p.w).copied())
            .collect();
        let found = machine.batch(&graphs::forward_dynamics(model), &[], COUNT, [&given, &[]]);
        for (p, a) in points.iter().zip(found.numbers.chunks(model.nv())) {
            let expected =
                dynamics::forward_dynamics(model, p.q.as_slice(), p.v.as_slice(), p.w.as_slice());
            close_all(a, expected.as_slice(), ROUNDING * 100.0, model.name());
        }
    }
}

fn starts(model: &Model) -> Vec<State> {
    let start = |seed| {
        let point = random_point(model, seed);
        State::new(point.q.as_slice(), point.v.as_slice())
    };
    (0..COUNT as u64).map(start).collect()
}

fn inputs(simulator: &Simulator, steps: usize) -> Vec<f64> {
    let mut rng = generator(7);
    let n = simulator.nu().div_ceil(simulator.model().nv().max(1));
    let tangents = repeat_with(|| {
        random_tangent(simulator.model(), &mut rng)
            .as_slice()
            .repeat(n.max(1))
    });
    let one = tangents
        .take(COUNT * steps)
        .map(|all| all[..simulator.nu()].to_vec());
    one.flatten().collect()
}

fn schedule(simulator: &Simulator, steps: usize, every: usize) -> Schedule {
    Schedule {
        steps,
        every,
        fastest: simulator.divergence_bound(),
    }
}

fn run<R: Real>(schedule: Schedule, starts: &[State], each_step: &[f64]) -> Run<R> {
    let numbers = starts.iter().flat_map(|state| state.numbers().copied());
    Run {
        schedule,
        count: starts.len(),
        state: real(numbers),
        constants: Vec::new(),
        each_step: real(each_step.iter().copied()),
        shared: Vec::new(),
        status: vec![0; starts.len()],
        taken: vec![0; starts.len()],
    }
}

/// Motions under inputs that are given, with every third state kept, in `R`.
pub(crate) fn rollouts<R: Real>(machine: &impl Machine, simulators: &[Simulator], tolerance: f64) {
    const STEPS: usize = 8;
    const EVERY: usize = 3;
    for simulator in simulators {
        let (name, nu) = (simulator.model().name(), simulator.nu());
        let (starts, u) = (starts(simulator.model()), inputs(simulator, STEPS));
        let graph = graphs::step(simulator, &[]).expect("no parameters");
        let run = run::<R>(schedule(simulator, STEPS, EVERY), &starts, &u);
        let Left { run, kept } = machine.rollout(&graph, &RolloutInputs::default(), run);
        assert_eq!(
            (run.status, run.taken),
            (vec![0; COUNT], vec![STEPS as u32; COUNT]),
            "{name}"
        );
        let n = starts[0].len();
        for (i, start) in starts.iter().enumerate() {
            let mut step = 0;
            let own = simulator.rollout(start, STEPS, |_, _, input| {
                let first = (i * STEPS + step) * nu;
                input.copy_from_slice(&u[first..first + nu]);
                step += 1;
            });
            let numbers = |k: usize| own.states[k].numbers().copied().collect::<Vec<_>>();
            close_all(
                &run.state[i * n..(i + 1) * n],
                &numbers(STEPS),
                tolerance,
                name,
            );
            for (k, row) in kept[i * 2 * n..(i + 1) * 2 * n].chunks(n).enumerate() {
                close_all(row, &numbers(EVERY * (k + 1)), tolerance, name);
            }
        }
    }
}

/// The simulators of the check of rollouts.
pub(crate) fn simulators(models: Vec<Model>) -> Vec<Simulator> {
    let new = |model| Simulator::new(model).with_time_step(1e-3);
    models.into_iter().map(new).collect()
}

/// Steps of all integrators.
pub(crate) fn integrators() -> Vec<Simulator> {
    let new = |i| {
        Simulator::new(samples::cartpole())
            .with_time_step(1e-3)
            .with_integrator(i)
    };
    [Integrator::ImplicitVelocity, Integrator::RungeKutta4]
        .map(new)
        .to_vec()
}

/// The input of a state.
fn input_of<'a>(simulator: &Simulator, u: &'a [f64], i: usize) -> &'a [f64] {
    &u[simulator.nu() * i..simulator.nu() * (i + 1)]
}

/// A and B.
pub(crate) fn jacobians(machine: &impl Machine, simulators: &[Simulator]) {
    for simulator in simulators {
        let (starts, u) = (starts(simulator.model()), inputs(simulator, 1));
        let mut given: Vec<f64> = Vec::new();
        for (i, x) in starts.iter().enumerate() {
            given.extend(x.numbers().chain(input_of(simulator, &u, i)));
        }
        let graph = graphs::linearization(simulator);
        let found = machine.batch(&graph, &[], COUNT, [&given, &[]]);
        assert_eq!(found.status, [0; COUNT]);
        for (i, found) in found.numbers.chunks(graph.n_outputs()).enumerate() {
            let own = simulator.linearize(&starts[i], input_of(simulator, &u, i));
            let expected: Vec<f64> = own.a.iter().chain(&own.b).copied().collect();
            close_all(found, &expected, ROUNDING * 100.0, simulator.model().name());
        }
    }
}

/// Indices of parameters.
fn places_of(simulator: &Simulator, names: &[&str]) -> Vec<usize> {
    let layout = simulator.parameter_layout();
    let find = |name: &&str| layout.find(name).expect("a parameter");
    names.iter().map(find).collect()
}

/// Gradients in state, input and some parameters.
pub(crate) fn gradients(machine: &impl Machine, simulator: &Simulator, names: &[&str]) {
    let (starts, u) = (starts(simulator.model()), inputs(simulator, 1));
    let places = places_of(simulator, names);
    let (all, n) = (simulator.parameters(), simulator.n_tangent());
    let values: Vec<f64> = places.iter().map(|&k| all[k]).collect();
    let lambda = |i: usize| DVector::from_fn(n, |k, _| (1.0 + (3 * i + k) as f64).sin());
    let mut given: Vec<f64> = Vec::new();
    for (i, x) in starts.iter().enumerate() {
        let u = input_of(simulator, &u, i);
        given.extend(x.numbers().chain(u).chain(&values).chain(&lambda(i)));
    }
    let graph = graphs::step_adjoint(simulator, names).expect("parameters");
    let found = machine.batch(&graph, &[], COUNT, [&given, &[]]);
    assert_eq!(found.status, [0; COUNT]);
    for (i, row) in found.numbers.chunks(graph.n_outputs()).enumerate() {
        let u = input_of(simulator, &u, i);
        let own = simulator.vjp(&starts[i], u, lambda(i).as_slice());
        let chosen = places.iter().map(|&k| own.parameters[k]);
        let expected: Vec<f64> = own
            .state
            .iter()
            .chain(&own.input)
            .copied()
            .chain(chosen)
            .collect();
        close_all(row, &expected, ROUNDING * 100.0, simulator.model().name());
    }
}

/// A and B of variants that differ in some parameters.
pub(crate) fn jacobians_of_variants(machine: &impl Machine, simulator: &Simulator, names: &[&str]) {
    /// Relative distance of the parameters of two variants.
    const DISTANCE: f64 = 0.1;
    let (starts, u) = (starts(simulator.model()), inputs(simulator, 1));
    let places = places_of(simulator, names);
    let of = |i: usize| {
        let mut all = simulator.parameters();
        places
            .iter()
            .for_each(|&k| all[k] = all[k] * (1.0 + DISTANCE * i as f64) + DISTANCE * DISTANCE);
        all
    };
    let mut given: Vec<f64> = Vec::new();
    for (i, x) in starts.iter().enumerate() {
        given.extend(x.numbers().chain(input_of(simulator, &u, i)));
        given.extend(places.iter().map(|&k| of(i)[k]));
    }
    let graph = graphs::linearization_of_variants(simulator, names).expect("parameters");
    let found = machine.batch(&graph, &[], COUNT, [&given, &[]]);
    assert_eq!(found.status, [0; COUNT]);
    let rows: Vec<_> = found.numbers.chunks(graph.n_outputs()).collect();
    for (i, row) in rows.iter().enumerate() {
        let variant = simulator.with_parameters(of(i).as_slice());
        let own = variant.linearize(&starts[i], input_of(simulator, &u, i));
        let expected: Vec<f64> = own.a.iter().chain(&own.b).copied().collect();
        close_all(row, &expected, ROUNDING * 100.0, simulator.model().name());
    }
}

/// Motions of variants that differ in some parameters.
pub(crate) fn variants(machine: &impl Machine) {
    let simulator = Simulator::new(samples::cartpole()).with_time_step(1e-3);
    let layout = simulator.parameter_layout();
    let names: Vec<&str> = layout.names().iter().map(String::as_str).collect();
    let names: Vec<&str> = names
        .into_iter()
        .filter(|name| name.contains("mass") || name.contains("damping"))
        .collect();
    assert!(names.len() >= 3, "{:?}", layout.names());
    let graph = graphs::step(&simulator, &names).expect("parameters");
    let of = |i: usize| {
        let mut all = simulator.parameters();
        for (j, name) in names.iter().enumerate() {
            all[layout.find(name).expect("a parameter")] += 0.1 * (1 + i + j) as f64;
        }
        all
    };
    let (starts, u) = (starts(simulator.model()), inputs(&simulator, 10));
    let mut run = run::<f64>(schedule(&simulator, 10, 0), &starts, &u);
    for i in 0..COUNT {
        let all = of(i);
        run.constants.extend(
            names
                .iter()
                .map(|name| all[layout.find(name).expect("a parameter")]),
        );
    }
    let Left { run, .. } = machine.rollout(&graph, &RolloutInputs::default(), run);
    let (n, nu) = (starts[0].len(), simulator.nu());
    for (i, start) in starts.iter().enumerate() {
        let mut step = 0;
        let own = simulator
            .with_parameters(of(i).as_slice())
            .rollout(start, 10, |_, _, input| {
                input.copy_from_slice(&u[(i * 10 + step) * nu..(i * 10 + step + 1) * nu]);
                step += 1;
            });
        let expected: Vec<f64> = own.last().numbers().copied().collect();
        close_all(
            &run.state[i * n..(i + 1) * n],
            &expected,
            MOTION,
            "a variant",
        );
    }
}

/// Motions under feedback on the deviation from a reference, with a base that turns freely.
pub(crate) fn feedback(machine: &impl Machine) {
    let simulator = Simulator::new(samples::random_tree(3, 2)).with_time_step(1e-3);
    let (nu, n) = (simulator.nu(), simulator.n_tangent());
    let starts = starts(simulator.model());
    let reference = &starts[COUNT - 1];
    let gain = DMatrix::from_fn(nu, n, |i, j| (1.0 + i as f64 + 2.0 * j as f64).sin());
    let u0 = DVector::from_fn(nu, |i, _| 0.1 * i as f64);
    let graph = graphs::feedback_step(&simulator, &[]).expect("no parameters");
    let roles = RolloutInputs::of_feedback();
    let mut run = run::<f64>(schedule(&simulator, 20, 0), &starts, &[]);
    run.shared = reference
        .numbers()
        .chain(&u0)
        .chain(&gain)
        .copied()
        .collect();
    let Left { run, .. } = machine.rollout(&graph, &roles, run);
    for (i, start) in starts.iter().enumerate() {
        let own = simulator.rollout(start, 20, |_, x, u| {
            let found = &u0 - &gain * x.deviation(simulator.model(), reference);
            u.copy_from_slice(found.as_slice());
        });
        let expected: Vec<f64> = own.last().numbers().copied().collect();
        let width = start.len();
        close_all(
            &run.state[i * width..(i + 1) * width],
            &expected,
            MOTION,
            "under feedback",
        );
    }
}

/// Motions that end: at an input, by divergence, at a condition. The others go on, and a stopped state does not change.
pub(crate) fn endings(machine: &impl Machine) {
    let simulator = Simulator::new(samples::pendulum())
        .with_time_step(0.01)
        .with_divergence_bound(60.0);
    let graph = graphs::step(&simulator, &[]).expect("no parameters");
    let mut starts = vec![State::new(&[0.1], &[0.0]); COUNT];
    starts[4].v[0] = 150.0;
    let mut u = [[0.0; 6]; COUNT];
    u[1][3] = f64::NAN;
    u[2][2] = 5000.0;
    u[3][4] = f64::INFINITY;
    let run = run::<f64>(schedule(&simulator, 6, 1), &starts, u.as_flattened());
    let Left { run, kept } = machine.rollout(&graph, &RolloutInputs::default(), run);
    let whirl = graph
        .evaluate(&[0.1, 150.0, 0.0])
        .expect_err("a condition that does not hold");
    let number = i32::try_from(whirl.index + 1).expect("few conditions");
    assert_eq!(run.status, [0, -2, -1, -2, number]);
    assert_eq!(run.taken, [6, 3, 2, 4, 0]);
    for (i, start) in starts.iter().enumerate().take(4) {
        let mut step = 0;
        let own = simulator.rollout(start, 6, |_, _, input| {
            input[0] = u[i][step];
            step += 1;
        });
        let expected = match run.status[i] {
            0 => RolloutStatus::Completed,
            -1 => RolloutStatus::Diverged {
                step: run.taken[i] as usize,
            },
            _ => RolloutStatus::NonFiniteInput {
                step: run.taken[i] as usize,
            },
        };
        assert_eq!(
            (own.status, own.states.len()),
            (expected, 1 + run.taken[i] as usize)
        );
        let last: Vec<f64> = own.last().numbers().copied().collect();
        close_all(
            &run.state[2 * i..2 * i + 2],
            &last,
            ROUNDING,
            "the last state",
        );
        for (k, row) in kept[12 * i..12 * i + 2 * (own.states.len() - 1)]
            .chunks(2)
            .enumerate()
        {
            let own: Vec<f64> = own.states[k + 1].numbers().copied().collect();
            close_all(row, &own, ROUNDING, "a state that was kept");
        }
    }
    assert_eq!(run.state[8..], [0.1, 150.0]);
}

/// Outputs that are not finite, and conditions that do not hold, in a function.
pub(crate) fn statuses(machine: &impl Machine) {
    let simulator = Simulator::new(samples::pendulum());
    let graph = graphs::step(&simulator, &[]).expect("no parameters");
    let given = [
        0.1,
        1.0,
        0.0,
        0.1,
        500.0,
        0.0,
        0.1,
        f64::NAN,
        0.0,
        0.1,
        0.0,
        f64::INFINITY,
        0.0,
        0.0,
        0.0,
    ];
    let whirl = graph
        .evaluate(&given[3..6])
        .expect_err("a condition that does not hold");
    let number = i32::try_from(whirl.index + 1).expect("few conditions");
    let found = machine.batch(&graph, &[], COUNT, [&given, &[]]);
    assert_eq!(found.status, [0, number, -1, -1, 0]);
}

/// All checks in double precision; only the first two run on many robots.
pub(crate) fn all(machine: &impl Machine) {
    inverse_dynamics::<f64>(machine, &assets(), ROUNDING);
    rollouts::<f64>(machine, &simulators(assets()), MOTION);
    rollouts::<f64>(machine, &integrators(), MOTION);
    others(machine);
}

/// The checks of all other kernels.
pub(crate) fn others(machine: &impl Machine) {
    let few = ["cartpole.urdf", "ur5.urdf", "quadrotor.urdf"].map(asset);
    inverse_dynamics::<f32>(machine, &few, SINGLE);
    rollouts::<f32>(machine, &simulators(few.to_vec()), SINGLE);
    forward_dynamics(machine, &few);
    jacobians(machine, &simulators(few.to_vec()));
    let cartpole = Simulator::new(samples::cartpole()).with_time_step(1e-3);
    let layout = cartpole.parameter_layout();
    let names: Vec<&str> = layout.names().iter().map(String::as_str).collect();
    gradients(machine, &cartpole, &names);
    gradients(
        machine,
        &Simulator::new(samples::random_tree(4, 1)).with_time_step(1e-3),
        &[],
    );
    jacobians_of_variants(machine, &cartpole, &names);
    let ur5 = Simulator::new(asset("ur5.urdf")).with_time_step(1e-3);
    let layout = ur5.parameter_layout();
    let changed = |name: &&str| name.contains("mass") || name.contains("damping");
    let names: Vec<&str> = layout
        .names()
        .iter()
        .map(String::as_str)
        .filter(changed)
        .collect();
    assert!(names.len() >= 6, "{names:?}");
    jacobians_of_variants(machine, &ur5, &names);
    variants(machine);
    feedback(machine);
    endings(machine);
    statuses(machine);
}
