//! A batch gives the bits that a simulator of its own gives for each state.

use dualbody::joint::JointKind;
use dualbody::linearize::{Linearization, LinearizeScratch};
use dualbody::model::samples;
use dualbody::sim::{BATCH_WIDTH, BatchRollout, BatchSimulator, RolloutStatus};
use dualbody::{Integrator, Lanes, Model, Simulator, State};
use nalgebra::Vector3;
use rand::RngExt;

use crate::common::{floating_robot, generator, robots};

/// Not a multiple of any width, so that the last group is filled up.
const STATES: usize = 2 * BATCH_WIDTH + 3;
const STEPS: usize = 20;

fn random_states(model: &Model, n: usize, seed: u64) -> Vec<State> {
    let mut rng = generator(seed);
    (0..n)
        .map(|_| State::random(model, &mut rng, 1.0))
        .collect()
}

fn random_inputs(n: usize, seed: u64) -> Vec<f64> {
    let mut rng = generator(seed);
    (0..n).map(|_| rng.random_range(-1.0..1.0)).collect()
}

fn assert_same_bits(actual: &State, expected: &State, what: &str) {
    let bits = |s: &State| -> Vec<u64> { s.q.iter().chain(&s.v).map(|x| x.to_bits()).collect() };
    assert_eq!(
        bits(actual),
        bits(expected),
        "{what}: {actual:?} against {expected:?}"
    );
}

fn simulators() -> Vec<Simulator> {
    let both = |model: Model| {
        let simulator = Simulator::new(model).with_time_step(0.01);
        let other = simulator.clone().with_integrator(Integrator::RungeKutta4);
        [simulator, other]
    };
    robots().into_iter().flat_map(both).collect()
}

/// Robot with other numbers everywhere.
fn variants(model: &Model, n: usize) -> Vec<Model> {
    let vary = |k: usize| {
        let scale = 1.0 + 0.1 * k as f64;
        let gravity = Vector3::new(0.1 * k as f64, 0.0, -9.81);
        let mut out = model.clone().with_gravity(gravity);
        for (i, body) in model.bodies().iter().enumerate() {
            out = out.with_inertia(dualbody::model::BodyId(i), body.inertia.scaled(scale));
        }
        for v in 0..model.nv() {
            out = out
                .with_damping(v, 0.05 * scale)
                .with_armature(v, 0.02 * scale);
        }
        for joint in model.joints() {
            if joint.kind == JointKind::Universal {
                continue; // its second body is not placed
            }
            let mut placement = model.body(joint.body).placement;
            placement.translation *= scale;
            out = out.with_placement(joint.body, placement);
        }
        let layout = out.parameter_layout();
        let is_ratio = |k: &usize| layout.names()[*k].ends_with(": ratio");
        let ratios: Vec<usize> = (0..layout.names().len()).filter(is_ratio).collect();
        let own = out.parameters();
        let values: Vec<f64> = ratios.iter().map(|&k| own[k] * scale).collect();
        out.with_some_parameters(&ratios, &values)
    };
    (0..n).map(vary).collect()
}

fn assert_equals_singles(batch: &mut BatchSimulator, what: &str) {
    let (n, nu) = (batch.len(), batch.simulator(0).nu());
    let starts = random_states(batch.simulator(0).model(), n, 3);
    let inputs = random_inputs(n * STEPS * nu, 4);
    let rollout = batch.rollout_inputs(&starts, STEPS, &inputs);
    let mut states = batch.states(&starts);
    for step in 0..STEPS {
        let now = |i: usize| &inputs[(i * STEPS + step) * nu..][..nu];
        let all: Vec<f64> = (0..n).flat_map(now).copied().collect();
        batch.step(&mut states, &all);
    }
    for (i, start) in starts.iter().enumerate() {
        let single = batch.simulator(i).rollout(start, STEPS, |time, _, u| {
            let step = (time / batch.simulator(i).time_step()).round() as usize;
            u.copy_from_slice(&inputs[(i * STEPS + step) * nu..][..nu]);
        });
        let name = batch.simulator(i).model().name();
        let what = format!("{name}, state {i} of {n}, {what}");
        assert_eq!(rollout.status(i), single.status, "{what}");
        assert_eq!(rollout.n_states(i), single.states.len(), "{what}");
        for (k, state) in single.states.iter().enumerate() {
            assert_same_bits(&rollout.state(i, k), state, &format!("{what}, step {k}"));
        }
        assert_same_bits(&states.state(i), single.last(), &what);
    }
}

#[test]
fn batch_equals_single_simulators_bit_for_bit() {
    for simulator in simulators() {
        for n in [1, BATCH_WIDTH, STATES] {
            let mut batch = BatchSimulator::new(simulator.clone(), n);
            assert_equals_singles(&mut batch, "one robot");
            assert_equals_singles(&mut batch.with_states_one_by_one(), "one by one");
        }
    }
}

#[test]
fn batch_of_variants_equals_simulators_of_the_variants_bit_for_bit() {
    for simulator in simulators() {
        let models = variants(simulator.model(), STATES);
        let mut batch = BatchSimulator::of_variants(&simulator, models).expect("variants");
        assert_equals_singles(&mut batch, "variants");
        assert_equals_singles(&mut batch.with_states_one_by_one(), "variants, one by one");
    }
}

fn fingerprint(rollout: &BatchRollout) -> Vec<u64> {
    let rows = (0..rollout.len()).flat_map(|i| rollout.rows(i));
    rows.map(|x| x.to_bits()).collect()
}

#[test]
fn rollouts_on_several_threads_equal_those_on_one() {
    let simulator = Simulator::new(floating_robot()).with_time_step(0.01);
    let starts = random_states(simulator.model(), STATES, 1);
    let inputs = random_inputs(STATES * STEPS * simulator.nu(), 2);
    let on = |threads: usize| {
        let mut batch = BatchSimulator::new(simulator.clone(), STATES).with_threads(threads);
        fingerprint(&batch.rollout_inputs(&starts, STEPS, &inputs))
    };
    let one = on(1);
    for threads in [2, 3, 16] {
        assert!(on(threads) == one, "{threads} threads");
    }
}

// The state is moved through all lanes and groups, among ever other neighbours.
#[test]
fn a_state_has_the_same_trajectory_at_every_place() {
    let simulator = Simulator::new(floating_robot()).with_time_step(0.01);
    let starts = random_states(simulator.model(), STATES, 5);
    let mut batch = BatchSimulator::new(simulator.clone(), STATES);
    let alone = simulator.rollout(&starts[0], STEPS, |_, _, u| u.fill(0.2));
    for place in 0..STATES {
        let mut moved = starts.clone();
        moved.rotate_right(place);
        let rollout = batch.rollout(&moved, STEPS, |_, _, u| u.fill(Lanes::from(0.2)));
        assert_same_bits(
            &rollout.last(place),
            alone.last(),
            &format!("place {place}"),
        );
    }
}

/// Pushes the k-th state beyond all numbers from the given step on.
fn blow_up(simulator: &Simulator, starts: &[State], at: usize, kick: f64) -> BatchRollout {
    let mut batch = BatchSimulator::new(simulator.clone(), starts.len());
    if at % 2 == 1 {
        batch = batch.with_states_one_by_one();
    }
    batch.rollout(starts, STEPS, |moment, _, u| {
        let kicked = |i: usize| i == at && moment.step >= 5;
        u[0] = moment.gather(|i| if kicked(i) { kick } else { 0.1 });
    })
}

#[test]
fn lanes_next_to_a_diverging_one_equal_those_next_to_a_calm_one() {
    let simulator = Simulator::new(samples::double_pendulum()).with_time_step(0.01);
    let starts = random_states(simulator.model(), STATES, 6);
    let calm = blow_up(&simulator, &starts, STATES, 0.0);
    for at in 0..STATES {
        for kick in [1e200, f64::NAN, f64::INFINITY] {
            let rollout = blow_up(&simulator, &starts, at, kick);
            for i in (0..STATES).filter(|&i| i != at) {
                assert_eq!(rollout.status(i), RolloutStatus::Completed);
                assert_eq!(
                    rollout.rows(i),
                    calm.rows(i),
                    "state {i} next to {at}, {kick}"
                );
            }
            let single = simulator.rollout(&starts[at], STEPS, |time, _, u| {
                u[0] = if time > 0.045 { kick } else { 0.1 };
            });
            assert_ne!(single.status, RolloutStatus::Completed);
            assert_eq!(rollout.status(at), single.status);
            assert_same_bits(&rollout.last(at), single.last(), "the last finite state");
        }
    }
}

#[test]
fn a_stopped_state_waits_until_it_is_set() {
    let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    let starts = random_states(simulator.model(), 3, 7);
    let mut batch = BatchSimulator::new(simulator.clone(), 3);
    let mut states = batch.states(&starts);
    batch.step(&mut states, &[0.0, f64::NAN, 0.0]);
    batch.step(&mut states, &[0.0; 3]);
    assert_eq!(states.status(1), RolloutStatus::NonFiniteInput { step: 0 });
    assert_eq!(states.state(1), starts[1]);
    let other = simulator.step(&simulator.step(&starts[2], &[0.0]), &[0.0]);
    assert_eq!(states.state(2), other);

    states.set(1, &starts[0]);
    assert_eq!(states.status(1), RolloutStatus::Completed);
    batch.step(&mut states, &[0.0; 3]);
    assert_eq!(states.state(1), simulator.step(&starts[0], &[0.0]));
}

#[test]
fn linearizations_equal_those_of_single_simulators() {
    let simulator = Simulator::new(floating_robot()).with_time_step(0.01);
    let states = random_states(simulator.model(), STATES, 8);
    let nu = simulator.nu();
    let inputs = random_inputs(STATES * nu, 9);
    let models = variants(simulator.model(), STATES);
    let batch = BatchSimulator::of_variants(&simulator, models).expect("variants");
    let all = batch.with_threads(3);
    for (i, own) in all.linearize(&states, &inputs).iter().enumerate() {
        let (u, single) = (&inputs[i * nu..(i + 1) * nu], all.simulator(i));
        let (mut scratch, mut out) = (LinearizeScratch::new(single), Linearization::zeros(single));
        single.linearize_into(&states[i], u, &mut scratch, &mut out);
        assert_eq!(*own, out, "state {i}");
        assert_eq!(single.linearize(&states[i], u), out, "state {i}, at once");
    }
}

#[test]
fn batches_without_states_do_nothing() {
    let simulator = Simulator::new(samples::cartpole());
    for mut batch in [
        BatchSimulator::new(simulator.clone(), 0),
        BatchSimulator::of_variants(&simulator, Vec::new()).expect("no variants"),
    ] {
        let mut states = batch.states(&[]);
        batch.step(&mut states, &[]);
        assert!(states.len() == 0 && batch.rollout_inputs(&[], 5, &[]).len() == 0);
        assert!(batch.linearize(&[], &[]).is_empty());
    }
}

#[test]
fn models_that_differ_in_structure_are_refused_with_the_first_difference() {
    let cases = [
        (
            samples::cartpole(),
            samples::pendulum(),
            "model 1, \"pendulum\", is not a variant of the first: it has 1 bodies, not 2",
        ),
        (
            samples::double_pendulum(),
            samples::cartpole(),
            "joint 0 is",
        ),
    ];
    for (first, other, expected) in cases {
        let simulator = Simulator::new(first.clone());
        let error = BatchSimulator::of_variants(&simulator, vec![first.clone(), other.clone()])
            .expect_err(expected);
        assert!(error.to_string().contains(expected), "{error}");
        let direct = Model::<Lanes<2>>::side_by_side([&first, &other]);
        assert_eq!(direct.expect_err(expected), error);
    }
}
